from __future__ import annotations

import numpy as np
import pytest

import glassware as gw
from glassware.dataset.commands.build_dataset import main as build_dataset
from glassware.dataset.commands.develop import main as develop
from glassware.dataset.commands.render_scene import main as render_scene
from glassware.dataset.verification.scene import scene_label_faults
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.surroundings import ConstantEnvironment
from glassware.procedural.description.time_of_flight import DepthDevice
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives import bodies, scenes
from glassware.procedural.sensors.depth_cameras import DEPTH_CAMERAS
from glassware.procedural.sensors.time_of_flight import TIME_OF_FLIGHT_CAMERAS


def test_an_unknown_device_is_one_line_and_writes_nothing(tmp_path, capsys):
    out = tmp_path / "out"
    assert render_scene(["--sensors.depth", "d453", "--out", str(out)]) == 2
    line = capsys.readouterr().err.strip()
    assert "\n" not in line
    assert "sensors.depth: expected one of d415, d435, l515, none, or a YAML file (is it d435?), found 'd453'" in line
    assert not out.exists()


@pytest.mark.parametrize("main", [render_scene, build_dataset])
@pytest.mark.parametrize("device", ["none", "l515"])
def test_infrared_pictures_need_a_camera_that_takes_them(tmp_path, capsys, main, device):
    out = tmp_path / "out"
    assert main(["--sensors.depth", device, "--write", "infrared", "--out", str(out)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "write: expected infrared with a stereo depth camera alone, such as sensors.depth d435, found" in line
    assert line.endswith(f"sensors.depth {device}")
    assert not out.exists()


def scene_with(device: DepthDevice):
    """A slab above a table, seen from above by a device."""
    slab = bodies.slab((0.1, 0.1, 0.02), Medium(name="glass", eta=1.5), (0.0, 0.0, 0.05))
    scene = scenes.scene(
        [slab],
        [scenes.camera((0.0, 0.0, 0.6), width=160, height=120)],
        table=scenes.board((4.0, 4.0, 0.02), scenes.matte()),
        environment=ConstantEnvironment(strength=0.1),
        picture=Picture(spp=2, light="path"),
    )
    return scene.model_copy(update={"depth_camera": device})


@pytest.mark.slow
def test_a_data_set_with_a_depth_camera_is_written_read_verified_and_developed(backend, tmp_path):
    known = DEPTH_CAMERAS["d435"]
    imager = known.imager.model_copy(update={"width": 320, "height": 200, "centre": None})
    device = known.model_copy(update={"imager": imager})
    scene = scene_with(device)
    root = tmp_path / "data"
    gw.write(root, scene, files="radiance,infrared")
    (view,) = gw.Dataset.open(root).views()
    stored = view.scene()
    assert stored.depth_camera == device
    depth, Z = view.sensor_depth(), view.geometry().Z
    assert depth.shape == Z.shape
    table = view.geometry().id == 1
    assert np.nanmedian(np.abs(depth - Z)[table]) < 2e-3
    # The pattern is seen through the slab: most of it is reported as the table behind.
    assert np.nanmedian((depth - Z)[~table]) > 0.02
    assert view.infrared("right").shape == (200, 320)
    assert list(scene_label_faults(root, 0)) == []
    (row,) = gw.Dataset.open(root).index().to_pylist()
    assert row["sensor_depth"] == "scenes/000000/000/sensor_depth.png"
    assert row["sensor_behind"][0] > 0.5

    assert develop([str(root), "--camera", "phone", "--out", str(tmp_path / "phone")]) == 0
    (again,) = gw.Dataset.open(tmp_path / "phone").views()
    assert again.depth_camera().model_dump_json() == view.depth_camera().model_dump_json()
    np.testing.assert_array_equal(again.sensor_depth(), depth)


@pytest.mark.slow
def test_a_data_set_with_a_time_of_flight_camera_is_written_read_verified_and_developed(backend, tmp_path):
    device = TIME_OF_FLIGHT_CAMERAS["l515"].model_copy(update={"width": 160, "height": 120, "focal": 150.0})
    root = tmp_path / "data"
    gw.write(root, scene_with(device), files="radiance,infrared")
    (view,) = gw.Dataset.open(root).views()
    assert view.scene().depth_camera == device
    record, geometry = view.depth_camera(), view.geometry()
    assert (record.kind, record.baseline, record.reasons[2]) == ("tof", None, "no_return")
    error, glass = view.sensor_depth() - geometry.Z, geometry.id != 1
    assert np.nanstd(error[~glass]) == pytest.approx(0.0025, rel=0.2)
    # The table behind the slab: farther than it is, by its delay of light.
    behind = (view.sensor_depth() - geometry.background_Z)[glass & (error > 0.03)]
    assert np.nanmedian(behind) == pytest.approx(0.02 * 0.5, abs=1e-3)
    assert ((view.sensor_valid() == 1) == np.isfinite(view.sensor_depth())).all()
    assert list(scene_label_faults(root, 0)) == []
    with pytest.raises(gw.InputError, match=r"expected a stereo camera, such as .*, found l515"):
        view.infrared()
    with pytest.raises(gw.InputError, match="expected a stereo depth camera"):
        view.painted_sensor_depth("l515")
    assert develop([str(root), "--camera", "phone", "--out", str(tmp_path / "phone")]) == 0
    (again,) = gw.Dataset.open(tmp_path / "phone").views()
    assert again.depth_camera().model_dump_json() == record.model_dump_json()
