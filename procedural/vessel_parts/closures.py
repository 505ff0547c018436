"""Caps, corks, lids and stoppers."""

from __future__ import annotations

import numpy as np

from ..description.bodies import GlassBody, Prop
from ..description.material import OpaqueMaterial, ProceduralTexture, UniformTexture
from ..optics.medium import Medium
from ..props.revolution import Piece, revolve, rounded
from .attach import CONTACT, glass_part, opaque_part
from .host import Host

#: Thickness of a cap's wall and of its top, rounding of its edges [m].
_CAP_WALL, _CAP_TOP, _CAP_EDGE = (1.0e-3, 1.8e-3), (1.2e-3, 2.2e-3), 0.6e-3
#: Heights of caps [m]: of bottles (28 mm finishes have caps of 15 to 20 mm), of PET bottles, of jars, of vials.
CAP_HEIGHTS = {
    "bottle": (0.013, 0.02),
    "plastic bottle": (0.013, 0.0155),
    "jar": (0.012, 0.015),
    "vial": (0.006, 0.0075),
}
#: A cap covers the neck as far down as that is not wider than this over the rim's radius [1].
_WIDER = 1.25
#: Cork: how far it goes in and stands out [m]; how often it has a head, which is this much wider than the mouth [1].
_CORK_DEPTH, _CORK_OUT, _HEADED, _HEAD = (0.012, 0.024), (0.005, 0.014), 0.35, (1.05, 1.3)
#: Stopper of glass: how far its plug goes in, its neck, and the head's height and radius over the mouth's [m, 1].
_PLUG, _STEM, _STOPPER_HEAD, _STOPPER_RADIUS = (0.014, 0.02), 0.004, (0.012, 0.02), (1.0, 1.35)
#: Colours of caps, linear Rec.709: white, black, red, blue, green, gold lacquer; matched by eye to common closures.
COLOURS = (
    (0.75, 0.75, 0.74),
    (0.02, 0.02, 0.022),
    (0.45, 0.03, 0.025),
    (0.03, 0.09, 0.36),
    (0.03, 0.22, 0.07),
    (0.50, 0.36, 0.12),
)
#: Cork's light and dark, linear Rec.709 [1].
_CORK_COLOURS = ((0.42, 0.27, 0.15), (0.56, 0.39, 0.24))
#: Least radius of a plug, and least distance of a plug's end from the liquid [m].
_LEAST_PLUG, _ABOVE_LIQUID = 0.003, 0.003


def draw_cap(rng: np.random.Generator, host: Host, heights: tuple[float, float], category: str = "cap") -> Prop | None:
    """Draw a cap over the rim; None where the neck is too short for one."""
    height = rng.uniform(*heights)
    wall, top, colour = rng.uniform(*_CAP_WALL), rng.uniform(*_CAP_TOP), COLOURS[int(rng.integers(len(COLOURS)))]
    metal, gloss = rng.random() < (0.7 if category == "lid" or heights[1] < 0.01 else 0.15), rng.uniform(0.2, 0.5)
    below = host.rim - np.linspace(0.0, height, 64)
    radius = np.maximum.accumulate(host.radius(below))
    covered = float((host.rim - below)[radius <= _WIDER * radius[2]].max())
    if covered < 0.5 * heights[0]:
        return None
    widest = max(float(np.interp(covered, host.rim - below, radius)) * (1.0 + 0.005), host.widest(host.rim - covered))
    inner = widest + 2.0 * CONTACT + 1e-4
    pieces = _shell(inner, inner + wall, covered, top)
    mesh, _ = revolve(f"{host.body.name}-{category}", pieces)
    look = UniformTexture(colour=(0.913, 0.922, 0.924) if metal and heights[1] < 0.01 else colour)
    material = OpaqueMaterial(
        name="metal" if metal else "plastic", base_colour=look, roughness=gloss, metallic=1.0 if metal else 0.0
    )
    place = np.array([*host.axis_at_rim, host.rim + CONTACT + 0.5 * (top - covered)])
    return opaque_part(host.body.name, category, mesh, material, place, symmetric=True)


def draw_cork(rng: np.random.Generator, host: Host) -> Prop | None:
    """Draw a cork in the mouth; None where it is too narrow, or the liquid stands in the neck."""
    depth, out = rng.uniform(*_CORK_DEPTH), rng.uniform(*_CORK_OUT)
    headed, head, seed = rng.random() < _HEADED, rng.uniform(*_HEAD), int(rng.integers(2**31))
    radius = _plug_radius(host, depth)
    if radius is None:
        return None
    taper = 0.97
    corners = [(0.0, -depth), (taper * radius, -depth)]
    if headed:
        wide = head * float(host.radius(np.array(host.rim - 1e-3)))
        corners += [(radius, 2.0 * CONTACT), (wide, 2.0 * CONTACT), (wide, out), (0.0, out)]
        radii = [1e-3, 0.0, 4e-4, 8e-4]
    else:
        corners += [(radius, out), (0.0, out)]
        radii = [1e-3, 8e-4]
    mesh, unit = revolve(f"{host.body.name}-cork", rounded(corners, radii))
    texture = ProceduralTexture(kind="noise", colours=_CORK_COLOURS, seed=seed, resolution=256)
    material = OpaqueMaterial(name="cork", base_colour=texture, repeats=max(1.0, round(unit / 0.03)), roughness=0.9)
    place = np.array([*host.axis_at_rim, host.rim + 0.5 * (out - depth)])
    return opaque_part(host.body.name, "cork", mesh, material, place, symmetric=True)


def draw_stopper(rng: np.random.Generator, host: Host, glass: Medium) -> GlassBody | None:
    """Draw a stopper of glass in the mouth; None as for corks."""
    depth, head = rng.uniform(*_PLUG), rng.uniform(*_STOPPER_HEAD)
    wide = rng.uniform(*_STOPPER_RADIUS)
    radius = _plug_radius(host, depth)
    if radius is None:
        return None
    stem = 0.75 * radius
    grip = max(wide * float(host.radius(np.array(host.rim - 1e-3))), 1.5 * radius)
    corners = [
        (0.0, -depth),
        (0.94 * radius, -depth),
        (radius, 0.001),
        (stem, 0.001 + 0.5 * _STEM),
        (stem, 0.001 + _STEM),
        (grip, 0.003 + _STEM),
        (grip, 0.001 + _STEM + 0.45 * head),
        (0.6 * grip, 0.001 + _STEM + head),
        (0.0, 0.001 + _STEM + head),
    ]
    mesh, _ = revolve(f"{host.body.name}-stopper", rounded(corners, [5e-4, 4e-4, 5e-4, 8e-4, 8e-4, 1e-3, 1.5e-3]))
    top = 0.001 + _STEM + head
    place = np.array([*host.axis_at_rim, host.rim + 0.5 * (top - depth)])
    return glass_part(host.body.name, "stopper", mesh, glass, place)


def draw_pot_lid(rng: np.random.Generator, host: Host, glass: Medium) -> GlassBody:
    """Draw the glass lid of a teapot: a hollow dome with a knob, on the rim."""
    rim = float(host.radius(np.array(host.rim - 1e-3)))
    wide, rise, knob = rim + 0.001, rim * rng.uniform(0.25, 0.4), rng.uniform(0.006, 0.008)
    thick = rng.uniform(0.002, 0.003)
    neck = 0.6 * knob
    corners = [
        (0.0, rise),
        (0.4 * wide, rise),
        (wide - 0.006, 0.0),
        (wide, 0.0),
        (wide, thick),
        (0.45 * wide, rise + thick),
        (neck, rise + thick + 0.001),
        (neck, rise + thick + 0.004),
        (knob, rise + thick + 0.007),
        (knob, rise + thick + 0.013),
        (0.0, rise + thick + 0.016),
    ]
    radii = [0.01, 1.5e-3, 8e-4, 8e-4, 0.01, 1e-3, 1e-3, 1.5e-3, 2.5e-3]
    mesh, _ = revolve(f"{host.body.name}-lid", rounded(corners, radii))
    height = rise + thick + 0.016
    place = np.array([*host.axis_at_rim, host.rim + CONTACT + 0.5 * height])
    return glass_part(host.body.name, "lid", mesh, glass, place)


def _shell(inner: float, outer: float, covered: float, top: float) -> list[Piece]:
    """Return the profile of a cap whose top's underside is at z = 0."""
    corners = [
        (0.0, 0.0),
        (inner, 0.0),
        (inner, -covered),
        (outer, -covered),
        (outer, top),
        (0.0, top),
    ]
    return rounded(corners, [0.0, 2e-4, 2e-4, _CAP_EDGE])


def _plug_radius(host: Host, depth: float) -> float | None:
    """Return the radius of a plug that goes into the mouth; None where there is no room for one."""
    heights = host.rim - np.linspace(0.0, depth, 32)
    radius = min(host.bore(float(z)) for z in heights[4:]) - CONTACT
    liquid = host.body.liquid
    if radius < _LEAST_PLUG or (liquid is not None and liquid.contact > host.rim - depth - _ABOVE_LIQUID):
        return None
    return radius
