from __future__ import annotations

from typing import get_args

import pytest

from glassware.core.errors import InputError
from glassware.dataset.cameras.presets import CAMERAS, colour_camera
from glassware.procedural.description.picture import Picture


def test_pictures_can_be_built_with_every_camera() -> None:
    assert get_args(Picture.model_fields["camera"].annotation) == tuple(CAMERAS)
    assert all(name == camera.name and camera.source for name, camera in CAMERAS.items())
    assert [name for name, camera in CAMERAS.items() if camera.ideal] == ["ideal"]


def test_a_camera_of_ones_own_begins_with_a_preset(tmp_path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("like: webcam\nname: mine\ndistortion: {k1: -0.1}\nsensor: {gain: [1, 2]}\njpeg_quality: null\n")
    mine, webcam = colour_camera(str(path)), CAMERAS["webcam"]
    assert mine.sensor is not None
    assert webcam.sensor is not None
    assert (mine.name, mine.distortion.k1, mine.sensor.gain, mine.jpeg_quality) == ("mine", -0.1, (1.0, 2.0), None)
    assert (mine.distortion.k2, mine.sensor.full_well) == (webcam.distortion.k2, webcam.sensor.full_well)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("aperture: -1", "aperture: expected greater than or equal to 0 m, found -1 m"),
        ("like: fone", "like: expected one of ideal, d435, phone, webcam"),
        ("sensor: {full_well: 10}", "sensor.width: expected"),
        ("vignette: 1", "vignette"),
        ("like: phone\nsensor: {black_level: 1}", "sensor.black_level: expected less than 1, found 1"),
        ("like: phone\nsensor: {gain: [0, 0]}", "sensor.gain.0: expected greater than 0, found 0"),
        ("xyz_to_sensor: [[1, 0, 0], [1, 0, 0], [0, 0, 1]]", "xyz_to_sensor: expected a matrix that can be inverted"),
        ("xyz_to_sensor: [[0, 0, 0], [0, 1, 0], [0, 0, 1]]", "daylight three signals above 0, found 0, 1, 1.089"),
    ],
)
def test_a_wrong_file_is_one_line(tmp_path, text: str, line: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        colour_camera(str(path))
    assert str(error.value).startswith(str(path))
    assert line in str(error.value)


def test_an_unknown_camera_is_asked_back() -> None:
    with pytest.raises(InputError, match=r"--camera: expected .*is it phone\?.*found 'phon'"):
        colour_camera("phon")
