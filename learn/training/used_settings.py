"""Settings that a run does not use: those of other networks, and those that another setting switches off.

A file of settings may be shared by several networks, so only what is typed for one run is refused.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import get_args

from ...core.errors import InputError
from ..networks.settings import NetworkName
from .settings import TrainSettings

_ALL: tuple[NetworkName, ...] = get_args(NetworkName)
_OF_SCENES: tuple[NetworkName, ...] = ("mvtrans", "simnet")
#: The networks that use a setting or a group of settings; the longest name counts, and all use what is not here.
_NETWORKS: dict[str, tuple[NetworkName, ...]] = {
    "network": ("mvtrans",),
    "network.name": _ALL,
    "network.variant": _ALL,
    "network.simnet": ("simnet",),
    "network.keypose": ("keypose",),
    "network.densefusion": ("densefusion",),
    "views.pool": ("mvtrans",),
    "augment": ("mvtrans", "simnet", "keypose"),
    "pretrained": ("mvtrans",),
    "losses": ("mvtrans",),
    **dict.fromkeys(("losses.seg", "losses.heatmap", "losses.vertex", "losses.z_centroid"), _OF_SCENES),
    "losses.covariance": _OF_SCENES,
    "losses.disparity": ("simnet",),
    "losses.small_disparity": ("simnet",),
    **dict.fromkeys(("losses.keypoint", "losses.keypoint_disparity", "losses.projection"), ("keypose",)),
    "losses.probability": ("keypose",),
    "losses.distance": ("densefusion",),
    "losses.refined": ("densefusion",),
}
#: Settings that another one has to switch on, with the values by which it does.
_SWITCHES: dict[str, tuple[str, tuple[str, ...]]] = {
    "network.groups": ("network.matching", ("group",)),
    "network.window": ("network.readout", ("windowed",)),
    "network.context_width": ("network.context", ("resnet18", "resnet50")),
    "network.densefusion.completion": ("network.densefusion.depth", ("completed",)),
    "views.pool": ("views.rule", ("distance",)),
    "losses.planes": ("network.readout", ("windowed",)),
    "losses.unrefined_depth": ("network.refinement", ("half", "semi_global")),
    "losses.probability": ("network.keypose.head", ("integral",)),
    **dict.fromkeys(("validate_every", "validate_samples"), ("val_split", ("train", "val", "test", "all"))),
}
#: What the reference variant of MVTrans uses of the settings of networks and losses.
_REFERENCE = (
    "network.name",
    "network.variant",
    *(f"losses.{name}" for name in ("huber", "depth", "small_depth", "seg", "heatmap", "vertex", "z_centroid")),
    "losses.covariance",
)


def check_used(typed: Iterable[str], requested: TrainSettings, used: TrainSettings) -> None:
    """Refuse settings that were typed and have no effect.

    Parameters
    ----------
    typed : iterable of str
        Their dotted names, as YAML files have them.
    requested, used : TrainSettings
        As the user gave them, and as the run takes them, with what follows from its network.

    Raises
    ------
    InputError
        For the first setting that belongs to another network, needs another setting, or has another value in the run.
    """
    for name in typed:
        owners = _networks(name)
        if used.network.name not in owners:
            raise InputError(name, f"a setting of {used.network.name}", f"one of {', '.join(owners)}")
        for switch, values in _switches(name, used):
            found = _value(used, switch)
            if found not in values:
                raise InputError(name, f"{switch} {' or '.join(values)} with it, as it has no effect otherwise", found)
        given, value = _value(requested, name), _value(used, name)
        if given != value:
            raise InputError(name, f"{value}, which {used.network.name} takes here", given)


def _networks(name: str) -> tuple[NetworkName, ...]:
    while name not in _NETWORKS and name:
        name = name.rpartition(".")[0]
    return _NETWORKS.get(name, _ALL)


def _switches(name: str, used: TrainSettings) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield what has to be set for a setting to have an effect."""
    network, group = used.network.name, name.partition(".")[0]
    if name in _SWITCHES:
        yield _SWITCHES[name]
    if network == "keypose" and group == "augment":
        yield "network.keypose.augment", ("common",)
    of_variant = group in ("network", "losses") and name not in _REFERENCE
    if (network == "mvtrans" and of_variant) or name == "network.simnet.bins":
        yield "network.variant", ("corrected",)


def _value(settings: TrainSettings, name: str) -> object:
    found: object = settings
    for part in name.split("."):
        found = getattr(found, part)
    return found
