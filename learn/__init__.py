"""Networks: targets, MVTrans, losses, decoding, metrics, training and evaluation. Needs the extra `learn`."""

if __name__ != "glassware.learn":
    raise ImportError(f"this package is glassware.learn, not {__name__!r}: run from an installed checkout")

from .networks.reference import ReferenceNetwork, load_reference

__all__ = ["ReferenceNetwork", "load_reference"]
