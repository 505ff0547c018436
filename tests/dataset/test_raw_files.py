"""Raw responses of a sensor as files: written with radiance, read, verified, and developed by any camera."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.core.images import srgb8
from glassware.dataset.builds.verify import scene_faults
from glassware.dataset.commands.develop import main as develop
from glassware.dataset.commands.render_scene import main as render_scene
from glassware.dataset.format.checksums import write_checksums
from glassware.dataset.format.dataset_file import read_head
from glassware.dataset.reader import Dataset
from glassware.dataset.verification.pictures import radiance_faults, sensor_faults
from glassware.dataset.writer import finish_dataset, start_dataset
from glassware.procedural.description.sensitivities import Sensitivities

#: A sensor whose red and green overlap.
MATRIX = ((1.5, -0.5, 0.0), (-0.25, 1.5, -0.25), (0.0, -0.5, 1.5))
SENSOR = Sensitivities(
    name="test",
    wavelengths=(400.0, 550.0, 700.0),
    red=(0.0, 0.6, 1.0),
    green=(0.0, 1.0, 0.3),
    blue=(1.0, 0.2, 0.0),
    white=(0.6, 1.0, 0.8),
    matrix=MATRIX,
)


@pytest.fixture
def with_raw(made, head, write_scene, tmp_path):
    """A data set of the closed-form scene whose raw responses are those that its matrix takes to the radiance."""
    scene, points, views = made
    picture = scene.picture.model_copy(update={"spectral": True})
    scene = scene.model_copy(update={"sensitivities": SENSOR, "picture": picture})
    back = np.linalg.inv(np.array(MATRIX)).astype(np.float32).T
    seen = []
    for one in views:
        raw = (one.frame.left @ back, one.frame.right @ back)
        seen.append(type(one)(dataclasses.replace(one.frame, raw=raw, scene=scene), one.labels))
    root = tmp_path / "raw"
    start_dataset(root, head, [scene.scene_id])
    write_scene(root, scene, points, seen)
    finish_dataset(root)
    return root


def test_raw_responses_are_stored_beside_radiance_and_pictures_are_made_of_them(with_raw, stored):
    for view, plain in zip(Dataset.open(with_raw).views(), Dataset.open(stored).views(), strict=True):
        record, camera = view.camera_record(), view.camera()
        assert record.sensitivities is not None
        assert (record.sensitivities.name, record.sensitivities.white) == ("test", SENSOR.white)
        for eye in ("left", "right"):
            np.testing.assert_array_equal(view.radiance(eye), plain.radiance(eye))  # linear Rec.709 as before
            rgb = view.raw(eye) @ np.array(MATRIX, np.float32).T
            np.testing.assert_allclose(rgb, view.radiance(eye), atol=4e-3 * view.radiance(eye).max())  # halves
            step = srgb8(rgb, camera.exposure).astype(int) - view.picture(eye)
            assert np.abs(step).max() <= 2
        assert plain.camera_record().sensitivities is None
        with pytest.raises(InputError, match=r"expected a data set of a sensor, made with --sensors.sensitivities"):
            plain.raw()


def test_verification_finds_files_that_are_missing_and_light_that_is_not_the_sensors(with_raw):
    head = read_head(with_raw).model_copy(update={"files": ("radiance",)})  # closed forms have no layers
    (number,) = (scene.scene_id for scene in Dataset.open(with_raw).scenes)
    assert list(scene_faults(with_raw, head, number)) == []
    view = Dataset.open(with_raw).views()[0]
    scene = view.scene()
    assert radiance_faults(view, scene, developed=True) == sensor_faults(view, scene) == []
    other = scene.model_copy(update={"sensitivities": SENSOR.model_copy(update={"name": "other"})})
    assert [fault.where for fault in sensor_faults(view, other)] == ["sensitivities name"]
    (fault,) = sensor_faults(view, scene.model_copy(update={"sensitivities": None}))
    assert (fault.expected, fault.found) == ("None", "test")
    (view.folder / "raw_left.exr").write_bytes((view.folder / "left.exr").read_bytes())
    with pytest.raises(InputError, match=r"raw_left\.exr"):
        radiance_faults(view, scene, developed=True)
    (view.folder / "raw_left.exr").unlink()
    write_checksums(view.folder.parent)
    (line,) = scene_faults(with_raw, head, number)
    assert line.endswith("raw_left.exr: expected a file, found none")


@pytest.mark.parametrize("camera", ["ideal", "phone", "webcam"])
def test_stored_responses_are_developed_by_any_camera(with_raw, tmp_path, camera):
    out = tmp_path / "developed"
    assert develop([str(with_raw), "--camera", camera, "--out", str(out)]) == 0
    for old, new in zip(Dataset.open(with_raw).views(), Dataset.open(out).views(), strict=True):
        assert new.camera_record().sensitivities == old.camera_record().sensitivities
        assert (new.folder / "raw_left.exr").samefile(old.folder / "raw_left.exr")
        if camera == "ideal":
            step = new.picture().astype(int) - old.picture()
            assert np.abs(step).max() <= 2  # raw responses are stored in halves
        else:
            assert not np.array_equal(new.picture(), old.picture())


def test_development_without_the_raw_responses_is_refused_in_one_line(with_raw, tmp_path, capsys):
    path = Dataset.open(with_raw).views()[0].folder / "raw_right.exr"
    path.unlink()
    assert develop([str(with_raw), "--camera", "phone", "--out", str(tmp_path / "out")]) == 2
    line = capsys.readouterr().err.strip()
    assert "raw_right.exr: expected a data set with radiance" in " ".join(line.split())
    assert not (tmp_path / "out").exists()


def test_sensitivities_without_wavelengths_are_one_line_and_nothing_is_written(tmp_path, capsys):
    out = tmp_path / "out"
    assert render_scene(["--sensors.sensitivities", "nikon-d5100", "--out", str(out)]) == 2
    line = capsys.readouterr().err.strip()
    assert "picture.spectral: expected on, as sensitivities belong to wavelengths" in line
    assert "\n" not in line
    assert not out.exists()


def test_a_record_of_a_camera_without_a_sensor_is_what_it_was(stored):
    view = Dataset.open(stored).views()[0]
    assert "sensitivities" not in json.loads((view.folder / "camera.json").read_text())
