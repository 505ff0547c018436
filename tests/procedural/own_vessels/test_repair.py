"""What is mended in the files of vessels, and that a thickness for open surfaces refuses nothing else."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import trimesh

from glassware.core.errors import InputError
from glassware.core.mesh import volume_of
from glassware.procedural.cavities.interior import interior_of
from glassware.procedural.own_vessels.files import vessel_files
from glassware.procedural.own_vessels.shape import OwnShape, own_shape
from glassware.procedural.own_vessels.sheets import holes_filled
from glassware.procedural.vessels.settings import VesselSettings


def shape(path: Path, **settings: object) -> OwnShape:
    return own_shape(vessel_files(path)[0], VesselSettings.model_validate(settings))


def without(mesh: trimesh.Trimesh, *faces: int) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices, np.delete(np.array(mesh.faces), faces, axis=0), process=False)


def test_a_small_hole_in_a_beaker_is_filled_before_open_surfaces_get_a_thickness(
    own_shapes: ModuleType, tmp_path: Path
) -> None:
    mesh = own_shapes.beaker(64, rows=40)
    path = own_shapes.saved(without(mesh, 1000), tmp_path / "b.ply")
    for settings in ({}, {"shell": 0.002}):
        assert volume_of(shape(path, **settings).solid) == pytest.approx(mesh.volume, rel=1e-3)


def test_a_hole_in_the_side_of_a_sheet_is_filled_and_a_narrow_mouth_stays() -> None:
    rings = [(0.004, z) for z in np.linspace(0.0, 0.3, 31)]
    tube = trimesh.creation.revolve(np.array(rings), sections=24)
    faces = np.delete(np.array(tube.faces), 700, axis=0)
    assert len(holes_filled(tube.vertices, faces, in_sides=True)) == len(tube.faces)
    assert len(holes_filled(tube.vertices, faces)) == len(tube.faces) + 2 * 22  # both mouths, without a thickness


def test_closed_bodies_beside_an_open_one_keep_their_walls(own_shapes: ModuleType, tmp_path: Path) -> None:
    beaker, label = own_shapes.beaker(48), own_shapes.sheet().apply_translation([0.1, 0.0, 0.0])
    found = shape(own_shapes.saved(own_shapes.with_bodies(beaker, label), tmp_path / "b.ply"), shell=0.003)
    floors = sorted(hollow.volume for hollow in interior_of(found.solid).hollows)
    assert floors[1] == pytest.approx(own_shapes.capacity(48), rel=0.03)
    assert floors[0] == pytest.approx(own_shapes.capacity(64, 0.003), rel=0.03)


def test_an_edge_that_others_end_on_is_split_there(own_shapes: ModuleType, tmp_path: Path) -> None:
    mesh = own_shapes.beaker(48)
    a, b, c = mesh.faces[10]
    vertices = np.vstack([mesh.vertices, mesh.vertices[[a, b]].mean(0)])
    new = len(mesh.vertices)
    faces = np.vstack([np.delete(mesh.faces, 10, axis=0), [[a, new, c], [new, b, c]]])
    path = own_shapes.saved(trimesh.Trimesh(vertices, faces, process=False), tmp_path / "b.ply")
    for settings in ({}, {"shell": 0.002}):
        assert volume_of(shape(path, **settings).solid) == pytest.approx(mesh.volume, rel=1e-4)


@pytest.mark.parametrize("suffix", ["ply", "stl"])
@pytest.mark.parametrize("mirrored", [True, False], ids=["same diagonals", "other diagonals"])
def test_bodies_that_share_a_face_become_one(
    own_shapes: ModuleType, tmp_path: Path, suffix: str, mirrored: bool
) -> None:
    box = trimesh.creation.box((0.05, 0.05, 0.05))
    other = trimesh.Trimesh(box.vertices * [-1, 1, 1], box.faces[:, ::-1], process=False) if mirrored else box.copy()
    two = own_shapes.with_bodies(box, other.apply_translation([0.05, 0, 0]))
    found = shape(own_shapes.saved(two, tmp_path / f"two.{suffix}"))
    assert volume_of(found.solid) == pytest.approx(2 * 0.05**3, rel=1e-5)


def test_a_base_of_its_own_under_a_beaker_becomes_part_of_it(own_shapes: ModuleType, tmp_path: Path) -> None:
    beaker = own_shapes.beaker(48)
    base = trimesh.creation.revolve(
        np.array([(0.0, -0.005), (own_shapes.RADIUS, -0.005), (own_shapes.RADIUS, 0.0), (0.0, 0.0)]), sections=48
    )
    found = shape(own_shapes.saved(own_shapes.with_bodies(beaker, base), tmp_path / "b.stl"))
    assert volume_of(found.solid) == pytest.approx(beaker.volume + base.volume, rel=1e-4)
    assert interior_of(found.solid).hollows[0].volume == pytest.approx(own_shapes.capacity(48), rel=0.01)


def test_bodies_that_touch_along_an_edge_are_refused_for_that(own_shapes: ModuleType, tmp_path: Path) -> None:
    box = trimesh.creation.box((0.05, 0.05, 0.05))
    two = own_shapes.with_bodies(box, box.copy().apply_translation([0.05, 0.05, 0.0]))
    with pytest.raises(InputError, match=r"touch along an edge, at \(25\.0, 25\.0, "):
        shape(own_shapes.saved(two, tmp_path / "two.stl"))


def test_walls_that_are_too_thin_to_be_found_are_not_taken_for_a_solid(own_shapes: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"walls of at least 0\.11 mm in a vessel of this width, found walls of 0\.01 mm"
    ):
        shape(own_shapes.saved(own_shapes.beaker(48, 1e-5), tmp_path / "b.ply"))


def test_a_size_that_several_units_explain_names_them_all(own_shapes: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"--vessels\.unit cm makes it 0\.09 m, in makes it 0\.229 m\)"):
        shape(own_shapes.saved(own_shapes.beaker(), tmp_path / "b.obj", 100))
