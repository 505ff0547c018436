"""MTL files beside OBJ files, in the dialects that exporters write and viewers read.

The format is that of "MTL material format (Lightwave, OBJ)", P. Bourke's copy of the Alias/Wavefront manual (1995),
with the physically based entries of Clara.io (Pr, Pm, map_Pr, map_Pm, norm), which `mtl_maps` reads.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ...core.user_text import is_number
from ..description.material import UniformTexture
from .cutouts import cutout
from .model import Cutout, GlassLook, Glow, Look, Source, content_of, text_of
from .mtl_maps import maps_of, picture_name, placement_of
from .references import named_file, picture

#: Opacity up to which a surface counts as glass [1], not as a faint tint of an opaque one.
GLASS_OPACITY = 0.5
#: CIE XYZ to linear Rec.709 (IEC 61966-2-1:1999).
_RGB_OF_XYZ = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])

Entries = dict[str, str]


def looks_of(source: Source, libraries: list[str], names: list[str | None]) -> dict[str | None, Look]:
    """Return the looks of the materials that an OBJ file uses, from its MTL files.

    Parameters
    ----------
    source : Source
        The OBJ file.
    libraries : list of str
        What follows ``mtllib``, a statement each.
    names : list
        The names that faces use; None for faces before any ``usemtl``.
    """
    entries: dict[str, tuple[Path, Entries]] = {}
    files = _library_files(source, libraries)
    for file in files:
        for name, found in mtl_entries(content_of_mtl(source, file)).items():
            entries.setdefault(name, (file, found))
    looks: dict[str | None, Look] = {}
    for name in names:
        if name in entries:
            looks[name] = look_of(source, *entries[name], name)
        elif name is None and len(names) == 1 and len(entries) == 1:
            # Faces that name no material have the only one there is.
            looks[name] = look_of(source, *next(iter(entries.values())), next(iter(entries)))
        elif name is not None and files:
            source.notes.say(f"expected a material {name!r} in {', '.join(libraries)}, found none")
    return looks


def content_of_mtl(source: Source, file: Path) -> bytes:
    """Return an MTL file's bytes."""
    return content_of(Source(file, source.root, source.pictures, source.notes))


def mtl_entries(content: bytes) -> dict[str, Entries]:
    """Return the entries of each material; of an entry that comes twice, the last one."""
    materials: dict[str, Entries] = {}
    entries: Entries = {}
    for line in text_of(content).splitlines():
        words = line.strip().split(maxsplit=1)
        if len(words) < 2 or words[0].startswith("#"):
            continue
        if words[0] == "newmtl":
            entries = materials.setdefault(words[1].strip(), {})
        else:
            entries[words[0].lower()] = words[1].strip()
    return materials


def look_of(source: Source, file: Path, entries: Entries, name: str) -> Look:
    """Return a material of an MTL file as a look.

    ``map_Kd`` is used unscaled, and ``Kd`` only without it: exporters write a default of 0.8 beside pictures. ``Ns`` is
    a Phong exponent: GGX alpha is sqrt(2 / (Ns + 2)) (Walter et al. 2007, section 5), and roughness its root.
    """
    chosen = next((key for key in ("map_kd", "map_ka") if key in entries), None)
    texture = None
    if chosen is not None:
        path = _picture_file(source, file, entries[chosen], f"the picture of material {name!r}")
        texture = picture(source, path, f"material {name!r}")
        if path is None and chosen == "map_kd" and "map_ka" in entries:
            path = _picture_file(source, file, entries["map_ka"], f"the ambient picture of material {name!r}")
            texture = picture(source, path, f"material {name!r}")
    colour = _colour(source, entries, "kd", name)
    if texture is None and colour is not None:
        texture = UniformTexture(colour=colour)
    opacity = _opacity(source, entries, name)
    glass = None
    if opacity is not None and opacity <= GLASS_OPACITY:
        index = _number(source, entries, "ni", name)
        glass = GlassLook(index=index if index is not None and 1.0 < index <= 4.0 else 1.5)
    maps = maps_of(source, file, entries, name)
    # Pictures are used without the factors beside them, as that of the colour is.
    metallic = 1.0 if "metallic_map" in maps else _unit(_number(source, entries, "pm", name))
    return Look(
        name=name,
        texture=texture,
        roughness=1.0 if "roughness_map" in maps else _roughness(source, entries, name),
        metallic=metallic,
        maps=maps,
        placement=placement_of(entries),
        glass=glass,
        cutout=_cutout(source, file, entries, name),
        plain=colour,
        glow=_glow(source, file, entries, name),
    )


def _library_files(source: Source, libraries: list[str]) -> list[Path]:
    """Return the MTL files of an OBJ file: each statement is one name, which may hold spaces, or several names."""
    found = []
    for text in libraries:
        whole = named_file(source, source.path, text, "its materials")
        several = text.split() if whole is None and len(text.split()) > 1 else []
        files = [whole, *(named_file(source, source.path, name, "its materials") for name in several)]
        found += [file for file in files if file is not None]
    if libraries and not found:
        # Renamed together: the MTL has the name of the OBJ.
        twin = source.path.with_suffix(".mtl")
        if twin.is_file():
            found.append(twin)
    return list(dict.fromkeys(found))


def _picture_file(source: Source, file: Path, value: str, what: str) -> Path | None:
    return named_file(source, file, picture_name(value), what)


def _colour(source: Source, entries: Entries, key: str, name: str) -> tuple[float, float, float] | None:
    if key not in entries:
        return None
    words = entries[key].split()
    if words[0].lower() == "spectral":
        source.notes.say(f"material {name!r}: spectral curves for {key} are not read")
        return None
    is_xyz = words[0].lower() == "xyz"
    try:
        values = [float(word) for word in words[1 if is_xyz else 0 :][:3]]
    except ValueError:
        values = []
    if not values or not all(math.isfinite(value) for value in values):
        source.notes.say(f"material {name!r}: expected three numbers for {key}, found {entries[key][:40]!a}")
        return None
    # One number stands for three (manual, "Kd r g b": g and b are optional).
    colour = np.array(values if len(values) == 3 else values[:1] * 3)
    if is_xyz:
        colour = _RGB_OF_XYZ @ colour
    if colour.max() > 1.0 and colour.max() <= 255.0 and np.array_equal(colour, np.round(colour)) and colour.max() > 2.0:
        colour = colour / 255.0  # written as bytes
    red, green, blue = np.clip(colour, 0.0, 1.0).tolist()
    return red, green, blue


def _roughness(source: Source, entries: Entries, name: str) -> float | None:
    stated = _unit(_number(source, entries, "pr", name))
    exponent = _number(source, entries, "ns", name)
    if stated is not None or exponent is None:
        return stated
    return float((2.0 / (max(0.0, exponent) + 2.0)) ** 0.25)


def _opacity(source: Source, entries: Entries, name: str) -> float | None:
    """Return ``d``, or one minus ``Tr``; None where neither is there or both deny each other."""
    opacity, transparency = _number(source, entries, "d", name), _number(source, entries, "tr", name)
    if opacity is None and transparency is not None:
        # Exporters disagree whether Tr 1 is opaque or clear; what is between 0 and 1 is the only sure case.
        opacity = 1.0 - transparency if 0.0 < transparency < 1.0 else None
    return opacity


def _cutout(source: Source, file: Path, entries: Entries, name: str) -> Cutout | None:
    if "map_d" not in entries:
        return None
    path = _picture_file(source, file, entries["map_d"], f"the opacity of material {name!r}")
    return None if path is None else cutout(source, path, 0.5, f"material {name!r}")


def _number(source: Source, entries: Entries, key: str, name: str) -> float | None:
    if key not in entries:
        return None
    word = entries[key].split()[-1]  # "d -halo 0.5"
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        source.notes.say(f"material {name!r}: expected a number for {key}, found {word[:40]!a}")
        return None
    return value


def _unit(value: float | None) -> float | None:
    return None if value is None else min(max(value, 0.0), 1.0)


def _glow(source: Source, file: Path, entries: Entries, name: str) -> Glow | None:
    """Return ``Ke`` and ``map_Ke`` as emission; a picture alone is unscaled, and beside black it is a default's."""
    words = entries.get("ke", "0").split()
    values = [float(word) for word in words[:3] if is_number(word)]
    colour = np.maximum(values if len(values) == 3 else values[:1] * 3 or [0.0] * 3, 0.0)
    brightest = float(colour.max())
    if "map_ke" in entries:
        path = _picture_file(source, file, entries["map_ke"], f"the emission of material {name!r}")
        found = picture(source, path, f"material {name!r}")
        if found is not None:
            return Glow(found, brightest if 0.0 < brightest < math.inf else 1.0)
    if not 0.0 < brightest < math.inf:
        return None
    red, green, blue = (colour / brightest).tolist()
    return Glow(UniformTexture(colour=(red, green, blue)), brightest)
