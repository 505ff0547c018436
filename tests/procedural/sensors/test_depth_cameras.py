from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from pydantic import TypeAdapter

import glassware as gw
from glassware.core.errors import InputError
from glassware.procedural.description.depth_camera import DepthCamera
from glassware.procedural.description.time_of_flight import DepthDevice, TimeOfFlightCamera
from glassware.procedural.sensors.depth_cameras import DEPTH_CAMERAS, depth_camera
from glassware.render.infrared.pattern import pattern_map


def own(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_devices_have_the_nearest_depth_and_the_error_of_their_data_sheets():
    # Nearest f b / 126; RMS at 1 m by 0.08 px (shared figures of the vendor): 1.6 mm and 3.7 mm.
    for name, nearest, error in (("d415", 0.39, 0.00163), ("d435", 0.171, 0.00372)):
        device = DEPTH_CAMERAS[name]
        fb = device.imager.focal * device.baseline
        assert fb / 126 == pytest.approx(nearest, abs=0.005)
        assert 0.08 / fb == pytest.approx(error, rel=0.01)
        assert device.range[0] == pytest.approx(nearest, abs=0.015)


def test_a_file_changes_what_it_names_and_keeps_the_rest(tmp_path):
    path = own(tmp_path, "like: d435\nname: lab\nbaseline: 0.1\nprojector: {power: 0}\n")
    device = depth_camera(path)
    assert isinstance(device, DepthCamera)
    assert (device.name, device.baseline, device.projector.power) == ("lab", 0.1, 0.0)
    assert device.imager == DEPTH_CAMERAS["d435"].imager
    assert device.projector.dots == DEPTH_CAMERAS["d435"].projector.dots
    assert DepthCamera.model_validate(device.model_dump()) == device


def test_a_time_of_flight_camera_has_the_field_of_its_data_sheet_and_may_be_changed_by_a_file(tmp_path):
    device = depth_camera("l515")
    assert isinstance(device, TimeOfFlightCamera)
    field = [2 * np.degrees(np.arctan(side / 2 / device.focal)) for side in (device.width, device.height)]
    np.testing.assert_allclose(field, [70.0, 55.0], atol=0.6)
    changed = depth_camera(own(tmp_path, "like: l515\nname: lab\nreturns: first\n"))
    assert changed is not None
    assert changed == device.model_copy(update={"name": "lab", "returns": "first", "source": changed.source})
    either = TypeAdapter(DepthDevice)
    for one in (device, DEPTH_CAMERAS["d435"]):
        assert either.validate_json(one.model_dump_json()) == one


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("like: d436\n", "like: expected one of d415, d435, l515 (is it d435?)"),
        ("like: d435\nbaseline: 0\n", "baseline"),
        ("like: d435\nimager: {region: [0.5, 0.0, 0.4, 1.0]}\n", "region: expected left before right"),
        ("like: d435\nrange: [2, 1]\n", "range"),
        ("like: d435\nrange: [0.2, 100]\n", "16 bits"),
        ("like: d435\nmatching: {block: 8}\n", "odd"),
        ("like: d435\nmatching: {disparities: 100}\n", "multiple of 16"),
        ("like: d435\nprojector: {field: [4, 1]}\n", "171deg"),
        ("baseline: 0.05\n", "place: expected a value"),
        ("like: l515\nreturns: last\n", "returns: expected 'first' or 'strongest'"),
        ("like: l515\nerror: [-1, 0]\n", "error"),
        ("like: l515\nrange: [0.2, 100]\n", "16 bits"),
        ("like: l515\nbaseline: 0.05\n", "baseline"),
        ("kind: tof\n", "place: expected a value, or like: l515 for all that the file leaves out, found none"),
        ("", "baseline: expected a value, or like: d435 for all that the file leaves out, found none"),
        ("kind: radar\n", "kind: expected tof for time of flight, or none for stereo, found 'radar'"),
        ("like: d435\nkind: tof\n", "kind: expected none with like: d435, which is a stereo camera, found tof"),
        ("like: d435\nprojector: {picture: 5}\n", "projector.picture: expected the path of a picture, found 5"),
    ],
)
def test_a_device_that_cannot_be_is_one_line(tmp_path, text, words):
    with pytest.raises(InputError) as error:
        depth_camera(own(tmp_path, text))
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_an_unknown_device_is_one_line_with_the_nearest_that_works():
    with pytest.raises(InputError, match=r"sensors.depth: expected one of d415, .*l515, none, .*is it d435\?.*'d453'"):
        depth_camera("d453")
    assert depth_camera("none") is None


def test_a_pattern_may_be_a_picture_and_one_that_cannot_be_read_is_one_line(tmp_path):
    path = own(tmp_path, "like: d435\nprojector: {picture: dots.png}\n")
    with pytest.raises(InputError, match="a readable picture of a pattern"):
        depth_camera(path)
    (tmp_path / "dots.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"dots.png: expected a picture of a pattern \(PNG or JPEG\)"):
        depth_camera(path)
    levels = np.zeros((90, 160), np.uint8)
    cv2.imwrite(str(tmp_path / "dots.png"), levels)
    with pytest.raises(InputError, match="with some light, found a black one"):
        depth_camera(path)
    levels[:, :80] = 100
    cv2.imwrite(str(tmp_path / "dots.png"), levels)
    device = depth_camera(path)
    assert isinstance(device, DepthCamera)
    pattern = pattern_map(device.projector, 0, device.name)
    assert pattern.density.sum() * pattern.step**2 == pytest.approx(device.projector.power, rel=1e-4)
    assert pattern.corner[0] == pytest.approx(-np.tan(0.5 * device.projector.field[0]))
    assert (pattern.density[:, 80:] == 0.0).all()


@pytest.mark.parametrize(
    ("given", "line"),
    [
        ({"depth": "text.yaml"}, "sensors.depth: text.yaml: expected a mapping of settings, found str"),
        ({"depth": "nothing.yaml"}, "sensors.depth: nothing.yaml: expected a readable file with YAML, found none"),
        ({"polarisation": "text.yaml"}, "sensors.polarisation: text.yaml: expected a mapping of settings, found str"),
        ({"depth": 5}, "sensors.depth: expected 'none', 'd415', 'd435' or 'l515', found 5"),
    ],
)
def test_a_setting_names_the_file_beside_it_that_is_wrong(tmp_path, monkeypatch, given, line):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text.yaml").write_text("a text\n", encoding="utf-8")
    with pytest.raises(InputError) as error:
        gw.draw(seed=1, sensors=given)
    assert str(error.value) == f"draw: {line}"
