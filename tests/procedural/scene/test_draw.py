"""Drawn scenes as wholes: sound bodies that stand on the table, apart, in every picture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from glassware.core.errors import InputError
from glassware.core.json_file import json_text
from glassware.core.mesh import Mesh, as_trimesh
from glassware.procedural.description.scene import GlassBody, Prop, Scene, SceneObject, glass_solid, liquid_solid
from glassware.procedural.description.standing import standing_in
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.scene_file import load_scene, save_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.surroundings.table import outline
from glassware.render.renderer import Renderer

#: Most that bodies may overlap, float or sink [m] (the promise of a drawn scene).
SLACK = 5e-4
#: Points on each body that are tried against every other.
PROBES = 2000
#: Seeds of the proof without files, one of them quick, and of the one with real files.
SEEDS, LONG = [0, pytest.param(1, marks=pytest.mark.slow), pytest.param(2, marks=pytest.mark.slow)], range(20)
#: Skies alone: a room is most of the work of drawing, and changes nothing on the table.
SKY = {"room_share": 0.0, "shipped_share": 0.0}
ROOM = SKY | {"room_share": 1.0}
#: Meshes as their content, and what placement sets.
_DIGESTS = {"write_mesh": lambda mesh: mesh.vertices.tobytes().hex() + mesh.faces.tobytes().hex()}
_PLACE = {"world_T_object"}


def _settings(assets: Path | None = None, environment: dict | None = None) -> SceneSettings:
    # Piles, and vessels on trays, have tests of their own, in tests/procedural/physics and test_supports.py.
    files: dict[str, Any] = {"environment": environment or {}}
    if assets is not None:
        files = {"mesh_dir": assets / "meshes", "texture_dir": assets / "textures"}
        files["environment"] = {"hdri_dir": assets / "hdri"}
    return SceneSettings.model_validate(
        {
            "cameras": {"views": 5, "width": 64, "height": 48},
            "picture": {"spp": 4},
            "physics": {"piled_probability": 0.0},
            "placement": {"carried_probability": 0.0},
            **files,
        }
    )


def _body(item) -> Mesh:
    return item.mesh if isinstance(item, Prop) else glass_solid(item)


def _placed(item) -> np.ndarray:
    """Vertices in the world frame, (n, 3) float64."""
    return _body(item).vertices @ item.world_T_object[:3, :3].T + item.world_T_object[:3, 3]


def _probes(item, rng: np.random.Generator) -> np.ndarray:
    """Points spread over the surface of a body, world frame, (n, 3)."""
    solid = as_trimesh(_body(item), item.world_T_object)
    face = rng.choice(len(solid.faces), PROBES, p=solid.area_faces / solid.area_faces.sum())
    weights = rng.dirichlet(np.ones(3), PROBES)
    return (solid.triangles[face] * weights[..., None]).sum(1)


def _deepest(points: np.ndarray, hull: ConvexHull) -> float:
    """How far the deepest of the points lies inside a convex hull [m]; 0 or less outside."""
    near = points[((points > hull.min_bound) & (points < hull.max_bound)).all(1)]  # no other can be inside
    return float(-(near @ hull.equations[:, :3].T + hull.equations[:, 3]).max(1).min(initial=0.0))


def _check_bodies(scene: Scene) -> None:
    for vessel in scene.vessels:
        assert as_trimesh(glass_solid(vessel)).is_volume, vessel.name
        pieces = [piece for other in standing_in(scene.objects, vessel) for piece in other.pieces]
        for number in range(len(vessel.liquids)):
            assert as_trimesh(liquid_solid(vessel, number, pieces)).is_volume, vessel.name


def _check_standing(scene: Scene) -> None:
    board = outline(scene.table)
    sides = ConvexHull(board).equations
    for group in _groups(scene):
        # A vessel stands with what goes with it: a flask on its ring.
        lowest = min(_placed(item)[:, 2].min() for item in group)
        assert abs(lowest) <= SLACK, group[0].name
        for item in group:
            points = _placed(item)
            assert points[:, 2].min() > (-SLACK if item.within is None else 0.0), item.name
            assert (points[:, :2] @ sides[:, :2].T + sides[:, 2]).max() <= 0.0, item.name


def _groups(scene: Scene) -> list[list[SceneObject]]:
    """Objects of their own, each with its parts and what leans in it."""
    hosts = [item for item in scene.objects if item.part_of is None and item.within is None]
    return [[host, *(item for item in scene.objects if host.name in (item.part_of, item.within))] for host in hosts]


def _check_apart(scene: Scene, rng: np.random.Generator, media_rays: ModuleType) -> None:
    # A body lies within its hull, so bodies overlap by no more than the one's surface goes into the other's hull.
    groups = _groups(scene)
    assert sum(map(len, groups)) == len(scene.objects)
    hulls = [ConvexHull(np.concatenate([_placed(item) for item in group])) for group in groups]
    probes = [np.concatenate([_probes(item, rng) for item in group]) for group in groups]
    for i, hull in enumerate(hulls):
        for j, points in enumerate(probes):
            assert i == j or _deepest(points, hull) <= SLACK, (groups[i][0].name, groups[j][0].name)
    # A straw lies in the hull of its tumbler, and a label on it, but no part of them in its glass.
    for host, *others in groups:
        placed = replace(_body(host), vertices=_placed(host), normals=None, uv=None)
        for item in others:
            some = _probes(item, rng)[:: PROBES // 200]
            assert not media_rays.winding(placed, some).round().any(), (item.name, host.name)


def _check_in_view(scene: Scene) -> None:
    for number, camera in enumerate(scene.cameras):
        for pose in (camera.world_T_camera, camera.world_T_right):
            for item in scene.objects:
                local = (_placed(item) - pose[:3, 3]) @ pose[:3, :3]
                assert local[:, 2].min() > 0.0
                pixels = camera.focal * local[:, :2] / local[:, 2:] + np.array(camera.centre)
                inside = (pixels >= -0.5) & (pixels <= np.array([camera.width, camera.height]) - 0.5)
                assert inside.all(), (number, item.name)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_drawn_scene_is_sound(seed, rng, media_rays):
    scene = draw_scene(_settings(environment=SKY), seed, 0)
    hosts = [host for host, *_ in _groups(scene)]
    assert 1 <= sum(isinstance(host, GlassBody) for host in hosts) <= 7
    assert 0 <= sum(isinstance(host, Prop) for host in hosts) <= 8
    assert [item.id for item in scene.objects] == list(range(2, 2 + len(scene.objects)))
    for check in (_check_bodies, _check_standing, _check_in_view):
        check(scene)
    _check_apart(scene, rng, media_rays)


@pytest.mark.slow
@pytest.mark.parametrize("seed", LONG)
def test_twenty_scenes_with_real_files_are_sound_and_render(seed, rng, media_rays, shared_assets, backend):
    scene = draw_scene(_settings(shared_assets), seed, 0)
    for check in (_check_bodies, _check_standing, _check_in_view):
        check(scene)
    _check_apart(scene, rng, media_rays)
    # Warnings are errors in these tests.
    frame = Renderer(scene).frame(0)
    assert np.isfinite(frame.left).all()
    assert frame.left.max() > 0.0


def test_the_probes_see_bodies_that_overlap(rng, media_rays):
    settings = _settings(environment=SKY).model_copy(update={"vessel_count": (2, 2), "prop_count": (0, 0)})
    scene = draw_scene(settings, 1, 0)
    one, two = scene.vessels
    pose = two.world_T_object.copy()
    pose[:2, 3] = one.world_T_object[:2, 3] + [max(one.size[0], two.size[0]) / 4, 0.0]
    moved = scene.model_copy(update={"vessels": (one, two.model_copy(update={"world_T_object": pose}))})
    with pytest.raises(AssertionError):
        _check_apart(moved, rng, media_rays)


@pytest.mark.parametrize("environment", [SKY, pytest.param(ROOM, marks=pytest.mark.slow)])
def test_a_scene_depends_on_its_seed_and_number_alone(environment):
    def written(scene: Scene) -> tuple[str, list[bytes]]:
        meshes: list[bytes] = []
        data = scene.model_dump(
            mode="json", context={"write_mesh": lambda mesh: meshes.append(mesh.vertices.tobytes()) or mesh.name}
        )
        return json_text(data), meshes

    settings = _settings(environment=environment).model_copy(update={"vessel_count": (2, 2), "prop_count": (2, 2)})
    first = written(draw_scene(settings, 5, 3))
    others = [written(draw_scene(settings, *key)) for key in ((5, 4), (6, 3))]
    assert written(draw_scene(settings, 5, 3)) == first
    assert all(other[1] != first[1] for other in others)


def test_one_more_prop_changes_no_vessel():
    base = _settings(environment=SKY).model_copy(update={"vessel_count": (2, 2)})
    few, many = (draw_scene(base.model_copy(update={"prop_count": (n, n)}), 5, 0) for n in (1, 2))
    assert len(few.props) < len(many.props)
    hosts = [[item for item in scene.vessels if item.part_of is None and item.within is None] for scene in (few, many)]
    assert [len(some) for some in hosts] == [2, 2]
    for one, two in zip(*hosts, strict=True):
        left, right = (item.model_dump(mode="json", context=_DIGESTS, exclude=_PLACE) for item in (one, two))
        assert left == right


def test_a_bare_table_is_a_scene():
    settings = _settings(environment=SKY).model_copy(update={"vessel_count": (0, 0), "prop_count": (0, 0)})
    scene = draw_scene(settings, 1, 0)
    assert scene.objects == ()
    assert len(scene.cameras) == 5
    assert trimesh.Trimesh(scene.table.mesh.vertices, scene.table.mesh.faces).bounds[1, 2] == 0.0


def test_a_scene_with_own_media_is_stored_whole(tmp_path):
    path = tmp_path / "media.yaml"
    path.write_text("syrup: {index: 1.43, absorption: [1.0, 2.0, 9.0]}\nmy glass: {index: 1.6}\n", "utf-8")
    vessels = {"media": path, "liquids": "syrup", "glasses": "my glass", "fill": "80ml", "fill_probability": 1.0}
    few = {"vessel_count": (1, 1), "prop_count": (0, 0), "environment": {"room_share": 0.0}}
    scene = draw_scene(SceneSettings.model_validate(few | {"vessels": vessels}), 4, 0)
    save_scene(scene, tmp_path / "scene.json")
    path.unlink()
    (vessel,) = load_scene(tmp_path / "scene.json").vessels
    assert vessel.liquid is not None
    assert (vessel.glass.eta, vessel.liquid.medium.eta, vessel.liquid.medium.sigma_a) == (1.6, 1.43, (1.0, 2.0, 9.0))
    assert vessel.liquid == scene.vessels[0].liquid


def test_objects_that_do_not_fit_as_they_were_turned_are_placed_again_and_counted():
    settings = SceneSettings.model_validate(
        {
            "vessel_count": (1, 1),
            "prop_count": (1, 1),
            "props": {"kinds": ["napkin"]},  # up to 40 cm, on a board of 41 cm with an edge of 3 cm to keep free
            "table": {"kinds": "plain", "smallest": 0.41, "largest": 0.42, "round_share": 0.0},
            "vessels": {"categories": ["tumbler"], "fill_probability": 0.0},
            "placement": {"carried_probability": 0.0},
            "physics": {"piled_probability": 0.0},
        }
    )
    assert [draw_scene(settings, 5, number).placed_again > 0 for number in (0, 12, 13)] == [False, True, True]
    with pytest.raises(InputError, match=r"expected objects that fit on the table of 0\.4\d x 0\.4\d m, found 2"):
        draw_scene(settings, 5, 5)
