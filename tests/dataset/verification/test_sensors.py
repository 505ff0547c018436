from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.core.json_file import json_text
from glassware.dataset.depth_cameras.errors import DepthErrors
from glassware.dataset.depth_cameras.measure import REASONS, measured
from glassware.dataset.format import layout
from glassware.dataset.format.camera_file import camera_file, depth_camera_record
from glassware.dataset.format.pictures import write_png
from glassware.dataset.format.sensor_files import read_numbers
from glassware.dataset.format.views_table import scene_views, with_sensors
from glassware.dataset.reader import Dataset
from glassware.dataset.stored_view import StoredView
from glassware.dataset.verification.sensor_rows import sensor_row_faults
from glassware.dataset.verification.sensors import sensor_faults
from glassware.procedural.description.scene import TABLE_ID
from glassware.render.frame import Geometry

DEPTH = 0.6


@pytest.fixture
def stored(planes, tmp_path: Path):
    """A view of a wall, stored: the view, the device, the geometry, and a function that replaces its record."""
    device = planes.small()
    colour, infrared = planes.colour_camera(device), planes.plane(device, DEPTH)
    Z = np.full((colour.height, colour.width), DEPTH, np.float32)
    found = measured(device, infrared, colour, Z, (1, 0, 0))
    assert found.infrared is not None
    exposure, gain = found.infrared.exposure, found.infrared.gain
    write_png(tmp_path / layout.SENSOR_DEPTH, found.depth)
    write_png(tmp_path / layout.SENSOR_VALID, found.reason)
    ids = np.full(Z.shape, TABLE_ID, np.uint16)
    nothing, ones = np.zeros((0, *Z.shape), bool), np.ones((*Z.shape, 3), np.float32)
    geometry = Geometry(Z, ones, ids, Z, ids, ones, nothing, nothing)

    def record(**changes: object) -> None:
        one = depth_camera_record(device, exposure, gain, REASONS)
        file = camera_file(colour).model_copy(update={"depth_camera": one.model_copy(update=changes)})
        (tmp_path / layout.CAMERA).write_text(json_text(file.model_dump(mode="json")), encoding="utf-8")

    record()
    return StoredView(tmp_path, 0), device, geometry, record


def test_a_stored_view_reads_back_in_metres_with_its_reasons(stored):
    view, _, geometry, _ = stored
    depth = view.sensor_depth()
    assert depth.shape == geometry.Z.shape
    assert np.nanmedian(depth) == pytest.approx(DEPTH, abs=1.5e-3)
    names = view.depth_camera().reasons
    assert ((view.sensor_valid() == names.index("measured")) == np.isfinite(depth)).all()
    with pytest.raises(InputError, match="--write infrared"):
        view.infrared()


def test_right_files_have_no_fault(stored):
    view, device, geometry, _ = stored
    assert sensor_faults(view, device, geometry) == []


def test_each_wrong_file_is_a_fault(stored):
    view, device, geometry, record = stored
    numbers, reason = (read_numbers(view.folder / name) for name in (layout.SENSOR_DEPTH, layout.SENSOR_VALID))

    changed = numbers.copy()
    changed[60, 200] = 0
    write_png(view.folder / layout.SENSOR_DEPTH, changed)
    (fault,) = sensor_faults(view, device, geometry)
    assert "(u, v) = (200, 60)" in str(fault)

    changed[60, 200] = 60000  # 60 m
    write_png(view.folder / layout.SENSOR_DEPTH, changed)
    (fault,) = sensor_faults(view, device, geometry)
    assert "expected 0.17 to 10 m" in str(fault)

    write_png(view.folder / layout.SENSOR_DEPTH, np.where(numbers > 0, numbers + 12, 0).astype(np.uint16))
    (fault,) = sensor_faults(view, device, geometry)
    assert "of the table" in str(fault)
    write_png(view.folder / layout.SENSOR_DEPTH, numbers)

    odd = reason.copy()
    odd[0, 0] = 7
    write_png(view.folder / layout.SENSOR_VALID, odd)
    (fault,) = sensor_faults(view, device, geometry)
    assert "below 7" in str(fault)
    write_png(view.folder / layout.SENSOR_VALID, reason)

    write_png(view.folder / layout.IR_LEFT, np.full((120, 320), 255, np.uint16))
    assert sensor_faults(view, device, geometry) == []
    write_png(view.folder / layout.IR_RIGHT, np.full((120, 318), 256, np.uint16))
    size, number = sensor_faults(view, device, geometry)
    assert "ir_right.png" in str(size)
    assert "(120, 320), found (120, 318)" in str(size)
    assert "a number of 8 bits, found 256" in str(number)
    (view.folder / layout.IR_RIGHT).unlink()

    record(exposure=0.1)
    assert "expected 1e-05 to 0.033 s and a gain of 1 to 16, found 0.1" in str(sensor_faults(view, device, geometry)[0])
    record(width=848)
    assert "depth_camera size" in str(sensor_faults(view, device, geometry)[0])
    record(unit=0.0001)
    assert "depth_camera unit" in str(sensor_faults(view, device, geometry)[0])
    assert "depth_camera" in str(sensor_faults(view, None, geometry)[0])


def test_the_index_says_of_each_object_what_its_files_say(copy, add_sensors):
    (view,) = Dataset.open(add_sensors(copy)).views()
    (before,) = scene_views(copy, 0).views
    # Two objects that are large enough to have numbers.
    halves = np.where(np.arange(40) < 20, *before.object_ids[:2])
    write_png(view.folder / layout.INSTANCES, np.repeat(halves[None], 30, axis=0).astype(np.uint16))
    row = with_sensors(before, view.folder, view.geometry())
    assert sensor_row_faults(row, view) == []
    rims, measured, reasons = row.sensor_rim, row.sensor_measured, row.sensor_reasons
    assert rims is not None
    assert measured is not None
    assert reasons is not None
    assert sum(value is not None for value in rims) == 2
    changed = {
        "sensor_measured": measured + 1e-6,
        "sensor_reasons": reasons[::-1],
        "sensor_depth": None,
        "ir_left": "scenes/000000/000/ir_right.png",
        "stokes": "scenes/000000/001/stokes.exr",
    }
    lists = [f"sensor_{name}" for name in DepthErrors._fields] + ["polarisation_degree"]
    for name in lists:
        values = getattr(row, name)
        changed[name] = tuple(value if value is None else value + 0.01 for value in values)
        assert changed[name] != values, name
    for name, value in changed.items():
        (fault,) = sensor_row_faults(row.model_copy(update={name: value}), view)
        assert f"view 0 {name}:" in str(fault)


def test_a_view_without_a_depth_camera_says_how_one_is_made(stored):
    view, *_ = stored
    file = view.folder / layout.CAMERA
    text = file.read_text("utf-8")
    start = text.index('"depth_camera"')
    end = text.index("}", start) + 2
    file.write_text(text[:start] + text[end:].lstrip(), encoding="utf-8")
    with pytest.raises(InputError, match=r"--sensors.depth d435"):
        view.sensor_depth()
