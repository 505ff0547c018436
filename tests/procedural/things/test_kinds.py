"""Everyday things: closed, as large as real ones, of named parts, and never twice the same."""

from __future__ import annotations

import time
from functools import cache

import numpy as np
import pytest

from glassware.core.mesh import check_closed
from glassware.core.randomness import stream
from glassware.core.weighted import weights_of
from glassware.procedural.description.material import SurfaceTexture
from glassware.procedural.description.material_list import materials_of
from glassware.procedural.description.scene import Prop
from glassware.procedural.primitives.scenes import camera, scene
from glassware.procedural.props.draw import PropSettings
from glassware.procedural.props.kinds import DEFAULT_KINDS, PROP_KINDS
from glassware.procedural.scene.scene_file import load_scene, save_scene
from glassware.procedural.scene.validate import check_scene
from glassware.procedural.things.draw import draw_prop_of_kind, prop_pose
from glassware.procedural.things.kinds import KINDS
from glassware.procedural.things.parts import as_prop

SEEDS = range(4)
#: Most triangles of a thing [1], and most time to draw one, the fastest of several [s].
MOST_FACES, MOST_SECONDS = 20_000, 0.3
#: Least and greatest length on the surface that a unit of texture coordinates times its extent shows [m/m], over the
#: area of a part: 1 but where a surface is round or seen askew from the side that it is projected from (35 degrees at
#: a cube's corner), and by the girth of a fruit that is no sphere.
LEAST_SCALE, MOST_SCALE = 0.62, 1.35


@cache
def _thing(kind: str, seed: int) -> Prop:
    return _drawn(kind, seed)


def _drawn(kind: str, seed: int, wear: float = 0.5) -> Prop:
    return as_prop(KINDS[kind].draw(stream(seed, 0, kind), wear), kind, id=2, name="prop-00")


@pytest.mark.parametrize("kind", KINDS)
def test_a_thing_is_closed_and_has_the_size_of_a_real_one(kind: str) -> None:
    low, high = KINDS[kind].longest
    for seed in SEEDS:
        prop = _thing(kind, seed)
        check_closed(kind, prop.mesh)
        assert low <= max(prop.size) <= high
        assert prop.size == pytest.approx(np.ptp(prop.mesh.bounds, axis=0))
        assert np.abs(prop.mesh.bounds.sum(axis=0)).max() < 1e-6
        assert len(prop.mesh.faces) < MOST_FACES


@pytest.mark.parametrize("kind", KINDS)
def test_parts_have_names_and_materials_and_no_two_things_are_alike(kind: str) -> None:
    props = [_thing(kind, seed) for seed in SEEDS]
    for prop in props:
        assert sum(piece.faces for piece in prop.pieces) == len(prop.mesh.faces)
        assert all(piece.faces > 0 and piece.material.name for piece in prop.pieces)
        assert all(part.name for part in prop.parts)
        assert len({part.name for part in prop.parts}) == len(prop.parts)
        colours = [piece.material.base_colour for piece in prop.pieces]
        assert any(isinstance(colour, SurfaceTexture) for colour in colours)
    assert len({prop.mesh.vertices.tobytes() for prop in props}) == len(props)
    again = _drawn(kind, 0)
    assert np.array_equal(again.mesh.vertices, props[0].mesh.vertices)
    assert again.pieces == props[0].pieces


@pytest.mark.parametrize("kind", KINDS)
def test_textures_are_at_the_scale_of_the_thing(kind: str) -> None:
    prop = _thing(kind, 1)
    mesh, first = prop.mesh, 0
    assert mesh.uv is not None
    for piece in prop.pieces:
        faces = mesh.faces[first : first + piece.faces]
        first += piece.faces
        texture = piece.material.base_colour
        if not isinstance(texture, SurfaceTexture):
            continue
        across, up = piece.material.repeats, piece.material.repeats_v or piece.material.repeats
        shown = mesh.uv[faces].astype(float) * [across, up] * texture.extent  # [m]
        corners = mesh.vertices[faces].astype(float)
        on_surface = np.linalg.norm(np.cross(*_sides(corners)), axis=1)
        in_texture = np.abs(np.cross(*(np.pad(side, ((0, 0), (0, 1))) for side in _sides(shown)))[:, 2])
        # The scale of the whole part, by areas.
        assert LEAST_SCALE < np.sqrt(in_texture.sum() / on_surface.sum()) < MOST_SCALE, piece.material.name


def _sides(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]


@pytest.mark.parametrize("kind", KINDS)
def test_a_thing_is_drawn_in_a_moment(kind: str) -> None:
    seconds = []
    for seed in (1, 2):
        begun = time.process_time()
        _drawn(kind, seed)
        seconds.append(time.process_time() - begun)
    assert min(seconds) < MOST_SECONDS


def test_settings_name_all_kinds_and_a_kind_can_be_chosen() -> None:
    assert set(PROP_KINDS) == {"shape", *KINDS}
    assert set(weights_of(DEFAULT_KINDS)) == set(PROP_KINDS)
    settings = PropSettings.model_validate({"kinds": {"book": 3, "can": 1}})
    drawn = [
        draw_prop_of_kind(stream(1, n, "a"), stream(1, n, "b"), settings, id=2, name="p").category for n in range(40)
    ]
    # Three quarters of 40, and three and a half standard deviations.
    assert 20 <= drawn.count("book") <= 39
    assert set(drawn) == {"book", "can"}


def test_an_unknown_kind_is_named_with_the_nearest_one() -> None:
    with pytest.raises(ValueError, match=r"bok.*book"):
        PropSettings.model_validate({"kinds": ["bok"]})


def test_without_things_shapes_are_what_they_were() -> None:
    from glassware.procedural.props.draw import draw_prop

    settings = PropSettings.model_validate({"kinds": ["shape"]})
    one = draw_prop_of_kind(stream(3, 0, "a"), stream(3, 0, "b"), settings, id=2, name="p")
    other = draw_prop(stream(3, 0, "a"), settings, id=2, name="p")
    assert isinstance(one, Prop)
    assert isinstance(other, Prop)
    assert np.array_equal(one.mesh.vertices, other.mesh.vertices)
    assert one.material == other.material


def test_a_mug_stands_and_its_file_says_what_it_is_made_of(tmp_path) -> None:
    prop = _thing("mug", 2)
    poses = [prop_pose(prop, stream(n, 0, "pose")) for n in range(40)]
    # Nine of ten, and four standard deviations.
    assert sum(abs(pose[2, 2] - 1.0) < 1e-9 for pose in poses) >= 28
    for pose in poses:
        lowest = (prop.mesh.vertices @ pose[:3, :3].T + pose[:3, 3])[:, 2].min()
        assert lowest == pytest.approx(0.0, abs=1e-7)
    book = _thing("book", 2).model_copy(update={"world_T_object": _on_table(_thing("book", 2))})
    whole = scene([], [camera((0.3, -0.3, 0.3))], props=[book])
    check_scene(whole)
    save_scene(whole, tmp_path / "scene.json")
    again = load_scene(tmp_path / "scene.json")
    assert again.props[0].parts == book.parts
    assert [part.name for part in again.props[0].parts] == ["cover", "inside of the cover", "leaves"]
    assert [material.name for material in materials_of(again)[2:]] == [part.material.name for part in book.parts]


def _on_table(prop: Prop) -> np.ndarray:
    pose = np.eye(4)
    pose[2, 3] = 1e-4 - prop.mesh.bounds[0, 2]
    return pose
