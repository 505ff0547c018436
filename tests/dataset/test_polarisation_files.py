from __future__ import annotations

import cv2
import numpy as np
import pytest

import glassware as gw
from glassware.core.errors import InputError
from glassware.core.json_file import json_text
from glassware.dataset.builds.verify import scene_faults
from glassware.dataset.commands.develop import main as develop
from glassware.dataset.commands.render_scene import main as render_scene
from glassware.dataset.format import layout
from glassware.dataset.format.camera_file import camera_file
from glassware.dataset.format.dataset_file import read_head
from glassware.dataset.format.pictures import write_png
from glassware.dataset.format.polarisation_files import polarisation_numbers, read_stokes, write_stokes
from glassware.dataset.format.sensor_files import read_numbers
from glassware.dataset.stored_view import StoredView
from glassware.dataset.verification.polarisation import polarisation_faults, vector_faults
from glassware.dataset.verification.scene import scene_label_faults
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.surroundings import ConstantEnvironment
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives import bodies, scenes
from glassware.procedural.sensors.polarisation_cameras import POLARISATION_CAMERAS
from glassware.render.frame import StokesPicture


def test_an_unknown_camera_is_one_line_and_writes_nothing(tmp_path, capsys):
    out = tmp_path / "out"
    assert render_scene(["--sensors.polarisation", "imx250mrz", "--out", str(out)]) == 2
    line = capsys.readouterr().err.strip()
    assert "\n" not in line
    assert "sensors.polarisation: expected one of imx250mzr, imx250myr, none, or a YAML file" in line
    assert not out.exists()


def test_a_file_of_vectors_reads_back_to_the_rounding_of_halves(tmp_path, rng):
    vector = rng.uniform(0.1, 2.0, (6, 8, 4, 3)).astype(np.float32)
    error = rng.uniform(0.0, 0.1, (6, 8, 4)).astype(np.float32)
    write_stokes(tmp_path / "stokes.exr", StokesPicture(vector, error), exposure=1.0)
    again = read_stokes(tmp_path / "stokes.exr")
    np.testing.assert_allclose(again.vector, vector, rtol=2.0**-11)
    np.testing.assert_allclose(again.error, error, rtol=2.0**-11, atol=1e-7)


def test_numbers_of_the_pictures_are_degrees_and_angles():
    vector = np.zeros((1, 4, 4, 3), np.float32)
    for k, (degree, angle) in enumerate([(0.0, 0.0), (1.0, 0.0), (0.5, np.pi / 2), (0.25, 3 * np.pi / 4)]):
        vector[0, k, :3] = np.array([2.0, 2 * degree * np.cos(2 * angle), 2 * degree * np.sin(2 * angle)])[:, None]
    degree, angle = polarisation_numbers(vector)
    np.testing.assert_allclose(degree[0], [0, 65535, 32768, 16384], atol=1)
    np.testing.assert_allclose(angle[0, 1:], [0, 32768, 49152], atol=1)


@pytest.fixture(scope="module")
def with_stokes(backend, tmp_path_factory):
    """A slab above a table, stored with the files of a polarisation camera: the folder of the data set."""
    scene = scenes.scene(
        [bodies.slab((0.3, 0.3, 0.02), Medium(name="glass", eta=1.5), (0.0, 0.0, 0.05))],
        [scenes.camera((0.0, -0.5, 0.4), width=64, height=48)],
        table=scenes.board((4.0, 4.0, 0.02), scenes.matte((0.6, 0.4, 0.2))),
        environment=ConstantEnvironment(strength=0.3),
        picture=Picture(spp=16, light="path", layers=0, refraction=False),
    )
    device = POLARISATION_CAMERAS["imx250mzr"].model_copy(update={"samples": 64})
    root = tmp_path_factory.mktemp("stokes") / "data"
    gw.write(root, scene.model_copy(update={"polarisation_camera": device}), files="radiance")
    return root


@pytest.mark.slow
def test_a_data_set_with_a_polarisation_camera_is_written_read_verified_and_developed(with_stokes, tmp_path):
    (view,) = gw.Dataset.open(with_stokes).views()
    scene = view.scene()
    assert scene.polarisation_camera is not None
    assert scene.polarisation_camera.samples == 64
    assert list(scene_faults(with_stokes, read_head(with_stokes), 0)) == list(scene_label_faults(with_stokes, 0)) == []
    stokes, measured = view.stokes().vector, view.measured_stokes()
    assert measured.shape == (48, 64, 3, 1)
    light = stokes @ [0.2126, 0.7152, 0.0722]
    table = view.geometry().id == 1
    assert np.median(measured[..., 0, 0][table] / light[..., 0][table]) == pytest.approx(1.0, abs=0.01)
    away = cv2.erode(table.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    np.testing.assert_allclose(light[away][:, 1:], 0.0, atol=1e-6)  # what opaque things scatter is unpolarised
    (row,) = gw.Dataset.open(with_stokes).index().to_pylist()
    assert row["stokes"] == "scenes/000000/000/stokes.exr"
    assert row["polarisation_degree"][0] > 0.01
    assert develop([str(with_stokes), "--camera", "phone", "--out", str(tmp_path / "phone")]) == 0
    (again,) = gw.Dataset.open(tmp_path / "phone").views()
    assert again.polarisation_camera() == view.polarisation_camera()
    np.testing.assert_array_equal(again.polarisation_mosaic(), view.polarisation_mosaic())


@pytest.mark.slow
def test_each_wrong_file_is_a_fault(with_stokes):
    (view,) = gw.Dataset.open(with_stokes).views()
    scene, geometry = view.scene(), view.geometry()
    assert polarisation_faults(view, scene, geometry) == []
    found, folder = view.stokes(), view.folder
    files = {name: (folder / name).read_bytes() for name in (layout.STOKES, layout.DOLP, layout.AOLP, layout.MOSAIC)}
    numbers = {name: read_numbers(folder / name) for name in files if name != layout.STOKES}

    def faults() -> str:
        lines = "; ".join(str(fault) for fault in polarisation_faults(view, scene, geometry))
        for name, content in files.items():
            (folder / name).write_bytes(content)
        return lines

    long = found.vector.copy()
    long[5, 7, 1] = 1.1 * long[5, 7, 0]
    write_stokes(folder / layout.STOKES, StokesPicture(long, found.error), 1.0)
    assert "1 px, first (u, v) = (7, 5): expected S0 of at least" in faults()
    write_stokes(folder / layout.STOKES, StokesPicture(1.2 * found.vector, found.error), 1.0)
    assert "as in left.exr" in faults()
    for name, words in ((layout.DOLP, "that of stokes.exr"), (layout.MOSAIC, "the light behind its filters")):
        write_png(folder / name, (0.9 * numbers[name]).astype(np.uint16))
        assert words in faults()
    write_png(folder / layout.AOLP, numbers[layout.AOLP] + np.uint16(8192))
    assert "aolp.png" in faults()
    assert faults() == ""


def test_vectors_that_are_no_light_are_faults():
    vector = np.zeros((2, 2, 4, 3), np.float32)
    vector[..., 0, :] = 1.0
    assert vector_faults(vector, spectral=False) == []
    vector[0, 1, 3, 2] = -1.01
    (fault,) = vector_faults(vector, spectral=False)
    assert "(u, v) = (1, 0)" in str(fault)
    assert vector_faults(vector, spectral=True) == []  # the luminance of blue is small
    vector[1, 0, 0, 0] = np.nan
    (fault,) = vector_faults(vector, spectral=True)
    assert "finite" in str(fault)


def test_a_view_without_such_a_camera_says_how_to_make_one(tmp_path):
    text = json_text(camera_file(scenes.camera((0.0, 0.0, 1.0))).model_dump(mode="json"))
    (tmp_path / layout.CAMERA).write_text(text, encoding="utf-8")
    view = StoredView(tmp_path, 0)
    assert view.polarisation_camera() is None
    with pytest.raises(InputError, match=r"--sensors\.polarisation imx250mzr"):
        view.stokes()
