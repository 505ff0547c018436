from __future__ import annotations

import json
import re

import numpy as np
import pytest

from glassware.dataset.commands.view import main
from glassware.dataset.reader import Dataset
from glassware.dataset.viewer.rig import rig
from glassware.procedural.sensors.depth_cameras import DEPTH_CAMERAS

#: Weights of linear Rec.709 in luminance (ITU-R BT.709-6).
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@pytest.fixture
def saved(copy, add_sensors, tmp_path):
    """The page of a data set with both kinds of cameras, and its only view."""
    path = tmp_path / "page.html"
    assert main([str(add_sensors(copy)), "--save", str(path)]) == 0
    return path, Dataset.open(copy).views()[0]


def test_what_depth_cameras_report_is_on_the_page_beside_what_is_true(saved, page, unpack):
    path, view = saved
    shown = page(path)
    maps, reported, Z = shown.maps(), view.sensor_depth(), view.depth()
    apart, stored = maps["left/sensor-difference"], unpack(maps["left/sensor-difference"]["data"])
    known = np.isfinite(reported) & np.isfinite(Z)
    np.testing.assert_allclose(stored[known] * apart["step"], (reported - Z)[known], atol=0.501 * apart["step"])
    assert (stored[~known] == apart["none"]).all()
    assert (apart["low"], apart["high"], apart["unit"]) == (-0.05, 0.05, "m")
    reasons = maps["left/sensor-valid"]
    np.testing.assert_array_equal(unpack(reasons["data"]), view.sensor_valid())
    assert [name for name, _ in reasons["names"]][1:3] == ["measured", "no match"]
    record = shown.record("view-0-0")
    assert record["sizes"] == {"infrared left": [640, 362], "infrared right": [640, 362]}
    assert list(record["pictures"]) == ["left", "right", "infrared left", "infrared right"]
    assert "infrared" not in record["absent"]


def test_infrared_pictures_that_were_not_written_are_named(copy, add_sensors, tmp_path, page):
    add_sensors(copy)
    for path in copy.glob("scenes/*/*/ir_*.png"):
        path.unlink()
    assert main([str(copy), "--save", str(tmp_path / "page.html")]) == 0
    record = page(tmp_path / "page.html").record("view-0-0")
    assert record["absent"] == {"infrared": "the infrared pictures of the depth camera"}
    assert list(record["pictures"]) == ["left", "right"]


def test_stokes_vectors_are_on_the_page(saved, page, unpack):
    path, view = saved
    maps, light = page(path).maps(), view.stokes().vector.astype(np.float64) @ LUMINANCE
    degree = np.hypot(light[..., 1], light[..., 2]) / light[..., 0]
    np.testing.assert_allclose(unpack(maps["left/dolp"]["data"]) / 255.0, degree, atol=0.51 / 255.0)
    angle = np.degrees(0.5 * np.arctan2(light[..., 2], light[..., 1]))
    turned = unpack(maps["left/aolp"]["data"])[..., 0] * maps["left/aolp"]["step"] - angle
    assert np.abs((turned + 90.0) % 180.0 - 90.0).max() < 0.51 * 180.0 / 256.0
    for k in (1, 2, 3):
        one = maps[f"left/s{k}"]
        ratio = light[..., k] / light[..., 0]
        np.testing.assert_allclose(unpack(one["data"]) * one["step"], ratio, atol=0.501 * one["step"])
    s0 = maps["left/s0"]
    np.testing.assert_allclose(unpack(s0["data"]) * s0["step"], light[..., 0], atol=0.501 * s0["step"])
    np.testing.assert_array_equal(unpack(maps["left/mosaic"]["data"]), view.polarisation_mosaic())
    assert maps["left/mosaic"]["high"] == 4095.0


def test_each_object_has_its_numbers_of_the_index(copy, add_sensors, tmp_path, page):
    path = add_sensors(copy) / "scenes" / "000000" / "views.json"
    data = json.loads(path.read_text("utf-8"))
    (row,) = data["views"]
    count = len(row["object_ids"])
    for k, name in enumerate(("missing", "right", "behind", "front", "rim")):
        row[f"sensor_{name}"] = [None, *(0.1 * k + 0.01 * i for i in range(1, count))]
    row |= {"sensor_depth": "x", "sensor_measured": 0.5}
    path.write_text(json.dumps(data), "utf-8")
    assert main([str(copy), "--save", str(tmp_path / "page.html")]) == 0
    numbers = page(tmp_path / "page.html").record("view-0-0")["numbers"]
    assert len(numbers["titles"]) == 5
    first, second = (numbers["rows"][str(number)] for number in row["object_ids"][:2])
    assert first == ["-"] * 5
    assert second == ["1.0 %", "11.0 %", "21.0 %", "31.0 %", "0.41"]


def test_the_parts_of_a_depth_camera_stand_in_3d_where_its_record_says(saved, page):
    path, view = saved
    (cameras,) = page(path).record("scene-0")["cameras"]
    record, world_T_camera = view.depth_camera(), view.camera().world_T_camera
    for part, camera_T_part in zip(cameras["rig"], (record.camera_T_left, record.camera_T_right), strict=True):
        np.testing.assert_allclose(np.reshape(part["pose"], (4, 4)), world_T_camera @ camera_T_part)
        assert (part["K"], part["width"]) == ([*map(list, record.K)], record.width)
    projector = rig(view, DEPTH_CAMERAS["d435"])[2]
    np.testing.assert_allclose(np.reshape(projector["pose"], (4, 4)), world_T_camera @ record.camera_T_projector)
    corner = np.linalg.inv(projector["K"]) @ [0.0, 0.0, 1.0]  # of the first pixel
    np.testing.assert_allclose(np.degrees(2.0 * np.arctan(-corner[:2])), [86.0, 57.0])


@pytest.mark.slow
@pytest.mark.parametrize(
    "address", ["tab=maps", "eye=infrared+left&pixel=600,300", "map=aolp", "map=sensor-difference"]
)
def test_a_browser_shows_them(saved, browser, address):
    path, _ = saved
    text = browser(path, address, "--dump-dom")
    assert re.search(r'data-ready="0-0 (maps|picture)"', text)
    assert "data-failed" not in text
    if "infrared" in address:
        assert "<td>600, 300</td>" in text


@pytest.mark.slow
def test_a_browser_reads_signed_numbers_and_angles(saved, browser):
    path, view = saved
    reported, Z = view.sensor_depth(), view.depth()
    row, column = np.argwhere(np.isfinite(reported) & np.isfinite(Z))[0]
    text = browser(path, f"pixel={column},{row}", "--dump-dom")
    cells = dict(re.findall(r'data-map="([^"]+)"[^>]*><td>[^<]*</td><td>([^<]*)</td>', text))
    difference = float(cells["left/sensor-difference"].split()[0])
    assert difference == pytest.approx(float(reported[row, column] - Z[row, column]), abs=1e-4)
    light = view.stokes().vector[row, column].astype(np.float64) @ LUMINANCE
    assert float(cells["left/s2"]) == pytest.approx(light[2] / light[0], abs=1e-3)
    angle = np.degrees(0.5 * np.arctan2(light[2], light[1])) % 180.0
    assert float(cells["left/aolp"].split()[0]) == pytest.approx(angle, abs=0.5)
