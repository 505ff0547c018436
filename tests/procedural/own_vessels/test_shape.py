"""Files of vessels: what is read, repaired, measured, and refused with the reason and the place."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import trimesh

from glassware.core.errors import InputError
from glassware.core.mesh import check_closed, volume_of
from glassware.procedural.cavities.interior import interior_of
from glassware.procedural.optics.catalogue import glass_named
from glassware.procedural.own_vessels.files import vessel_files
from glassware.procedural.own_vessels.shape import OwnShape, own_shape
from glassware.procedural.own_vessels.usable import checked_vessels
from glassware.procedural.vessels.settings import VesselSettings


def shape(path: Path, **settings: object) -> OwnShape:
    return own_shape(vessel_files(path)[0], VesselSettings.model_validate(settings))


@pytest.mark.parametrize(
    ("suffix", "unit", "scale"), [("obj", "mm", 1e3), ("ply", "cm", 1e2), ("stl", "in", 1 / 0.0254)]
)
def test_formats_and_units_give_one_beaker(
    own_shapes: ModuleType, tmp_path: Path, suffix: str, unit: str, scale: float
) -> None:
    found = shape(own_shapes.saved(own_shapes.beaker(), tmp_path / f"b.{suffix}", scale), unit=unit)
    assert np.ptp(found.solid.bounds, axis=0) == pytest.approx(
        [2 * own_shapes.RADIUS, 2 * own_shapes.RADIUS, own_shapes.HEIGHT], abs=1e-6
    )
    assert volume_of(found.solid) == pytest.approx(own_shapes.beaker().volume, rel=1e-4)
    assert found.symmetric


def test_a_glb_is_turned_upright(own_shapes: ModuleType, tmp_path: Path) -> None:
    lying = own_shapes.beaker().apply_transform(trimesh.transformations.rotation_matrix(-0.5 * np.pi, [1, 0, 0]))
    found = shape(own_shapes.saved(lying, tmp_path / "b.glb"))
    assert len(interior_of(found.solid).hollows) == 1


@pytest.mark.parametrize("scale", [300.0, 0.003])
def test_a_size_that_no_vessel_has_is_asked_back(own_shapes: ModuleType, tmp_path: Path, scale: float) -> None:
    with pytest.raises(InputError, match=r"longest side has 10 mm to 0\.7 m, found .* no unit is stated"):
        shape(own_shapes.saved(own_shapes.beaker(), tmp_path / "b.obj", scale))


def test_a_size_that_another_unit_explains_names_it(own_shapes: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"found 90 m in metres.*\(--vessels\.unit mm makes it 0\.09 m\)"):
        shape(own_shapes.saved(own_shapes.beaker(), tmp_path / "b.obj", 1e3))


def test_the_fullest_way_up_is_found(own_shapes: ModuleType, tmp_path: Path) -> None:
    lying = own_shapes.beaker(32).apply_transform(trimesh.transformations.rotation_matrix(0.5 * np.pi, [0, 1, 0]))
    found = shape(own_shapes.saved(lying, tmp_path / "b.obj"), up="fullest")
    assert len(interior_of(found.solid).hollows) == 1


def test_a_handle_of_its_own_becomes_part_of_the_cup(own_shapes: ModuleType, tmp_path: Path) -> None:
    found = shape(
        own_shapes.saved(own_shapes.with_bodies(own_shapes.beaker(), own_shapes.handle(0.0015)), tmp_path / "cup.obj")
    )
    check_closed("cup", found.solid)
    assert volume_of(found.solid) < own_shapes.beaker().volume + own_shapes.handle(0.0015).volume
    assert not found.symmetric


def test_faces_that_look_the_wrong_way_and_small_holes_are_mended(own_shapes: ModuleType, tmp_path: Path) -> None:
    mesh = own_shapes.beaker(rows=40)
    small = int(np.argmin(mesh.area_faces))
    faces = np.delete(np.array(mesh.faces), small, axis=0)
    faces[::3] = faces[::3, ::-1]
    mesh = trimesh.Trimesh(mesh.vertices, faces, process=False)
    found = shape(own_shapes.saved(mesh, tmp_path / "b.ply"))
    assert volume_of(found.solid) == pytest.approx(own_shapes.beaker(rows=40).volume, rel=1e-3)


def test_a_sheet_is_refused_without_a_thickness_and_gets_one(own_shapes: ModuleType, tmp_path: Path) -> None:
    path = own_shapes.saved(own_shapes.sheet(), tmp_path / "sheet.obj")
    with pytest.raises(InputError, match=r"--vessels\.shell 2mm\), found an open one: 64 loose edges.*at \("):
        shape(path)
    found = shape(path, shell=own_shapes.WALL)
    assert interior_of(found.solid).wall == pytest.approx(own_shapes.WALL, rel=0.05)
    assert np.ptp(found.solid.bounds, axis=0)[2] == pytest.approx(own_shapes.HEIGHT, abs=1e-5)


def test_a_surface_that_crosses_itself_is_refused_with_the_place(own_shapes: ModuleType, tmp_path: Path) -> None:
    mesh = own_shapes.beaker(rows=20)
    vertices = np.array(mesh.vertices)
    within = (
        (np.hypot(*vertices[:, :2].T) < own_shapes.RADIUS - 0.5 * own_shapes.WALL)
        & (vertices[:, 2] > 0.02)
        & (vertices[:, 2] < 0.07)
    )
    vertices[within, :2] *= 1.2
    with pytest.raises(InputError, match=r"does not cross itself, found one that does, at \("):
        shape(own_shapes.saved(trimesh.Trimesh(vertices, mesh.faces, process=False), tmp_path / "b.ply"))


def test_points_alone_become_a_solid(tmp_path: Path) -> None:
    points = trimesh.creation.icosphere(subdivisions=2, radius=0.03).vertices
    path = tmp_path / "ball.obj"
    path.write_text("o kp.000\n" + "".join("v {:.6f} {:.6f} {:.6f}\n".format(*point) for point in points))
    with pytest.raises(InputError, match="162 points alone"):
        shape(path)
    found = shape(path, shell=0.006)
    assert volume_of(found.solid) == pytest.approx(4.0 / 3.0 * np.pi * 0.033**3, rel=0.08)


def test_a_file_without_anything_is_refused(tmp_path: Path) -> None:
    (tmp_path / "empty.obj").write_text("# nothing\n")
    with pytest.raises(InputError, match="a mesh with faces, found none"):
        shape(tmp_path / "empty.obj")


def glb_with(path: Path, material: dict) -> None:
    """Give the only mesh of a GLB file a material."""
    content = path.read_bytes()
    length = int.from_bytes(content[12:16], "little")
    document = json.loads(content[20 : 20 + length])
    document["materials"] = [material]
    document["meshes"][0]["primitives"][0]["material"] = 0
    document["asset"]["copyright"] = "CC0"
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = content[20 + length :]
    total = 20 + len(text) + len(rest)
    path.write_bytes(b"glTF" + struct.pack("<III", 2, total, len(text)) + b"JSON" + text + rest)


def test_the_glass_and_the_licence_of_a_glb_are_read(own_shapes: ModuleType, tmp_path: Path) -> None:
    path = own_shapes.saved(own_shapes.beaker(24), tmp_path / "b.glb", 1e2)
    glass = {
        "KHR_materials_transmission": {"transmissionFactor": 1.0},
        "KHR_materials_ior": {"ior": 1.6},
        "KHR_materials_volume": {"attenuationColor": [0.5, 1.0, 0.25], "attenuationDistance": 1.0},
    }
    glb_with(path, {"name": "amber", "extensions": glass})
    ((file, _),), _ = checked_vessels(tmp_path, VesselSettings(unit="cm", up="z"))
    found = own_shape(file, VesselSettings(unit="cm", up="z"))
    assert found.glass is not None
    assert found.glass.eta == 1.6
    # The file's distances have the file's unit.
    assert np.exp(-0.01 * np.array(found.glass.sigma_a)) == pytest.approx([0.5, 1.0, 0.25])
    assert found.origin.licence == "CC0"
    assert found.origin.metres_per_unit == 0.01


def test_a_material_file_chooses_glass_by_its_name_or_its_index(own_shapes: ModuleType, tmp_path: Path) -> None:
    path = own_shapes.saved(own_shapes.beaker(24), tmp_path / "b.obj")
    faces = path.read_text()
    for material, index in (("Lead_Crystal", 1.5), ("dense", 1.7)):
        path.write_text(f"mtllib b.mtl\nusemtl {material}\n{faces}")
        (tmp_path / "b.mtl").write_text(f"newmtl {material}\nd 0.2\nNi {index}\n")
        glass = shape(path).glass
        assert glass is not None
        assert glass == glass_named("lead crystal") if material == "Lead_Crystal" else glass.eta == index


def test_a_layout_states_unit_and_category(own_shapes: ModuleType, tmp_path: Path) -> None:
    path = tmp_path / "models" / "obj_000001.ply"
    path.parent.mkdir()
    own_shapes.saved(own_shapes.beaker(24), path, 1e3)
    file = vessel_files(tmp_path)[0]
    assert file.category == "obj_000001"
    solid = own_shape(file, VesselSettings()).solid
    assert np.ptp(solid.bounds, axis=0)[2] == pytest.approx(own_shapes.HEIGHT, abs=1e-6)
