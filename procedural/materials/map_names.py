"""What a picture of a material shows, by its name: Poly Haven's, ambientCG's and other sites' conventions.

wood_table_001_diff_4k.jpg                Poly Haven: name, map, size
Wood051_1K-JPG_NormalGL.jpg               ambientCG: name, size and format, map
T_Brick_BaseColor.png, brick-albedo.png, Brick_Normal-ogl.png, color.png
T_Rock_D.png, T_Rock_N.png, T_Rock_ORM.png  Unreal Engine: letters, where both of the first two are there
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

Kind = Literal[
    "colour", "roughness", "glossiness", "metalness", "packed", "normal", "height", "unused", "preview", "plain"
]
"""What a picture shows. A plain picture's name says nothing; unused are maps that our materials have no place for."""

#: Maps by the last words of a name, without case and separators. The longest match counts.
_MAPS: dict[str, tuple[Kind, str]] = {
    **dict.fromkeys(("diff", "diffuse", "albedo", "color", "colour", "basecolor", "basecolour", "col"), ("colour", "")),
    **dict.fromkeys(("rough", "roughness", "rgh"), ("roughness", "")),
    **dict.fromkeys(("gloss", "glossiness"), ("glossiness", "")),
    **dict.fromkeys(("metal", "metalness", "metallic", "metallness", "mtl"), ("metalness", "")),
    **dict.fromkeys(("nor", "norm", "normal", "normals", "nrm", "normalmap"), ("normal", "opengl")),
    **dict.fromkeys(("norgl", "normalgl", "normalogl", "normalopengl", "nrmgl", "ngl"), ("normal", "opengl")),
    **dict.fromkeys(("nordx", "normaldx", "normaldirectx", "nrmdx", "ndx"), ("normal", "directx")),
    **dict.fromkeys(("disp", "displacement", "height", "heightmap", "bump", "depth"), ("height", "")),
    # Red, green, blue of packed maps; a is ambient occlusion, r roughness, m metalness.
    "arm": ("packed", "arm"),
    "orm": ("packed", "arm"),
    "aorm": ("packed", "arm"),
    "occlusionroughnessmetallic": ("packed", "arm"),
    "metallicroughness": ("packed", "arm"),
    "metalroughness": ("packed", "arm"),
    "rma": ("packed", "rma"),
    "mra": ("packed", "mra"),
    **dict.fromkeys(("ao", "ambientocclusion", "mixedao", "occlusion", "cavity", "curvature"), ("unused", "")),
    **dict.fromkeys(("spec", "specular", "specior", "specularlevel", "reflection", "refl", "ior"), ("unused", "")),
    **dict.fromkeys(("opacity", "alpha", "mask", "transmission", "translucent", "translucency", "sss"), ("unused", "")),
    **dict.fromkeys(("emission", "emissive", "anisotropyrotation", "anisotropystrength", "idmap"), ("unused", "")),
    **dict.fromkeys(("preview", "thumb", "thumbnail", "render", "sphere"), ("preview", "")),
}
#: Maps of whose words plain pictures are named too, such as rusty_metal.jpg: without a picture in colour of the same
#: name they are plain pictures.
AMBIGUOUS: frozenset[Kind] = frozenset({"colour", "metalness", "roughness", "unused", "preview", "height"})
#: Last letters of Unreal Engine's names, which say nothing where they stand alone: T_Rock_D, T_Rock_N, T_Rock_ORM.
_LETTERS: dict[str, Kind] = {
    **dict.fromkeys(("d", "bc", "c", "b", "a"), "colour"),
    "n": "normal",
    "r": "roughness",
    "m": "metalness",
    "h": "height",
    "s": "unused",
    "e": "unused",
}
# Sizes, formats, bit depths, numbered variants: words that say nothing of the map.
_SIDE = r"(?:256|512|1024|2048|4096|8192|16384)"
_NOISE = re.compile(rf"\d{{1,2}}k|{_SIDE}(px)?(x{_SIDE})?|jpe?g|png|exr|tiff?|\d{{1,2}}bits?|seamless|tileable")
_VARIANT = re.compile(r"\d{1,2}|[a-d]")
# Words: runs of lower case, capitals before lower case, or capitals; digits stay with them.
_WORD = re.compile(r"[A-Z]+(?![a-z])\d*|[A-Z]?[a-z]+\d*|\d+[A-Za-z]*")
_MOST_WORDS = 3


@dataclass(frozen=True)
class MapName:
    """What a file's name says.

    Parameters
    ----------
    base : str
        Name of the material, in lower case, without map, size and format; '' where the name is that of a map alone.
    kind : str
        What the picture shows.
    detail : str
        Of a normal map its convention, of a packed map what its channels hold.
    size : int
        Width that the name claims, in units of 1024 px; 0 where it claims none.
    variant : str
        The name without size and format: files of several sizes have one.
    """

    base: str
    kind: Kind
    detail: str = ""
    size: int = 0
    variant: str = ""


def map_name(stem: str) -> MapName:
    """Return what a file's name without its suffix says."""
    parts = [part for part in re.split(r"[-_ .()]+", stem) if part]
    kept = [part for part in parts if not _NOISE.fullmatch(part.lower())]
    variant = "_".join(kept).lower()
    size = max((int(part[:-1]) for part in parts if re.fullmatch(r"\d{1,2}[kK]", part)), default=0)
    for spoken in (kept, kept[:-1] if kept and _VARIANT.fullmatch(kept[-1].lower()) else []):
        found = _last_words(spoken)
        if found is not None:
            base, (kind, detail) = found
            return MapName(base, kind, detail, size, variant)
    return MapName(variant, "plain", "", size, variant)


def lettered(names: Mapping[str, MapName]) -> dict[str, MapName]:
    """Return the names of a folder's files (by their stems), of which those by single letters are read as such.

    They are where one colour and normals of one base are, and no letter that names no map: T_Rock_D and T_Rock_N, with
    T_Rock_ORM and others.
    """
    letters: dict[str, dict[str, str]] = defaultdict(dict)
    for stem, name in names.items():
        base, _, letter = name.variant.rpartition("_")
        if name.kind == "plain" and base and (len(letter) == 1 or letter in _LETTERS):
            letters[base][letter] = stem
    found = dict(names)
    for base, stems in letters.items():
        kinds = [_LETTERS.get(letter, "plain") for letter in stems]
        if kinds.count("colour") != 1 or "normal" not in kinds or "plain" in kinds:
            continue
        for letter, stem in stems.items():
            detail = "directx" if letter == "n" else ""  # Unreal's green points down
            found[stem] = replace(names[stem], base=base, kind=_LETTERS[letter], detail=detail)
    return found


def _last_words(parts: list[str]) -> tuple[str, tuple[Kind, str]] | None:
    """Return the rest of a name and the map that its last words name; None where they name none."""
    for count in range(min(_MOST_WORDS, len(parts)), 0, -1):
        word = "".join(parts[-count:]).lower()
        # coll1, col01: a number may follow the word.
        for text in (word, re.sub(r"\d{1,2}$", "", word), re.sub(r"(?<=col)l?\d{0,2}$", "", word)):
            if text in _MAPS:
                return "_".join(parts[:-count]).lower(), _MAPS[text]
    if not parts:
        return None
    # BrickBaseColor, WoodNormalGL: words that only capitals part.
    words = _WORD.findall(parts[-1])
    for count in range(min(_MOST_WORDS, len(words) - 1), 0, -1):
        text = "".join(words[-count:]).lower()
        if text in _MAPS and "".join(words) == parts[-1]:
            return "_".join([*parts[:-1], "".join(words[:-count])]).lower(), _MAPS[text]
    return None
