"""All kinds of everyday things: how each is drawn and how large it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .cutlery import fork, knife, spoon
from .desk import cable, pen, phone
from .fruit import apple, banana, lemon, orange
from .kitchen import bowl, mug, napkin, plate, sponge, tray
from .laboratory import rack, stand
from .packages import book, can, carton
from .parts import Thing
from .tools import pliers, screwdriver, spanner


@dataclass(frozen=True)
class Kind:
    """A kind of thing."""

    draw: Callable[[np.random.Generator, float], Thing]  #: from a generator and its wear [0, 1]
    longest: tuple[float, float]  #: range of its longest side [m]
    source: str  #: where its sizes are from
    upright: float = 1.0  #: probability that it stands as it is used, not as it falls


#: By name. Where no standard is named, the sizes are those of things in shops and kitchens, measured to a few per cent.
KINDS: dict[str, Kind] = {
    "book": Kind(book, (0.170, 0.245), "book formats A, B, A5, demy and royal octavo", 0.9),
    "carton": Kind(carton, (0.07, 0.20), "folding cartons of medicine, tea and pasta", 0.8),
    "can": Kind(can, (0.072, 0.146), "food cans of 212 to 850 ml, drink cans of 250 and 330 ml", 0.85),
    "fork": Kind(fork, (0.18, 0.215), "table forks, 185-210 mm", 0.6),
    "knife": Kind(knife, (0.21, 0.245), "table knives, 215-240 mm", 0.0),
    "spoon": Kind(spoon, (0.128, 0.218), "tea spoons 130-150 mm, table spoons 190-215 mm", 0.7),
    "apple": Kind(apple, (0.058, 0.10), "EU marketing standard 543/2011: from 60 mm; shops have 62-85 mm", 0.7),
    "orange": Kind(orange, (0.062, 0.090), "EU marketing standard 543/2011: from 53 mm; shops have 63-88 mm", 0.0),
    "lemon": Kind(lemon, (0.055, 0.105), "EU marketing standard 543/2011: from 45 mm; shops have 50-62 mm", 0.0),
    "banana": Kind(banana, (0.13, 0.19), "EU standard 1333/2011: from 14 cm along the outer curve, 27 mm thick", 0.0),
    "plate": Kind(plate, (0.14, 0.27), "saucers and plates, 140-270 mm"),
    "bowl": Kind(bowl, (0.11, 0.18), "cereal and soup bowls, 110-180 mm"),
    "mug": Kind(mug, (0.09, 0.15), "mugs of 250-400 ml", 0.9),
    "tray": Kind(tray, (0.24, 0.37), "small serving trays; GN 1/2 is 325 x 265 mm"),
    "napkin": Kind(napkin, (0.16, 0.24), "napkins of 40-50 cm, folded"),
    "sponge": Kind(sponge, (0.085, 0.135), "kitchen sponges, 110 x 70 x 30 mm"),
    "pen": Kind(pen, (0.09, 0.177), "ballpoint pens of 135-150 mm, pencils of up to 176 mm", 0.0),
    "phone": Kind(phone, (0.142, 0.165), "phones of 6.1-6.7 inches"),
    "cable": Kind(cable, (0.07, 0.32), "USB and mains cables, coiled"),
    "screwdriver": Kind(screwdriver, (0.15, 0.236), "ISO 2380-2: blades of 75-125 mm", 0.0),
    "spanner": Kind(spanner, (0.118, 0.215), "combination spanners of 8-17 mm, DIN 3113 A"),
    "pliers": Kind(pliers, (0.15, 0.205), "combination pliers of 160-200 mm, DIN ISO 5746"),
    "test-tube rack": Kind(rack, (0.09, 0.29), "racks for 4-18 tubes of 16 mm"),
    "stand": Kind(stand, (0.25, 0.39), "small stands with a rod of 25-38 cm"),
}
