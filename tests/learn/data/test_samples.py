from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
import torch

from glassware.annotate.projection import project, unproject
from glassware.core.errors import InputError
from glassware.dataset.format.exr import read_exr, write_exr
from glassware.dataset.format.pictures import read_png, write_png
from glassware.dataset.reader import Dataset
from glassware.learn.data.loading import load_batches
from glassware.learn.data.samples import SampleDataset, collate, image_tensor
from glassware.learn.data.settings import AugmentSettings, ViewSettings
from glassware.learn.targets.encoding import CORRECTED, REFERENCE

SCENE = "scenes/000000"


def samples(root, split: Any = "all", **options) -> SampleDataset:
    views = ViewSettings(**options.pop("views", {}))
    return SampleDataset(root, split, views, CORRECTED, **options)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_a_sample_has_the_views_that_are_asked_for(rendered, count):
    data = samples(rendered, views={"count": count}, ground_truth=True)
    assert len(data) == 10
    sample = data[(7, 0)]
    assert sample.images.shape == (count, 3, 96, 128)
    stored = Dataset.open(rendered).scene(1)
    assert sample.name == "scenes/000001/002"
    np.testing.assert_array_equal(sample.images[0].movedim(0, -1).numpy() * 255, stored.views[2].picture())
    np.testing.assert_allclose(sample.world_T_camera[0], stored.views[2].camera().world_T_camera, atol=1e-6)
    np.testing.assert_allclose(sample.K[0], stored.views[2].camera().K, rtol=1e-6)
    poses = {tuple(pose[:3, 3].round(decimals=4).tolist()) for pose in sample.world_T_camera}
    assert len(poses) == count
    geometry = stored.views[2].geometry()
    assert sample.ground_truth is not None
    np.testing.assert_array_equal(sample.ground_truth.instances, geometry.id)
    np.testing.assert_array_equal(sample.targets["depth"], np.where(np.isfinite(geometry.Z), geometry.Z, 0))


def test_pictures_lie_channel_after_channel_in_memory(rendered):
    """Interleaved ones make torch 2.13 write beyond its memory in the backward pass (`image_tensor`)."""
    data = samples(rendered)
    one, other = data[(0, 0)], data[(1, 0)]
    assert one.images.is_contiguous()
    assert collate([one, other]).images.is_contiguous()


def test_the_released_network_gets_pictures_stretched_to_all_values():
    pictures = np.random.default_rng(3).integers(40, 200, (2, 32, 32, 3)).astype(np.uint8)
    stretched = image_tensor(pictures, REFERENCE)
    for ours, theirs in zip(stretched, pictures.astype(np.float64), strict=True):
        expected = (theirs - theirs.min()) / (theirs.max() - theirs.min())
        np.testing.assert_allclose(ours.movedim(0, -1), expected, rtol=0, atol=1e-6)
    np.testing.assert_array_equal(image_tensor(pictures, CORRECTED).movedim(1, -1), pictures / np.float32(255.0))


def test_other_views_are_drawn_from_the_nearest(rendered):
    data = samples(rendered, views={"pool": 2})
    cameras = np.array([view.camera().world_T_camera[:3, 3] for view in Dataset.open(rendered).scene(0).views])
    away = np.linalg.norm(cameras - cameras[0], axis=1)
    drawn = set()
    for draw in range(30):
        place = data[(0, draw)].world_T_camera[1, :3, 3].numpy()
        drawn.add(int(np.linalg.norm(cameras - place, axis=1).argmin()))
    # Places on the grid may be equally far away.
    assert len(drawn) == 2
    assert max(away[list(drawn)]) <= np.sort(away)[2] + 1e-9


def test_a_stereo_pair_stands_at_its_baseline(rendered):
    sample = samples(rendered, views={"rule": "stereo"})[(0, 0)]
    view = Dataset.open(rendered).scene(0).views[0]
    relative = torch.linalg.inv(sample.world_T_camera[0].double()) @ sample.world_T_camera[1].double()
    expected = np.eye(4)
    expected[0, 3] = view.camera().baseline
    np.testing.assert_allclose(relative, expected, atol=1e-6)
    np.testing.assert_array_equal(sample.images[1].movedim(0, -1).numpy() * 255, view.picture("right"))


def test_the_views_of_a_sample_show_the_same_table(rendered):
    """Pictures, poses, K and depth fit together: points of the table have one colour in two views."""
    sample = samples(rendered, views={"pool": 1}, ground_truth=True)[(1, 0)]
    truth = sample.ground_truth
    assert truth is not None
    K, poses = sample.K.double().numpy(), sample.world_T_camera.double().numpy()
    first, second = (image.movedim(0, -1).numpy() for image in sample.images)

    def difference(stretch: float) -> float:
        points = unproject(truth.Z * stretch, K[0])[truth.instances == 1]
        world = points @ poses[0][:3, :3].T + poses[0][:3, 3]
        pixels, _ = project(world, K[1], poses[1])
        u, v = np.nan_to_num(np.rint(pixels), nan=-1).astype(int).T
        inside = (u >= 0) & (u < 128) & (v >= 0) & (v < 96)
        return float(np.abs(first[truth.instances == 1][inside] - second[v[inside], u[inside]]).mean())

    assert difference(1.0) < 0.8 * min(difference(0.85), difference(1.15))


def test_a_sample_depends_on_seed_reference_and_draw_alone(rendered):
    changed = {"augment": AugmentSettings(), "views": {"count": 3}}
    one, other = samples(rendered, seed=1, **changed), samples(rendered, seed=1, **changed)
    other[(5, 0)]
    same = [torch.equal(a.images, b.images) for a, b in [(one[(3, 2)], other[(3, 2)])]]
    assert same == [True]
    assert not torch.equal(one[(3, 2)].images, one[(3, 3)].images)
    assert not torch.equal(one[(3, 2)].images, samples(rendered, seed=2, **changed)[(3, 2)].images)


def test_workers_give_the_same_batches(rendered):
    data = samples(rendered, augment=AugmentSettings())
    order = [[(0, 0), (4, 0)], [(7, 1), (2, 1)]]
    for batch, asked in zip(load_batches(data, order, 2), order, strict=True):
        alone = collate([data[item] for item in asked])
        assert torch.equal(batch.images, alone.images)
        assert batch.names == alone.names
        assert all(torch.equal(batch.targets[name], alone.targets[name]) for name in alone.targets)


def test_splits_are_those_of_the_data_set(rendered):
    assert {samples(rendered, "train")[(i, 0)].name[:13] for i in range(5)} == {"scenes/000000"}
    assert len(samples(rendered, "val")) == 5
    with pytest.raises(InputError, match="split test: expected scenes that exist, found none"):
        samples(rendered, "test")
    with pytest.raises(InputError, match="split: expected one of train, val, test, all, found other"):
        samples(rendered, "other")


def test_the_range_of_depth_holds_nearly_all_pixels_of_objects_and_not_much_more(rendered):
    geometries = [view.geometry() for view in Dataset.open(rendered).views()]
    objects = [g.Z[g.id > 1] for g in geometries]
    near, far = samples(rendered).depth_range()
    assert min(Z.min() for Z in objects) <= near < far <= max(Z.max() for Z in objects)
    inside = [((near <= Z) & (far >= Z)).mean() for Z in objects if Z.size]
    assert np.mean(inside) == pytest.approx(0.99, abs=0.005)  # each view counts alike; 1 % is outside by definition


def edited(path, change) -> None:
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))


BAD = {
    "pose": (
        "000/camera.json",
        lambda d: d["world_T_camera"][0].__setitem__(0, 3.0),
        r"000/camera\.json: world_T_camera: expected a rigid pose",
    ),
    "mirrored pose": (
        "000/camera.json",
        lambda d: [row.__setitem__(0, -row[0]) for row in d["world_T_camera"]],
        "world_T_camera: expected a rigid pose, found a reflection",
    ),
    "K": (
        "000/camera.json",
        lambda d: d["K"].__setitem__(0, d["K"][1]),
        r"000/camera\.json: K: expected focal lengths above 0",
    ),
    "singular K": (
        "000/camera.json",
        lambda d: d.update(K=[[500.0, 500.0, 64.0], [500.0, 500.0, 48.0], [0.0, 0.0, 1.0]]),
        r"000/camera\.json: K: expected a matrix with an inverse",
    ),
    "place": (
        "000/camera.json",
        lambda d: d["world_T_camera"][0].__setitem__(3, 1e30),
        r"000/camera\.json: world_T_camera: expected numbers below 1e\+06, found 1e\+30",
    ),
    "object's pose": (
        "000/labels.json",
        lambda d: d["objects"][0].update(camera_T_object=np.zeros((4, 4)).tolist()),
        r"000/labels\.json: object 2 camera_T_object: expected a last row of 0, 0, 0, 1",
    ),
    "object's size": (
        "objects.json",
        lambda d: d["objects"][0].update(size=[0.1, -0.1, 0.1]),
        r"objects\.json: object 2 size: expected sides above 0",
    ),
    "object twice": (
        "000/labels.json",
        lambda d: d["objects"].append(d["objects"][0]),
        r"000/labels\.json: expected each object once",
    ),
    "size": ("000/camera.json", lambda d: d.update(width=64), r"000/left\.png: expected a picture of 96 x 64 px"),
    "label": (
        "000/labels.json",
        lambda d: d["objects"].pop(),
        r"000/labels\.json: expected an object \d+, which instances\.png has",
    ),
    "object": (
        "objects.json",
        lambda d: d["objects"].pop(),
        r"objects\.json: expected an object \d+, which labels\.json has",
    ),
    "axis": (
        "objects.json",
        lambda d: d["objects"][0].update(symmetries_continuous=[{"axis": [1, 0, 0], "offset": [0, 0, 0]}]),
        r"objects\.json: object 2 symmetries_continuous: expected the z axis",
    ),
}


@pytest.mark.parametrize("value", [-1.0, 0.0, np.nan, -np.inf, 1525.0])
def test_a_depth_that_is_none_in_metres_is_refused_by_file_and_channel(copied, value):
    path = copied / SCENE / "000" / "geometry.exr"
    channels = read_exr(path)
    channels["Z"] = np.where(channels["Z"] < np.median(channels["Z"]), np.float32(value), channels["Z"])
    write_exr(path, channels)
    with pytest.raises(InputError, match=r"000/geometry\.exr: Z: expected depths above 0 and up to 1000 m, or \+inf"):
        samples(copied)[(0, 0)]


@pytest.mark.parametrize("name", BAD)
def test_a_damaged_record_is_one_line_that_names_sample_and_field(copied, name):
    file, change, message = BAD[name]
    edited(copied / SCENE / file, change)
    with pytest.raises(InputError, match=message):
        samples(copied)[(0, 0)]


@pytest.mark.parametrize(
    ("file", "picture", "message"),
    [
        (
            "000/left.png",
            np.full((96, 128, 3), 7, np.uint8),
            r"000/left\.png: expected a picture, found nothing but the colour \[7, 7, 7\]",
        ),
        ("000/instances.png", np.zeros((48, 64), np.uint16), r"000/instances\.png: expected 96 x 128 px"),
    ],
)
def test_a_damaged_picture_is_one_line_that_names_it(copied, file, picture, message):
    write_png(copied / SCENE / file, picture)
    with pytest.raises(InputError, match=message):
        samples(copied)[(0, 0)]


@pytest.mark.parametrize(
    "file", ["000/geometry.exr", "000/labels.json", "000/instances.png", "000/left.png", "objects.json"]
)
def test_a_missing_file_is_one_line_that_names_it(copied, file):
    (copied / SCENE / file).unlink()
    with pytest.raises(InputError, match=file.replace(".", r"\.")):
        samples(copied)[(0, 0)]


def test_views_of_different_sizes_and_too_few_of_them_are_one_clear_line(copied):
    other = copied / SCENE / "001"
    edited(other / "camera.json", lambda d: d.update(width=64, height=64))
    write_png(other / "left.png", read_png(other / "left.png")[:64, :64])
    with pytest.raises(InputError, match="expected views of one size, found 64 x 64 px and 96 x 128 px"):
        samples(copied, views={"count": 5})[(0, 0)]
    with pytest.raises(InputError, match=r"views: expected 5 others by the rule distance, found 4 of the 5 views"):
        samples(copied, views={"count": 6})[(5, 0)]
    with pytest.raises(InputError, match=r"views\.count: expected 2 with the rule stereo"):
        samples(copied, views={"count": 3, "rule": "stereo"})
    with pytest.raises(InputError, match="a view that can be a reference"):
        samples(copied.parent / "data", views={"rule": "grid"}) if _lowered(copied) else None


def _lowered(root) -> bool:
    """Let every camera stand in the lowest ring of the grid."""
    for path in root.glob("scenes/*/*/camera.json"):
        edited(path, lambda d: d.update(grid_index=50))
    return True


def test_cameras_off_the_grid_are_no_neighbours_by_its_rule(copied):
    for path in copied.glob("scenes/*/*/camera.json"):
        edited(path, lambda d: d.update(grid_index=None))
    with pytest.raises(InputError, match=r"views\.rule: expected distance or stereo, as this camera .*, found grid"):
        samples(copied, views={"rule": "grid"})
    assert len(samples(copied, views={"rule": "distance"}))


def test_on_the_grid_other_views_are_next_to_the_reference(copied, split):
    """Views at the places 1, 2, 15, 30 and 50 of the grid: 2 and 15 are next to 1, 30 to neither, 50 looks along."""
    places = (1, 2, 15, 30, 50)
    for place, path in zip(places, sorted((copied / SCENE).glob("*/camera.json")), strict=True):
        edited(path, lambda d, place=place: d.update(grid_index=place))
    split(copied, train=(0,))
    data = samples(copied, "train", views={"rule": "grid"})
    assert len(data) == 4
    cameras = np.array([view.camera().world_T_camera[:3, 3] for view in Dataset.open(copied).scene(0).views])
    drawn = set()
    for draw in range(20):
        place = data[(0, draw)].world_T_camera[1, :3, 3].numpy()
        drawn.add(places[int(np.linalg.norm(cameras - place, axis=1).argmin())])
    assert drawn == {2, 15}
    with pytest.raises(InputError, match="expected 2 others by the rule grid, found 1 of the 5 views"):
        samples(copied, "train", views={"rule": "grid", "count": 3})[(3, 0)]
