"""Pictures in MTL files: their names, how they lie on the surface, and maps of roughness, metalness and normals.

The options are those of the Alias/Wavefront manual (P. Bourke's copy, 1995): ``-s`` are factors on the texture
coordinates and ``-o`` is added to them then, as Blender and three.js read them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

from ...core.errors import InputError
from ...core.user_text import is_number
from ..description.material import ChannelMap, NormalMap, PictureTexture
from ..materials.map_names import map_name
from ..materials.picture_files import read_numbers
from .model import Source
from .references import named_file, picture

#: Arguments of the options before a picture's name: fewest and most.
_OPTIONS = {"-blendu": 1, "-blendv": 1, "-cc": 1, "-clamp": 1, "-texres": 1, "-bm": 1, "-imfchan": 1, "-boost": 1}
_OPTIONS |= {"-mm": 2, "-type": 1, "-colorspace": 1}
_VECTOR_OPTIONS = {"-o": 3, "-s": 3, "-t": 3}
#: Keys of maps and of what they are called in remarks. ``bump`` is the manual's second name of ``map_bump``.
_MAPS = {"map_pr": "roughness", "map_pm": "metalness", "norm": "normals", "map_kn": "normals"}
_BUMPS = ("map_bump", "bump")
#: Pictures that say how the others lie, in this order.
_PLACING = ("map_kd", "map_ka", "map_pr", "map_pm", "norm", "map_kn", *_BUMPS, "map_d", "map_ke")
#: Mean colour of pictures of normals, and how far it may be off [1]: normals point out of the surface on average.
_NORMAL, _NORMAL_REACH = np.array([0.5, 0.5, 1.0]), 0.2


def placement_of(entries: dict[str, str]) -> tuple[float, float, float, float]:
    """Return how a material's pictures lie: factors on u and v, and what is added to them then."""
    first = next((entries[key] for key in _PLACING if key in entries), "")
    return _placement(first)


def maps_of(source: Source, file: Path, entries: dict[str, str], name: str) -> dict[str, object]:
    """Return the maps of a material as fields of `OpaqueMaterial`.

    Exporters write pictures of normals as ``map_Bump``; those that are none hold heights without a unit, which a remark
    leaves out.
    """
    maps: dict[str, object] = {}
    placement = placement_of(entries)
    for key in (*_MAPS, *_BUMPS):
        if key not in entries:
            continue
        what = f"the {_MAPS.get(key, 'normals')} of material {name!r}"
        found = picture(source, named_file(source, file, picture_name(entries[key]), what), what)
        if found is None:
            continue
        if _placement(entries[key]) != placement:
            source.notes.say(f"{name!r}: a picture with texture coordinates of its own is not used")
        elif key == "map_pr":
            maps["roughness_map"] = ChannelMap(asset=found.asset)
        elif key == "map_pm":
            maps["metallic_map"] = ChannelMap(asset=found.asset)
        elif key in _BUMPS and not _holds_normals(found):
            source.notes.say(f"material {name!r}: its picture of heights is not used")
        else:
            normals = NormalMap(asset=found.asset, convention=_convention(found), strength=_strength(entries[key]))
            maps.setdefault("normal_map", normals)
    return maps


def _holds_normals(found: PictureTexture) -> bool:
    try:
        mean = read_numbers(found.asset.path).mean((0, 1))
    except InputError:
        return False  # told as a remark where pictures are checked
    return bool((np.abs(mean - _NORMAL) < _NORMAL_REACH).all())


def _convention(found: PictureTexture) -> Literal["opengl", "directx"]:
    return "directx" if map_name(found.asset.path.stem).detail == "directx" else "opengl"


def _strength(value: str) -> float:
    words = value.split()
    place = words.index("-bm") + 1 if "-bm" in words else len(words)
    stated = float(words[place]) if place < len(words) and is_number(words[place]) else 1.0
    return min(max(stated, 0.0), 4.0) if np.isfinite(stated) else 1.0


def _placement(value: str) -> tuple[float, float, float, float]:
    words = value.split()
    stated = {"-s": [1.0, 1.0], "-o": [0.0, 0.0]}
    for place, word in enumerate(words):
        if word.lower() in stated:
            numbers = stated[word.lower()]
            for k in range(2):
                text = words[place + 1 + k] if place + 2 + k < len(words) else ""
                if not is_number(text) or not np.isfinite(float(text)):
                    break
                numbers[k] = float(text)
    (su, sv), (ou, ov) = stated["-s"], stated["-o"]
    return su, sv, ou, ov


def picture_name(value: str) -> str:
    """Return the name of a picture without the options before it; names may hold spaces."""
    words = value.split()
    place = 0
    while place < len(words) and words[place].lower() in {**_OPTIONS, **_VECTOR_OPTIONS}:
        option = words[place].lower()
        place += 1
        if option in _OPTIONS:
            place += _OPTIONS[option]
            continue
        most = _VECTOR_OPTIONS[option]
        while most and place < len(words) - 1 and is_number(words[place]):
            place, most = place + 1, most - 1
    rest = words[place:]
    return value[value.index(rest[0], sum(map(len, words[:place]))) :] if rest else ""
