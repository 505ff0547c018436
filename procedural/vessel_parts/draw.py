"""Draw what goes with a vessel: which parts its family has, and how often."""

from __future__ import annotations

import numpy as np

from ..description.bodies import GlassBody, Prop
from ..vessels.settings import VesselSettings
from .closures import CAP_HEIGHTS, draw_cap, draw_cork, draw_pot_lid, draw_stopper
from .host import Host
from .labels import draw_label, draw_mark, draw_scale
from .stands import draw_block, draw_ring

#: How often a closed bottle has a cork, not a cap [1]: most drinks in glass have caps.
CORKS = 0.4
#: Families that do not stand by themselves.
LYING = ("test tube", "round flask")
_BOTTLES, _FLASKS = ("bottle", "square bottle", "oval bottle"), ("volumetric flask", "round flask")
_LABELLED, _SCALED = (*_BOTTLES, "plastic bottle", "jar", "vial"), ("beaker", "spouted beaker", "flask")


def draw_parts(
    rng: np.random.Generator, settings: VesselSettings, host: Host, *, stands: bool
) -> tuple[Prop | GlassBody, ...]:
    """Draw the parts of a vessel.

    Parameters
    ----------
    rng : numpy.random.Generator
        The stream of the vessel's parts.
    settings : VesselSettings
        How often vessels are closed and labelled.
    host : Host
        The vessel.
    stands : bool
        Whether one that does not stand by itself is held by something.

    Returns
    -------
    tuple of Prop or GlassBody
        With poses in the vessel's frame, and ids that are still to be set.
    """
    closed, labelled = rng.random() < settings.closed_probability, rng.random() < settings.label_probability
    found = [
        _closure(rng, host) if closed else None,
        _print(rng, host) if labelled else None,
        _stand(rng, host) if stands else None,
    ]
    return tuple(part for part in found if part is not None)


def _closure(rng: np.random.Generator, host: Host) -> Prop | GlassBody | None:
    category, glass = host.body.category, host.body.glass
    corked = rng.random() < CORKS
    if category in _BOTTLES:
        first, second = (draw_cork, _bottle_cap) if corked else (_bottle_cap, draw_cork)
        return first(rng, host) or second(rng, host)
    if category in CAP_HEIGHTS:
        return draw_cap(rng, host, CAP_HEIGHTS[category], "lid" if category == "jar" else "cap")
    if category in _FLASKS:
        return draw_stopper(rng, host, glass)
    if category == "test tube":
        return draw_cork(rng, host)
    return draw_pot_lid(rng, host, glass) if category == "teapot" else None


def _bottle_cap(rng: np.random.Generator, host: Host) -> Prop | None:
    return draw_cap(rng, host, CAP_HEIGHTS["bottle"])


def _print(rng: np.random.Generator, host: Host) -> Prop | None:
    category = host.body.category
    if category in _LABELLED:
        return draw_label(rng, host)
    if category in _SCALED:
        return draw_scale(rng, host)
    return draw_mark(rng, host) if category == "volumetric flask" else None


def _stand(rng: np.random.Generator, host: Host) -> Prop | None:
    if host.body.category == "test tube":
        return draw_block(rng, host)
    return draw_ring(rng, host) if host.body.category == "round flask" else None
