"""Options that have no effect in a run are refused; those that have one are not."""

from __future__ import annotations

import pytest

from glassware.core.errors import InputError
from glassware.dataset.settings.config import typed_names
from glassware.learn.data.samples import collate
from glassware.learn.networks.build import build_network
from glassware.learn.training.loss_weights import LossWeights
from glassware.learn.training.methods import losses_of, outputs_of, samples_of, with_data, with_own_views
from glassware.learn.training.run import train
from glassware.learn.training.settings import TrainSettings
from glassware.learn.training.used_settings import check_used

#: Weights of no single loss: they are in one.
PARTS = {"huber", "object_pixels", "keypoint_disparity"}


def _check(words: str) -> None:
    """Check a command line of options with values, as `glassware train` does."""
    arguments = words.split()
    data: dict = {}
    for option, value in zip(arguments[::2], arguments[1::2], strict=True):
        *groups, last = option.removeprefix("--").replace("-", "_").split(".")
        place = data
        for group in groups:
            place = place.setdefault(group, {})
        place[last] = value
    requested = TrainSettings.model_validate(data)
    check_used(typed_names(TrainSettings, arguments), requested, with_own_views(requested))


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (
            "--network.keypose.head integral",
            "network.keypose.head: expected a setting of mvtrans, found one of keypose",
        ),
        ("--losses.projection 2", "losses.projection: expected a setting of mvtrans, found one of keypose"),
        (
            "--losses.seg 2 --network.name keypose",
            "losses.seg: expected a setting of keypose, found one of mvtrans, sim",
        ),
        (
            "--network.planes 8 --network.name simnet",
            "network.planes: expected a setting of simnet, found one of mvtrans",
        ),
        (
            "--augment.hue 0.2 --network.name densefusion",
            "augment.hue: expected a setting of densefusion, found one of",
        ),
        ("--augment.hue 0.2 --network.name keypose", "augment.hue: expected network.keypose.augment common with it"),
        ("--augment.flip 0.4 --network.name simnet", "augment.flip: expected 0.0, which simnet takes here, found 0.4"),
        (
            "--views.rule distance --network.name simnet",
            "views.rule: expected stereo, which simnet takes here, found di",
        ),
        (
            "--views.convergence 0.5 --network.name simnet",
            "views.convergence: expected none: simnet takes whole pictures, found 0.5",
        ),
        (
            "--losses.planes 2",
            "losses.planes: expected network.readout windowed with it, as it has no effect otherwise",
        ),
        (
            "--network.planes 8 --network.variant reference",
            "network.planes: expected network.variant corrected with it",
        ),
        ("--losses.offset 2 --network.variant reference", "losses.offset: expected network.variant corrected with it"),
        (
            "--validate-every 5 --val-split none",
            "validate_every: expected val_split train or val or test or all with it",
        ),
    ],
)
def test_an_option_without_effect_is_refused_in_one_line(words, line):
    with pytest.raises(InputError) as error:
        _check(words)
    assert str(error.value).startswith(line)


@pytest.mark.parametrize(
    "words",
    [
        "--network.name keypose --network.keypose.head integral --losses.probability 1 --losses.projection 0",
        "--network.name keypose --network.keypose.augment common --augment.hue 0.2 --augment.flip 0",
        "--network.name simnet --views.rule stereo --network.simnet.bins 9 --losses.seg 2",
        "--network.variant reference --losses.huber 0.5 --losses.heatmap 5 --steps 3 --optimiser.clip 2",
        "--network.readout windowed --network.window 3 --losses.planes 2 --views.pool 3",
        "--network.name densefusion --network.densefusion.points 99 --losses.refined 2",
    ],
)
def test_an_option_with_an_effect_is_taken(words):
    _check(words)


def test_names_of_options_are_those_of_settings():
    words = [
        "data",
        "--network=simnet",
        "--network.no-heads-see-context",
        "--val-split",
        "none",
        "--out",
        "x",
        "--steps",
    ]
    typed = typed_names(TrainSettings, words)
    assert typed == ("network.name", "network.heads_see_context", "val_split", "steps")


def test_a_run_from_the_weights_of_another_network_has_its_views_and_its_options(rendered, tmp_path):
    small = {"name": "keypose", "keypose": {"crop": [32, 48], "filters": 4}}
    machine = {"accelerator": "cpu", "workers": 0, "threads": 1}
    data = {"network": small, "machine": machine, "steps": 1, "batch": 1, "val_split": "none"}
    train(TrainSettings.model_validate(data), rendered, tmp_path / "a", None, lambda _: None)
    weights, plain = tmp_path / "a" / "last.safetensors", TrainSettings()
    for name, line in (
        ("losses.offset", "losses.offset: expected a setting of keypose, found one of mvtrans"),
        ("views.rule", "views.rule: expected stereo, which keypose takes here, found distance"),
    ):
        with pytest.raises(InputError) as error:
            train(plain, rendered, tmp_path / "b", None, lambda _: None, weights, (name,))
        assert str(error.value) == line


@pytest.mark.slow
@pytest.mark.parametrize("variant", ["corrected", "reference"])
@pytest.mark.parametrize("name", ["mvtrans", "simnet", "keypose", "densefusion"])
def test_the_losses_that_are_taken_are_those_of_the_network(rendered, tiny, name, variant):
    options = {"keypose": {"head": "integral", "crop": [32, 48], "filters": 4}, "densefusion": {"depth": "true"}}
    network = {**tiny.model_dump(), "readout": "windowed", "refinement": "half", "variant": variant, "name": name}
    network |= {key: value for key, value in options.items() if key == name}
    requested = TrainSettings.model_validate({"network": network, "augment": {"probability": 0.0}})
    used, samples = with_data(with_own_views(requested), samples_of(with_own_views(requested), rendered, "train"))
    batch = collate([samples[(0, 0)]])
    net, found = build_network(used.network).eval(), set()
    for progress in (0.0, 1.0):
        found |= losses_of(outputs_of(net, batch, used.network, progress), batch, used, progress).keys()
    for loss in sorted(LossWeights.model_fields.keys() - PARTS):
        try:
            check_used((f"losses.{loss}",), requested, used)
        except InputError:
            assert loss not in found
        else:
            assert loss in found
