"""The files of soft mattes (`annotate.mattes`).

===================  ==============================================================================================
``mattes.exr``       half; ``A``: fraction of each pixel where there is any surface; ``coverage.<id>`` of every object;
                     ``transmittance.<id>.R,G,B`` of the transparent ones that cover anything
``cryptomatte.exr``  first surfaces by name, in the form of Cryptomatte
===================  ==============================================================================================
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...annotate.mattes import Mattes
from ...core.errors import InputError
from ...procedural.description.scene import TABLE_ID, Prop, Scene
from ...procedural.description.surroundings import FIRST_ROOM_ID, ROOM_IDS
from . import layout
from .cryptomatte import read_cryptomatte, write_cryptomatte
from .exr import channel, read_exr, stacked, unstacked, write_exr
from .objects_file import ObjectRecord

#: Room surfaces of one kind have up to so many ids [1] (`procedural.description.surroundings`).
_ROOM_STEP = 32


def write_mattes(folder: Path, scene: Scene, mattes: Mattes) -> None:
    """Write the mattes of a view."""
    shape = (mattes.coverage.shape[1], mattes.coverage.shape[2])
    total = np.sum([*mattes.first.values(), np.zeros(shape, np.float32)], axis=0)
    channels = {"A": total.astype(np.float16)}
    for item, coverage, passed in zip(scene.objects, mattes.coverage, mattes.transmittance, strict=True):
        channels[f"coverage.{item.id}"] = coverage.astype(np.float16)
        if not isinstance(item, Prop) and coverage.any():
            channels |= unstacked(passed.astype(np.float16), f"transmittance.{item.id}.RGB")
    write_exr(folder / layout.MATTES, channels)
    names = {item.id: item.name for item in scene.objects}
    found: dict[str, np.ndarray] = {}
    for number, coverage in mattes.first.items():
        name = names.get(number) or _surroundings(number)
        found[name] = found.get(name, 0.0) + coverage
    write_cryptomatte(folder / layout.CRYPTOMATTE, found, shape)


def read_mattes(folder: Path, objects: Sequence[ObjectRecord]) -> Mattes:
    """Return the mattes of a view.

    Parameters
    ----------
    folder : Path
        The view's folder.
    objects : sequence of ObjectRecord
        Those of ``objects.json``.

    Raises
    ------
    InputError
        Where a file is missing or damaged, or lacks an object.
    """
    path = folder / layout.MATTES
    channels = read_exr(path)
    shape = channel(channels, "A", path).shape
    coverage = np.zeros((len(objects), *shape), np.float32)
    transmittance = np.ones((len(objects), *shape, 3), np.float32)
    for place, item in enumerate(objects):
        coverage[place] = channel(channels, f"coverage.{item.id}", path)
        covers = coverage[place] > 0.0
        if item.material.kind == "glass" and covers.any():
            transmittance[place] = stacked(channels, f"transmittance.{item.id}.RGB", path)
        else:
            transmittance[place][covers] = 0.0
    ids = {item.name: item.id for item in objects} | {"table": TABLE_ID}
    ids |= {_surroundings(first): first for first in ROOM_IDS.values()}
    first = {}
    for name, values in read_cryptomatte(folder / layout.CRYPTOMATTE).items():
        if name not in ids or values.shape != shape:
            raise InputError(folder / layout.CRYPTOMATTE, f"objects of the scene, {shape} px", f"{name} {values.shape}")
        first[ids[name]] = values
    return Mattes(tuple(item.id for item in objects), first, coverage, transmittance)


def _surroundings(number: int) -> str:
    """Return the name of the table, or of a kind of a room's surfaces."""
    if number == TABLE_ID:
        return "table"
    parts = {first: part for part, first in ROOM_IDS.items()}
    return f"room-{parts[FIRST_ROOM_ID + (number - FIRST_ROOM_ID) // _ROOM_STEP * _ROOM_STEP]}"
