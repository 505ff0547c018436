"""Networks: targets, MVTrans, losses, decoding, metrics, training and evaluation. Needs the extra `learn`."""

if __name__ != "glassware.learn":
    raise ImportError(f"this package is glassware.learn, not {__name__!r}: run from an installed checkout")

from .networks.build import build_network
from .networks.mvtrans import MVTrans
from .networks.reference import ReferenceMVTrans, load_reference
from .networks.settings import NetworkSettings

__all__ = ["MVTrans", "NetworkSettings", "ReferenceMVTrans", "build_network", "load_reference"]
