"""SimNet, KeyPose and DenseFusion go the whole way of MVTrans: training, resuming, evaluation, one sample by heart."""

from __future__ import annotations

import json

import pytest
import torch
import yaml

from glassware.core.errors import InputError
from glassware.dataset.commands.glassware import main
from glassware.learn import build_network
from glassware.learn.data.samples import collate
from glassware.learn.decoding.keypoints import points_in_space
from glassware.learn.evaluation.run import evaluate
from glassware.learn.evaluation.score import score_sample
from glassware.learn.targets.encoding import CORRECTED
from glassware.learn.training.checkpoint import load_checkpoint, load_network
from glassware.learn.training.loss_weights import LossWeights
from glassware.learn.training.losses import total_loss
from glassware.learn.training.methods import losses_of, outputs_of, samples_of, with_data, with_own_views
from glassware.learn.training.object_losses import model_distances
from glassware.learn.training.run import train
from glassware.learn.training.settings import TrainSettings

#: Networks that are as small as they come; SimNet has no sizes.
SMALL = {
    "simnet": {},
    "keypose": {"keypose": {"crop": [32, 48], "filters": 8}},
    "densefusion": {"densefusion": {"depth": "true", "points": 32, "model_points": 32, "crop": 40}},
}


def settings(name: str, variant: str = "corrected", **changes) -> TrainSettings:
    data = {
        "network": {"name": name, "variant": variant, **SMALL[name]},
        "machine": {"accelerator": "cpu", "workers": 0, "threads": 1},
        "steps": 4,
        "batch": 2,
        "save_every": 2,
        "validate_every": 2,
        "validate_samples": 2,
        "log_every": 1,
        "pictures_every": 4,
    }
    return TrainSettings.model_validate(data | changes)


def quiet(_line: str) -> None:
    pass


def test_keypose_trains_and_is_evaluated_by_the_commands(rendered, tmp_path, capsys):
    written = settings("keypose").model_dump(mode="json")
    written["network"] = {"keypose": SMALL["keypose"]["keypose"]}
    (tmp_path / "run.yaml").write_text(yaml.safe_dump(written))
    out = str(tmp_path / "run")
    assert (
        main(["train", str(rendered), "--network", "keypose", "--config", str(tmp_path / "run.yaml"), "--out", out])
        == 0
    )
    options = ["--device", "cpu", "--threads", "1", "--workers", "0", "--out", out]
    assert main(["evaluate", f"{out}/last.safetensors", str(rendered), *options]) == 0
    assert "location" in capsys.readouterr().out
    report = json.loads((tmp_path / "run" / "report.json").read_text())
    truth, jitter = (report["locations"][name] for name in ("truth", "jitter"))
    assert truth["keypoints"]["objects"] == jitter["keypoints"]["objects"] > 0
    assert truth["keypoints"] != jitter["keypoints"]
    assert truth["constant"]["objects"] == truth["keypoints"]["objects"]
    assert truth["constant"]["mae"] < jitter["constant"]["mae"]
    assert truth["dropped"] == truth["missed"] == truth["lost"] == 0
    view = rendered / "scenes" / "000001" / "003"
    pictures = [str(view / "left.png"), str(view / "right.png")]
    assert main(["predict", f"{out}/last.safetensors", *pictures, "--device", "cpu", "--out", out]) == 2
    assert "expected a network that finds objects (mvtrans, simnet), found keypose" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("variant", ["corrected", "reference"])
@pytest.mark.parametrize("name", SMALL)
def test_a_run_that_was_stopped_goes_on_exactly(rendered, tmp_path, name, variant):
    chosen = settings(name, variant, steps=6 if name == "densefusion" else 4)
    train(chosen, rendered, tmp_path / "whole", None, quiet)

    def stop(line: str) -> None:
        if line.startswith("step 3/"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(chosen, rendered, tmp_path / "part", None, stop)
    train(chosen, rendered, tmp_path / "part", tmp_path / "part" / "last.safetensors", quiet)
    whole, part = (load_checkpoint(tmp_path / one / "last.safetensors") for one in ("whole", "part"))
    assert whole.network.keys() == part.network.keys()
    assert all(torch.equal(whole.network[key], part.network[key]) for key in whole.network)
    if name == "densefusion":  # the last steps were of the refiner
        assert int(whole.network["refiner_steps"]) > 0
    network, kept = load_network(tmp_path / "whole" / "last.safetensors")
    before = {key: value.clone() for key, value in network.state_dict().items()}
    found = evaluate(tmp_path / "whole" / "last.safetensors", rendered, "val", tmp_path / "report", quiet, worst=0)
    assert found["network"] == kept.network.name == name
    assert all(torch.equal(value, before[key]) for key, value in network.state_dict().items())


@pytest.mark.slow
def test_a_detector_says_where_objects_are(rendered, tmp_path):
    for name in ("simnet", "keypose"):
        train(settings(name, steps=1), rendered, tmp_path / name, None, quiet)
    paths = [tmp_path / name / "last.safetensors" for name in ("keypose", "simnet")]
    found = evaluate(paths[0], rendered, "val", tmp_path / "report", quiet, detector=paths[1])
    detected = found["locations"]["detector"]
    assert detected["missed"] == detected["keypoints"]["objects"]  # a new SimNet has no heat
    with pytest.raises(InputError, match="mvtrans or simnet"):
        evaluate(paths[0], rendered, "val", tmp_path / "report", quiet, detector=paths[0])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "steps", "rate"), [("simnet", 240, 2e-3), ("keypose", 300, 3e-3), ("densefusion", 150, 2e-4)]
)
def test_a_network_learns_one_sample_by_heart(rendered, name, steps, rate):
    options = {"keypose": {"crop": [32, 48], "filters": 24}, "densefusion": {"depth": "true", "points": 64, "crop": 40}}
    network = {"name": name, name: options.get(name, {})}
    chosen = with_own_views(TrainSettings.model_validate({"network": network, "augment": {"probability": 0.0}}))
    chosen, samples = with_data(chosen, samples_of(chosen, rendered, "train", ground_truth=True))
    batch = collate([samples[(0, 0)]])
    net = build_network(chosen.network).train()
    optimiser = torch.optim.Adam(net.parameters(), lr=rate)
    for step in range(steps):
        outputs = outputs_of(net, batch, chosen.network, 0.0)
        loss = total_loss(losses_of(outputs, batch, chosen, step / steps), LossWeights())
        optimiser.param_groups[0]["lr"] = rate * (1.0 - step / steps)
        optimiser.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 10.0)
        optimiser.step()
    with torch.inference_mode():
        # SimNet by the statistics of the batch: at one picture and a falling rate the averages come late.
        outputs = outputs_of(net.train(name == "simnet"), batch, chosen.network)
    if name == "keypose":
        found = points_in_space(outputs["keypoints"], batch.K, batch.targets["baseline"])
        assert float((found - batch.targets["points"][:, 0]).norm(dim=2).max()) < 0.02
    elif name == "densefusion":
        distance = model_distances(
            outputs["pose"][:, None],
            batch.targets["model"],
            batch.targets["model"] @ batch.targets["pose"][:, :3, :3].mT + batch.targets["pose"][:, None, :3, 3],
            batch.targets["symmetric"],
        )
        assert float(distance) < 0.01
    else:
        (labels,) = batch.ground_truths
        assert labels is not None
        score = score_sample("one", outputs, batch.K[0, 0], labels, CORRECTED)
        # A tenth of a pixel of disparity is 7 mm here.
        assert score.full["objects"] is not None
        assert score.full["objects"].mae < 0.04
        # The peak of a small object is a small part of the loss of the heatmap, and comes last.
        found = [item.iou > 0.5 for item in score.objects]
        assert sum(found) >= max(1, len(found) - 1), [item.iou for item in score.objects]
