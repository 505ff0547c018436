"""Camera presets and poses between the preset of the scene, a YAML file and the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.core.pose import look_at
from glassware.dataset.commands.build_dataset import BuildDataset
from glassware.dataset.commands.render_scene import RenderScene
from glassware.dataset.settings.config import parse_request
from glassware.dataset.settings.draw import draw
from glassware.procedural.surroundings.camera_settings import CameraSettings

K = "600 0 322 0 610 238 0 0 1"


@pytest.fixture
def cameras(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """(options, text of a YAML file) -> the settings of the cameras."""
    monkeypatch.chdir(tmp_path)

    def parsed(options: str, yaml: str = "") -> CameraSettings:
        Path("mine.yaml").write_text(yaml or "{}")
        words = ["--config", "mine.yaml", *options.split()]
        found = parse_request(RenderScene, words, "render-scene", "").settings.cameras
        assert parse_request(BuildDataset, words, "build-dataset", "").settings.cameras == found
        return found

    return parsed


def size(settings: CameraSettings) -> tuple[int, int]:
    lens = settings.intrinsics()
    return lens.width, lens.height


def test_a_camera_preset_takes_precedence_over_the_scenes_preset_and_over_nothing_of_the_users(cameras):
    assert size(cameras("")) == (320, 240)
    assert size(cameras("--cameras.preset d435")) == (848, 480)
    assert size(cameras("--preset standard", "cameras: {preset: d435}")) == (848, 480)
    assert cameras("--cameras.preset d435").views == 5
    assert size(cameras("--cameras.preset d435 --width 424")) == (424, 240)
    assert size(cameras("--height=240", "cameras: {preset: d435}")) == (424, 240)
    assert size(cameras("--cameras.preset syn-todd", "cameras: {preset: d435}")) == (640, 480)
    assert cameras("--cameras.baseline 55mm", "cameras: {preset: d435}").baseline == 0.055


def test_the_command_line_and_the_file_make_one_camera(cameras):
    yaml = f"cameras: {{K: [[{'], ['.join(', '.join(K.split()[i : i + 3]) for i in (0, 3, 6))}]]}}"
    lens = cameras("--width 640 --height 480", yaml).intrinsics()
    assert lens == cameras(f"--width 640 --height 480 --cameras.K {K}").intrinsics()
    assert (lens.fx, lens.fy, lens.cx, lens.cy) == (600.0, 610.0, 322.0, 238.0)
    assert cameras("--cameras.distance 40cm 0.8m", "cameras: {views: 100}").views == 100


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ("--cameras.preset d434", r"cameras\.preset: expected one of d415, d435, .*\(is it d435\?\), found 'd434'"),
        ("--cameras.elevation 30grad 0.9", r"cameras\.elevation: expected an angle in deg or rad.*, found '30grad'"),
        ("--cameras.baseline=5in", r"cameras\.baseline: expected a length in m, cm or mm.*, found '5in'"),
        ("--vessels.height 5cm 30deg", r"vessels\.height: expected a length .*, found '30deg', an angle"),
        ("--cameras.preset d435 --width 640 --height 480", r"^cameras\.height: expected 362, the shape of d435"),
        (f"--cameras.K {K}", r"cameras\.K: expected cx of 127\.5 to 191\.5 px in a picture of width 320 .*, found 322"),
        (f"--cameras.preset d415 --cameras.K {K}", r"cameras\.K: expected cx of .* in a picture of width 1280"),
        ("--cameras.preset d435 --width abc", r"cameras\.width: expected INT, found 'abc'"),
        ("--cameras.distance 40cm", r"cameras\.distance: expected two numbers \(FLOAT FLOAT\), found '40cm'"),
        ("--cameras.poses none.txt", r"none\.txt: expected a readable file of camera poses, found none"),
    ],
)
def test_a_wish_that_cannot_be_met_is_one_line(cameras, options, says):
    with pytest.raises(InputError, match=says):
        cameras(options)


def test_a_unit_in_a_file_is_read_as_on_the_command_line(cameras):
    yaml = "cameras: {elevation: [30deg, 60 deg], distance: [40cm, 0.8]}"
    assert cameras("", yaml) == cameras("--cameras.elevation 30deg 60deg --cameras.distance 0.4 800mm")
    with pytest.raises(InputError, match=r"cameras\.elevation\.1: expected an angle .*, found '6m', a length"):
        cameras("", "cameras: {elevation: [30deg, 6m]}")


def test_all_poses_of_a_file_are_views_unless_fewer_are_asked_for(cameras):
    np.save("poses.npy", [look_at(np.array([x, -0.5, 0.5]), np.zeros(3)) for x in (0.0, 0.1, 0.2)])
    assert cameras("--cameras.poses poses.npy").views == 3
    assert cameras("", "cameras: {poses: poses.npy}").views == 3
    assert cameras("--cameras.poses poses.npy --views 2").views == 2
    with pytest.raises(InputError, match=r"cameras\.elevation: expected none beside cameras\.poses"):
        cameras("--cameras.poses poses.npy --cameras.elevation 0.5 0.6")


def test_a_scene_from_python_has_the_cameras_of_a_file(cameras):
    poses = [look_at(np.array([x, -0.5, 0.5]), np.zeros(3)) for x in (0.0, 0.1, 0.2)]
    np.save("poses.npy", poses)
    scene = draw(3, vessel_count=[1, 1], prop_count=[0, 0], cameras={"preset": "d435", "poses": "poses.npy"})
    assert [camera.width for camera in scene.cameras] == [848] * 3
    np.testing.assert_allclose([camera.world_T_camera for camera in scene.cameras], poses, atol=1e-12)
    np.save("poses.npy", [*poses, look_at(np.array([0.0, -0.5, -0.01]), np.zeros(3))])
    with pytest.raises(InputError, match=r"poses\.npy, pose 3: expected a place in the air, .* in the table"):
        draw(3, vessel_count=[1, 1], prop_count=[0, 0], cameras={"poses": "poses.npy"})


def test_a_distance_at_which_the_vessel_is_out_of_the_picture_names_one_that_works():
    near = {"distance": [0.02, 0.03], "elevation": ["80deg", "90deg"], "baseline": 0.2}
    with pytest.raises(InputError, match=r"cameras\.distance: expected a range from (\S+) m") as error:
        draw(3, vessel_count=[1, 1], prop_count=[0, 0], cameras=near)
    works = float(str(error.value).split("from ")[1].split()[0])
    scene = draw(3, vessel_count=[1, 1], prop_count=[0, 0], cameras=near | {"distance": [works, works], "views": 1})
    assert len(scene.cameras) == 1


@pytest.mark.parametrize(
    ("cameras", "said"),
    [
        (
            {"elevation": [30, 60]},
            "cameras.elevation.0: expected less than or equal to 1.5708 rad (90deg), found 30",
        ),
        ({"elevation": "45deg"}, "cameras.elevation: expected a pair (smallest, largest), found '45deg'"),
        ({"distance": [40, 80]}, r"found 40 m (is it 40cm?)"),
        ({"baseline": 120}, "found 120 m (is it 120mm?)"),
        ({"views": 0}, "cameras.views: expected greater than or equal to 1, found 0"),
    ],
)
def test_beside_a_camera_preset_a_fault_is_named_as_the_users_own(cameras, said):
    with pytest.raises(InputError) as caught:
        draw(7, cameras={"preset": "d435", **cameras})
    assert said in str(caught.value)
