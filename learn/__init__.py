"""Networks: targets, MVTrans, losses, decoding, metrics, training and evaluation. Needs the extra `learn`.

Each name loads its module, and torch, when it is first used: the commands' help needs neither.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if __name__ != "glassware.learn":
    raise ImportError(f"this package is glassware.learn, not {__name__!r}: run from an installed checkout")

if TYPE_CHECKING:
    from .networks.build import build_network
    from .networks.mvtrans import MVTrans
    from .networks.reference import ReferenceMVTrans, load_reference
    from .networks.settings import NetworkSettings
    from .prediction.predictor import Prediction, Predictor, load

__all__ = [
    "MVTrans",
    "NetworkSettings",
    "Prediction",
    "Predictor",
    "ReferenceMVTrans",
    "build_network",
    "load",
    "load_reference",
]
#: The module of each public name.
_MODULES = {
    "MVTrans": "networks.mvtrans",
    "NetworkSettings": "networks.settings",
    "Prediction": "prediction.predictor",
    "Predictor": "prediction.predictor",
    "ReferenceMVTrans": "networks.reference",
    "build_network": "networks.build",
    "load": "prediction.predictor",
    "load_reference": "networks.reference",
}


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used (PEP 562)."""
    if name not in _MODULES:
        raise AttributeError(f"module 'glassware.learn' has no attribute {name!r}; it has {', '.join(__all__)}")
    value = getattr(import_module(f".{_MODULES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names, whether they are loaded or not."""
    return list(__all__)
