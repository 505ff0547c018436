"""The whole way, from a rendered scene to figures, on one sample that a small network is to learn by heart."""

from __future__ import annotations

import pytest

from glassware.dataset.commands.render_scene import main as render_scene
from glassware.learn import NetworkSettings
from glassware.learn.data.samples import SampleDataset
from glassware.learn.data.settings import AugmentSettings, ViewSettings
from glassware.learn.evaluation.report import summarise
from glassware.learn.evaluation.run import score_all
from glassware.learn.targets.encoding import CORRECTED
from glassware.learn.training.checkpoint import load_network
from glassware.learn.training.loss_weights import LossWeights
from glassware.learn.training.run import train
from glassware.learn.training.settings import MachineSettings, OptimiserSettings, TrainSettings

#: Depth over all pixels that have one [m], and overlap of the oriented boxes, missed ones as 0.
DEPTH, IOU = 0.005, 0.8


@pytest.fixture(scope="module")
def pair(backend, tmp_path_factory):
    """A data set of one stereo pair."""
    folder = tmp_path_factory.mktemp("pair")
    config = folder / "pair.yaml"
    config.write_text(
        "vessel_count: [1, 1]\n"
        "prop_count: [1, 1]\n"
        "vessels: {chord_error: 1.0e-4}\n"
        "cameras: {width: 128, height: 96, views: 1}\n"
        "picture: {spp: 16, layers: 0, refraction: no, light: path}\n"
    )
    assert render_scene(["--seed", "5", "--out", str(folder / "data"), "--config", str(config)]) == 0
    return folder / "data"


@pytest.mark.slow
@pytest.mark.parametrize("switches", [{}, {"matching": "group", "readout": "windowed", "spacing": "inverse"}])
def test_a_small_network_learns_one_sample_by_heart(pair, tmp_path, switches):
    views = ViewSettings(rule="stereo")
    settings = TrainSettings(
        network=NetworkSettings(
            planes=16,
            feature_channels=16,
            feature_width=8,
            feature_blocks=(1, 1, 1, 1),
            volume_channels=8,
            context="resnet18",
            context_width=8,
            decoder_width=8,
            backbone_width=16,
            pyramid_channels=32,
            **switches,
        ),
        views=views,
        augment=AugmentSettings(probability=0.0),
        losses=LossWeights(huber=0.01, depth=10.0, small_depth=3.0, vertex=0.5, z_centroid=0.5, covariance=0.5),
        optimiser=OptimiserSettings(learning_rate=3e-3, warmup=10),
        machine=MachineSettings(accelerator="cpu", workers=0, threads=1),
        steps=450,
        batch=1,
        train_split="all",
        val_split="none",
        log_every=100,
        pictures_every=450,
        save_every=450,
    )
    train(settings, pair, tmp_path, None, lambda _line: None)
    network, kept = load_network(tmp_path / "last.safetensors")
    samples = SampleDataset(pair, "all", views, CORRECTED, ground_truth=True)
    scores, _ = score_all(network, samples, kept.network, lambda _line: None)
    found = summarise(scores)
    assert found["pose"]["objects"] == 2
    assert found["depth"]["full"]["all"]["mae"] < DEPTH
    assert found["boxes"]["iou_all"] > IOU
    assert found["masks"]["ap50"] == pytest.approx(1.0)
