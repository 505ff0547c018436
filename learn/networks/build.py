"""The network of given settings."""

from __future__ import annotations

from .corrected import CorrectedNetwork
from .reference import ReferenceNetwork
from .settings import NetworkSettings

Network = CorrectedNetwork | ReferenceNetwork


def build_network(settings: NetworkSettings) -> Network:
    """Return a network with new weights, drawn by torch's global generator."""
    return ReferenceNetwork() if settings.variant == "reference" else CorrectedNetwork(settings)
