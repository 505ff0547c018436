"""Files after reports of other projects' users, beside this checkout: each as its users expect it.

The tests of `mesh_files`, `props`, `materials` and `surroundings` make files of the same kinds themselves.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.core.passed_over import Finding
from glassware.procedural.description.material import UniformTexture
from glassware.procedural.materials.surface_files import usable_surfaces
from glassware.procedural.mesh_files.model import FilePart, Source
from glassware.procedural.mesh_files.read import read_parts
from glassware.procedural.props.mesh_files import checked_meshes
from glassware.procedural.surroundings.hdri import usable_hdris

INPUTS = Path(__file__).resolve().parents[4] / "shared" / "inputs"
pytestmark = pytest.mark.skipif(not INPUTS.is_dir(), reason="the folder shared/inputs is not beside this checkout")

#: Of each folder of meshes: the object that is used, the kinds of its materials, its longest side [unit of the file],
#: and what is said of the folder.
USED = {
    "bopmm": ("obj_000001.ply", "no material", 60.0, ""),
    "case": ("m.obj", "picture", 0.08, ""),
    "concave": ("concave_ngon.obj", "no material", 0.09, ""),
    "gso": ("Toy_Block/meshes/model.obj", "picture", 0.08, ""),
    "kd1": ("m.obj", "uniform", 0.08, ""),
    "kdxyz": ("m.obj", "uniform", 0.08, ""),
    "libabs": ("m.obj", "picture", 0.08, ""),
    "lm": ("obj_000005.ply", "vertices", 80.0, ""),
    "mac": ("m.obj", "uniform", 0.08, ""),
    "mapka": ("backpack.obj", "picture", 0.08, ""),
    "missing_tex": ("m.obj", "uniform", 0.08, "m.mtl: expected the picture of material 'mat' ('polar_bear_eye.PNG')"),
    "multi": ("knob.obj", "uniform uniform", 0.12, ""),
    "nousemtl": ("textured.obj", "picture", 0.08, ""),
    "nsbad": ("m.obj", "uniform", 0.08, "expected a number for ns, found '1.#QNAN0'"),
    "optspace": ("m.obj", "picture", 0.08, ""),
    "parenttex": ("m.obj", "no material", 0.08, "found only one outside the folder"),
    "pybullet": ("YcbMug/textured_reoriented.obj", "picture", 0.08, ""),
    "rgbobj": ("rgb.obj", "vertices", 0.08, ""),
    "shapenet": (
        "03797390/10f6e09036350e92b3f21f1137c3c347/models/model_normalized.obj",
        "uniform picture",
        0.8,
        "no known size; one is drawn",
    ),
    "tga": ("m.obj", "picture", 0.08, ""),
    "unixpath": ("m.obj", "picture", 0.08, ""),
    "winpath": ("m.obj", "picture", 0.08, ""),
    "ycb": ("025_mug/google_16k/textured.obj", "picture", 0.08, ""),
    "ycbv": ("obj_000002.ply", "picture", 80.0, ""),
    "glb/alphamask": ("alphamask.glb", "picture", 0.08, ""),
    "glb/emissive": ("emissive.glb", "uniform that shines", 0.08, ""),
    "glb/mirror": ("mirror.glb", "picture", 0.08, ""),
    "glb/mirror_nonormal": ("mirror_nonormal.glb", "picture", 0.08, ""),
    "glb/mrtex": ("mrtex.glb", "picture", 0.08, ""),
    "glb/multimat": ("multimat.glb", "uniform picture", 0.12, ""),
    "glb/quantized": ("quantized.glb", "uniform", 0.08, ""),
    "glb/specgloss": ("specgloss.glb", "picture", 0.08, ""),
    "glb/textransform": ("textransform.glb", "picture", 0.08, ""),
    "glb/transmission": ("transmission.glb", "glass", 0.08, ""),
    "glb/vcol": ("vcol.glb", "vertices", 0.08, ""),
    "glb/webp": ("webp.glb", "picture", 0.08, ""),
    "glb/withground": ("withground.glb", "uniform", 0.08, "the ground below it is left out"),
    "glb/withpoints": ("withpoints.glb", "uniform", 0.08, "its points have no surface and are left out"),
}
REFUSED = {
    "flat": "card.obj: expected a body with three extents, found 0.085 x 0.054 x 0",
    "linkfiles": "found the text of a link to .*nsbad/m.obj, which is not in",
    "glb/basisu": "KHR_texture_basisu .gltf-transform or toktx writes its pictures as PNG",
    "glb/draco": "KHR_draco_mesh_compression .gltf-transform or Blender writes it without Draco",
}
#: Of each folder of light: the remark on its only map.
LIGHT = {
    "crop": "",
    "hdr_noformat": "",
    "hdr_oldrle": "",
    "hdr_plusY": "",
    "inf": "1 infinite pixel, read as 65504",
    "layered": "",
    "lower": "",
    "mixed": "",
    "multipart": "",
    "nested": "",
    "offbyone": "65 x 32 pixels, read as 64 x 32",
    "pano_jpg": "a picture of low range",
}


def _said(findings: tuple[Finding, ...], expected: str) -> bool:
    """Return whether the findings are the expected one, or none where none is expected."""
    return len(findings) == (1 if expected else 0) and all(expected in finding.reason for finding in findings)


@pytest.mark.parametrize("folder", USED)
def test_an_object_is_used_with_its_own_materials_and_nothing_else_is(
    folder: str, tmp_path: Path, capfd: pytest.CaptureFixture
) -> None:
    name, kinds, longest, said = USED[folder]
    checked, findings = checked_meshes(INPUTS / "mesh" / folder, pictures=tmp_path)
    file, outcome = checked[0]
    assert len(checked) == (3 if folder == "bopmm" else 1)
    assert (file.name, " ".join(outcome.facts["kinds"])) == (name, kinds)
    assert outcome.facts["longest"] == pytest.approx(longest, abs=1e-3)
    assert _said(findings, said)
    assert capfd.readouterr() == ("", "")  # no library says anything


@pytest.mark.parametrize("folder", REFUSED)
def test_what_cannot_be_used_is_one_line_with_the_true_reason(folder: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=REFUSED[folder]) as caught:
        checked_meshes(INPUTS / "mesh" / folder, pictures=tmp_path)
    assert "\n" not in str(caught.value)


def _parts(name: str, folder: Path) -> list[FilePart]:
    path = INPUTS / "mesh" / name
    return read_parts(Source(path, path.parent, folder))


def test_the_notch_of_a_polygon_and_the_colours_of_parts_are_those_of_the_file(tmp_path: Path) -> None:
    (part,) = _parts("concave/concave_ngon.obj", tmp_path)
    corners = part.vertices[part.faces]
    # A closed solid has the same volume from anywhere; a roof over the notch would add to it.
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    hull = float(np.prod(np.ptp(part.vertices, axis=0)))
    assert 0.1 * hull < volume < 0.95 * hull
    box, knob = (part.look.texture for part in _parts("multi/knob.obj", tmp_path))
    assert isinstance(box, UniformTexture)
    assert isinstance(knob, UniformTexture)
    assert box.colour[2] > 0.5 > box.colour[0]
    assert knob.colour[0] > 0.5 > knob.colour[2]


@pytest.mark.parametrize(("folder", "maps"), [("ambientcg", 2), ("polyhaven", 3), ("tga", 0), ("tiff32", 0)])
def test_a_folder_of_maps_is_one_material(folder: str, maps: int) -> None:
    (surface,), findings = usable_surfaces(INPUTS / "texture" / folder)
    assert len(surface.maps) == maps
    assert not findings


def test_a_pointer_of_git_lfs_is_no_picture() -> None:
    with pytest.raises(InputError, match="git lfs pull"):
        usable_surfaces(INPUTS / "texture" / "lfs")


@pytest.mark.parametrize("folder", LIGHT)
def test_every_dialect_of_a_light_file_is_read(folder: str) -> None:
    files, findings = usable_hdris(INPUTS / "hdri" / folder)
    assert len(files) == 1
    assert _said(findings, LIGHT[folder])
