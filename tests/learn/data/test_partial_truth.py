"""Converted data sets in the training loader: KeyPose's stereo frames as samples, and refusals for what others lack."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from glassware.core.errors import InputError
from glassware.dataset.commands.convert import main as convert
from glassware.learn.data.samples import SampleDataset
from glassware.learn.data.settings import AugmentSettings, ViewSettings
from glassware.learn.networks.build import build_network
from glassware.learn.networks.settings import NetworkSettings
from glassware.learn.targets.encoding import encoding_of
from glassware.learn.training.losses import LossWeights, losses, total_loss

STEREO = ViewSettings(rule="stereo", size=(64, 96))


def samples(makers, root: Path, write: str, views: ViewSettings = STEREO, *options: str, **more) -> SampleDataset:
    getattr(makers, write)(root / "source")
    if not (root / "out").exists():
        assert convert([str(root / "source"), "--out", str(root / "out"), "--rows", "0", *options]) == 0
    return SampleDataset(root / "out", "all", views, encoding_of(NetworkSettings()), **more)


def test_keypose_gives_stereo_samples_with_depth_masks_and_boxes(makers, tmp_path):
    found = samples(makers, tmp_path, "keypose", ground_truth=True)
    sample = found[(0, 0)]
    assert sample.images.shape == (2, 3, 64, 96)
    assert sample.world_T_camera[1] - sample.world_T_camera[0] == pytest.approx(
        torch.tensor([[0, 0, 0, 0.12], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]).numpy(), abs=1e-6
    )
    depth = sample.targets["depth"].numpy()
    assert set(np.unique(depth).round(2)) == {0.0, np.float32(0.57), np.float32(0.9), np.float32(0.67)}
    assert float(sample.targets["heatmap"].max()) == pytest.approx(1.0, abs=0.02)
    assert int(sample.targets["cell_mask"].sum()) > 0
    truth = sample.ground_truth
    assert truth is not None
    (item,) = truth.objects
    assert item.transparent
    assert item.size == pytest.approx(makers.SIZE)
    assert truth.keypoints[item.id][0] == pytest.approx([0.0, 0.0, 0.048], abs=1e-6)
    near, far = found.depth_range()
    assert (near, far) == pytest.approx((0.57, 0.57), abs=1e-3)


def test_keypose_without_depth_learns_boxes_and_takes_its_planes_from_them(makers, tmp_path):
    folder = makers.keypose(tmp_path / "source")
    for path in folder.glob("*.exr"):
        path.unlink()
    assert convert([str(tmp_path / "source"), "--out", str(tmp_path / "out"), "--rows", "0"]) == 0
    found = SampleDataset(tmp_path / "out", "all", STEREO, encoding_of(NetworkSettings()), augment=AugmentSettings())
    assert not found[(0, 0)].targets["depth"].any()
    near, far = found.depth_range()
    assert 0.55 < near < far < 0.65


@pytest.mark.slow
def test_a_network_takes_a_step_on_keypose(makers, tmp_path, tiny):
    batch = samples(makers, tmp_path, "keypose")[(0, 0)]
    network = build_network(tiny)
    outputs = network(batch.images[None], batch.world_T_camera[None], batch.K[None])
    targets = {name: value[None] for name, value in batch.targets.items()}
    total = total_loss(losses(outputs, targets, tiny), LossWeights())
    total.backward()
    assert torch.isfinite(total)


@pytest.mark.parametrize(
    ("write", "views", "match"),
    [
        (
            "transcg",
            STEREO,
            "expected instances of objects, objects, poses of objects, .* and stereo pairs",
        ),
        ("bop", STEREO, "expected stereo pairs .* in every view, found BOP, which has"),
        ("ttd", ViewSettings(size=(64, 96)), r"expected poses of cameras \(views.rule is distance\) in every view"),
        ("todd", ViewSettings(size=(64, 96)), "expected sizes of objects in every view, found TODD"),
    ],
)
def test_what_a_data_set_lacks_is_one_line(makers, tmp_path, write, views, match):
    with pytest.raises(InputError, match=match) as caught:
        samples(makers, tmp_path, write, views)
    assert "\n" not in str(caught.value)


def test_bop_is_learnt_from_where_it_is_stated_what_is_transparent(makers, tmp_path):
    distance = ViewSettings(rule="distance", size=(64, 96))
    with pytest.raises(InputError, match="expected whether it is transparent"):
        _ = samples(makers, tmp_path / "a", "bop", distance)[(0, 0)]
    sample = samples(makers, tmp_path / "b", "bop", distance, "--transparent", "all")[(0, 0)]
    assert sample.images.shape == (2, 3, 64, 96)
    assert int(sample.targets["cell_mask"].sum()) > 0
