from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from glassware.core.errors import InputError
from glassware.core.exit_codes import WorkFailed
from glassware.learn.networks.build import build_network
from glassware.learn.networks.settings import NetworkSettings
from glassware.learn.training.checkpoint import TrainedWeights, load_checkpoint, load_network, save_checkpoint
from glassware.learn.training.initial_weights import load_initial_weights
from glassware.learn.training.run import train
from glassware.learn.training.settings import OptimiserSettings
from glassware.learn.training.train_state import with_network_of


@pytest.fixture
def lines() -> list[str]:
    return []


def same(first: dict | None, second: dict | None) -> bool:
    assert first is not None
    assert second is not None
    return first.keys() == second.keys() and all(torch.equal(first[name], second[name]) for name in first)


@pytest.mark.slow
def test_a_run_that_was_stopped_goes_on_exactly(settings, rendered, tmp_path, lines):
    train(settings, rendered, tmp_path / "whole", None, lines.append)
    with pytest.raises(KeyboardInterrupt):
        train(settings, rendered, tmp_path / "part", None, _stop_after(4))
    part = load_checkpoint(tmp_path / "part" / "last.safetensors")
    assert part.step == 3
    train(settings, rendered, tmp_path / "part", tmp_path / "part" / "last.safetensors", lines.append)
    whole, part = (load_checkpoint(tmp_path / name / "last.safetensors") for name in ("whole", "part"))
    assert part.step == whole.step == 6
    assert same(part.network, whole.network)
    assert same(part.ema, whole.ema)
    assert part.best_loss == whole.best_loss
    assert whole.optimiser
    assert same(part.optimiser, whole.optimiser)
    assert same(*(load_checkpoint(tmp_path / name / "best.safetensors").network for name in ("whole", "part")))


def _stop_after(step: int):
    def say(line: str) -> None:
        if line.startswith(f"step {step}/"):
            raise KeyboardInterrupt

    return say


def test_a_run_learns_and_keeps_what_it_is_made_of(settings, rendered, tmp_path, lines):
    train(settings, rendered, tmp_path, None, lines.append)
    checkpoint = load_checkpoint(tmp_path / "last.safetensors")
    head = json.loads((rendered / "dataset.json").read_text())
    assert checkpoint.data is not None
    assert (checkpoint.data.name, checkpoint.data.seed) == (head["name"], head["seed"])
    assert checkpoint.settings.network.depth_range is not None
    near, far = checkpoint.settings.network.depth_range
    assert 0 < near < far
    assert checkpoint.settings.model_copy(update={"network": settings.network}) == settings
    torch.manual_seed(settings.seed)
    first = build_network(checkpoint.settings.network).state_dict()
    # Weights and their mean have moved, and differ; the mean is what is used.
    assert not any(same(checkpoint.network, other) for other in (first, checkpoint.ema))
    network, _ = load_network(tmp_path / "last.safetensors")
    assert not network.training
    assert same(network.state_dict(), checkpoint.ema)
    assert math.isfinite(checkpoint.best_loss)
    assert sum(line.startswith("step 6/6: loss") for line in lines) == 1
    assert list(tmp_path.glob("events.out.tfevents.*"))


@pytest.mark.slow
def test_validation_changes_no_weight_and_no_statistic(settings, rendered, tmp_path, lines):
    """Other looks at the validation scenes, the same weights."""
    train(settings, rendered, tmp_path / "with", None, lines.append)
    without = settings.model_copy(update={"val_split": "none"})
    train(without, rendered, tmp_path / "without", None, lines.append)
    one, other = (load_checkpoint(tmp_path / name / "last.safetensors") for name in ("with", "without"))
    assert same(one.network, other.network)


def test_the_mean_of_the_weights_follows_its_formula(settings, rendered, tmp_path, lines):
    kept = []
    for steps in (1, 2):
        options = {"steps": steps, "optimiser": OptimiserSettings(schedule="constant", warmup=0, ema=0.75)}
        train(settings.model_copy(update=options), rendered, tmp_path / str(steps), None, lines.append)
        kept.append(load_checkpoint(tmp_path / str(steps) / "last.safetensors"))
    torch.manual_seed(settings.seed)
    mean = build_network(kept[0].settings.network).state_dict()
    for checkpoint in kept:
        for name in ("pyramid.stem.0.0.weight", "vertex_head.predictor.bias"):
            mean[name] = 0.75 * mean[name] + 0.25 * checkpoint.network[name]
            torch.testing.assert_close(checkpoint.ema[name], mean[name])


def test_a_loss_that_is_no_number_stops_the_run_and_spoils_nothing(settings, rendered, tmp_path, lines):
    train(settings, rendered, tmp_path, None, lines.append)
    spoilt = load_checkpoint(tmp_path / "last.safetensors")
    spoilt.network["vertex_head.predictor.bias"].fill_(float("nan"))
    more = spoilt.settings.model_copy(update={"steps": 9})
    (tmp_path / "nan").mkdir()
    save_checkpoint(tmp_path / "nan" / "start.ckpt", replace(spoilt, settings=more))
    with pytest.raises(
        WorkFailed, match=r"loss of step 6 on scenes/000000/\d+.*: expected a finite number, found nan \(vertex"
    ):
        train(more, rendered, tmp_path / "nan", tmp_path / "nan" / "start.ckpt", lines.append)
    assert not (tmp_path / "nan" / "last.safetensors").exists()


def test_a_new_run_begins_with_the_weights_of_another_one(settings, rendered, tmp_path, lines):
    train(settings, rendered, tmp_path / "first", None, lines.append)
    best = tmp_path / "first" / "best.safetensors"
    still = OptimiserSettings(learning_rate=1e-12, warmup=0)
    again = settings.model_copy(update={"steps": 9, "batch": 1, "seed": 5, "optimiser": still})
    train(again, rendered, tmp_path / "second", None, lines.append, init=best)
    before, after = load_checkpoint(best), load_checkpoint(tmp_path / "second" / "last.safetensors")
    assert after.step == 9
    assert after.settings.network == before.settings.network
    for name, value in before.eval_weights().items():
        if "running" not in name and "batches" not in name:
            torch.testing.assert_close(after.network[name], value)
    # It goes on without the settings of a network that its weights have brought.
    bare = again.model_copy(update={"network": NetworkSettings()})
    second = tmp_path / "second" / "last.safetensors"
    train(bare, rendered, tmp_path / "second", second, lines.append)
    with pytest.raises(InputError, match=r"network\.planes: expected 8, which mvtrans takes here, found 32"):
        train(bare, rendered, tmp_path / "second", second, lines.append, typed=["network.planes"])
    other = settings.model_copy(update={"network": settings.network.model_copy(update={"groups": 2})})
    with pytest.raises(InputError, match=r"network\.groups: expected 2, as the settings say, found 8"):
        train(other, rendered, tmp_path / "third", None, lines.append, init=best)
    with pytest.raises(InputError, match="init: expected none beside resume: the checkpoint"):
        train(settings, rendered, tmp_path / "first", best, lines.append, init=best)


def test_a_run_that_begins_with_weights_may_move_the_planes_of_depth(settings):
    trained = settings.model_copy(update={"network": settings.network.model_copy(update={"depth_range": (0.2, 1.3)})})
    kept = with_network_of(settings, trained, Path("weights"))
    assert kept.network == trained.network
    nearer = settings.model_copy(update={"network": settings.network.model_copy(update={"depth_range": (0.4, 1.1)})})
    moved = with_network_of(nearer, trained, Path("weights"))
    assert moved.network == trained.network.model_copy(update={"depth_range": (0.4, 1.1)})
    faster = settings.model_copy(update={"network": settings.network.model_copy(update={"recompute": "nothing"})})
    assert with_network_of(faster, trained, Path("weights")).network.recompute == "nothing"


def test_a_run_that_begins_with_weights_may_add_a_refinement_of_depth(settings, rng):
    """All that its weights find stays as it is; a run with the default settings keeps the refinement of its weights."""
    plain = settings.network.model_copy(update={"depth_range": (0.4, 1.1)})
    trained = settings.model_copy(update={"network": plain})
    asked = settings.model_copy(update={"network": plain.model_copy(update={"refinement": "half"})})
    network = with_network_of(asked, trained, Path("weights")).network
    assert network.refinement == "half"
    before, after = build_network(plain).eval(), build_network(network).eval()
    load_initial_weights(after, TrainedWeights(trained, before.state_dict(), None), Path("weights"))
    again = build_network(network).eval()
    load_initial_weights(
        again, TrainedWeights(asked.model_copy(update={"network": network}), after.state_dict(), None), Path("weights")
    )
    images = torch.from_numpy(rng.uniform(size=(1, 2, 3, 64, 96))).float()
    poses = torch.eye(4).repeat(1, 2, 1, 1)
    poses[0, 1, 0, 3] = 0.05
    K = torch.tensor([[80.0, 0.0, 48.0], [0.0, 80.0, 32.0], [0.0, 0.0, 1.0]]).repeat(1, 2, 1, 1)
    with torch.inference_mode():
        expected, found, kept = before(images, poses, K), after(images, poses, K), again(images, poses, K)
    for name in ("seg", "heatmap", "vertex", "covariance", "small_depth"):
        torch.testing.assert_close(found[name], expected[name])
    torch.testing.assert_close(found["unrefined_depth"], expected["depth"])
    torch.testing.assert_close(kept["depth"], found["depth"])
    assert with_network_of(trained, asked, Path("weights")).network == network


@pytest.mark.slow
def test_only_the_same_run_goes_on(settings, rendered, copied, tmp_path, lines):
    short = settings.model_copy(update={"steps": 3})
    train(short, rendered, tmp_path, None, lines.append)
    last = tmp_path / "last.safetensors"
    for change, message in (
        ({"batch": 3}, "batch: expected 3, found 2 in the checkpoint"),
        ({"steps": 9}, "steps: expected 9, found 3 in the checkpoint"),
        ({"network": settings.network.model_copy(update={"planes": 9})}, r"network\.planes: expected 9, found"),
    ):
        with pytest.raises(InputError, match=message):
            train(short.model_copy(update=change), rendered, tmp_path, last, lines.append)
    rows = copied / "scenes" / "000001" / "checksums.json"
    rows.write_text(rows.read_text() + " ")
    with pytest.raises(
        InputError, match=r"data set: expected that of .*, found glassware with seed 3 and other content"
    ):
        train(short, copied, tmp_path, last, lines.append)
    with pytest.raises(InputError, match=r"a folder without last\.safetensors"):
        train(short, rendered, tmp_path, None, lines.append)
    other = tmp_path / "other"
    train(short, rendered, other, None, lines.append)
    with pytest.raises(InputError, match=r"a folder without last\.safetensors"):  # that run's would be lost
        train(short, rendered, other, last, lines.append)
    whole = load_checkpoint(last)
    name, moment = next((name, value) for name, value in whole.optimiser.items() if name.endswith(".exp_avg"))
    without = {other: value for other, value in whole.optimiser.items() if other != name}
    for change, message in (
        ({"optimiser": {}}, "optimiser: expected a state for the weights, found none"),
        ({"optimiser": without}, rf"optimiser: {name}: expected \(.*\), found none"),
        ({"optimiser": whole.optimiser | {name: moment[:-1]}}, rf"optimiser: {name}: expected"),
        ({"optimiser": whole.optimiser | {"other": moment.clone()}}, "optimiser: other: expected no such tensor"),
        ({"rng": whole.rng[:5]}, "rng: expected a state of torch's generator"),
    ):
        save_checkpoint(last, replace(whole, **change))
        with pytest.raises(InputError, match=rf"last\.safetensors: {message}"):
            train(short, rendered, tmp_path, last, lines.append)
    save_checkpoint(last, whole)
    # Where and how loudly it runs may change.
    train(short.model_copy(update={"log_every": 2}), rendered, tmp_path, last, lines.append)


@pytest.mark.parametrize(
    ("changes", "precision"),
    [
        ({"matching": "group", "fusion": "visibility", "readout": "windowed"}, "32-true"),
        ({"norm": "group"}, "bf16-mixed"),
    ],
)
def test_every_kind_of_network_trains(settings, rendered, tmp_path, lines, changes, precision):
    network = settings.network.model_copy(update=changes)
    machine = settings.machine.model_copy(update={"precision": precision})
    options = {
        "network": network,
        "machine": machine,
        "steps": 2,
        "optimiser": OptimiserSettings(name="adamw", schedule="cosine"),
    }
    train(settings.model_copy(update=options), rendered, tmp_path, None, lines.append)
    assert load_checkpoint(tmp_path / "last.safetensors").step == 2


@pytest.mark.slow
def test_the_reference_trains_and_its_checkpoint_loads(settings, rendered, tmp_path, lines):
    options = {"network": settings.network.model_copy(update={"variant": "reference"}), "steps": 1}
    with pytest.raises(InputError, match="to train the released network, found one of 96 x 128 px"):
        train(settings.model_copy(update=options | {"batch": 1}), rendered, tmp_path / "one", None, lines.append)
    train(settings.model_copy(update=options), rendered, tmp_path, None, lines.append)
    network, kept = load_network(tmp_path / "last.safetensors")
    assert kept.network.variant == "reference"
    assert sum(p.numel() for p in network.parameters()) == 49_749_487
