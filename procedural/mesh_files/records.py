"""Small files beside meshes that say what they are: categories, licences, symmetries. A damaged one says nothing."""

from __future__ import annotations

import gzip
import json
import math
import re
import zlib
from functools import lru_cache
from pathlib import Path
from typing import Any

from .synsets import SYNSETS

#: Most bytes of a record that are read, unpacked: Objaverse's lists of categories take 4 MB, a shard's metadata 10 MB.
_LARGEST_RECORD = 64 * 2**20
_LICENCE_NAMES = ("license", "licence", "license.txt", "licence.txt", "license.md", "licence.md", "copying")
_KNOWN_LICENCES = (
    (re.compile(r"\bCC0\b|creativecommons\.org/publicdomain/zero", re.IGNORECASE), "CC0"),
    (re.compile(r"\bCC[ -]BY[ -]NC[ -]SA\b|licenses/by-nc-sa", re.IGNORECASE), "CC BY-NC-SA"),
    (re.compile(r"\bCC[ -]BY[ -]NC\b|licenses/by-nc/", re.IGNORECASE), "CC BY-NC"),
    (re.compile(r"\bCC[ -]BY[ -]SA\b|licenses/by-sa", re.IGNORECASE), "CC BY-SA"),
    (re.compile(r"\bCC[ -]BY\b|licenses/by/|Creative Commons Attribution 4", re.IGNORECASE), "CC BY"),
    (re.compile(r"\bMIT License\b", re.IGNORECASE), "MIT"),
    (re.compile(r"\bApache License\b", re.IGNORECASE), "Apache 2.0"),
    (re.compile(r"\bpublic domain\b", re.IGNORECASE), "public domain"),
)
#: Sketchfab's short names, as Objaverse's metadata has them.
_OBJAVERSE_LICENCES = {
    "by": "CC BY 4.0",
    "by-sa": "CC BY-SA 4.0",
    "by-nc": "CC BY-NC 4.0",
    "by-nc-sa": "CC BY-NC-SA 4.0",
    "cc0": "CC0",
}


def synset_name(synset: str, path: Path, root: Path) -> str:
    """Return the first name of a WordNet synset: from taxonomy.json in the folder or above the model, else built in."""
    for folder in (root, *path.absolute().parents[2:5]):
        records = _json(folder / "taxonomy.json")
        for record in records if isinstance(records, list) else []:
            if isinstance(record, dict) and record.get("synsetId") == synset and isinstance(record.get("name"), str):
                return record["name"].split(",")[0].strip() or synset
    return SYNSETS.get(synset, synset)


def gso_category(folder: Path) -> str | None:
    """Return the category in an object's metadata.pbtxt; None where it has none."""
    match = re.search(r"categories\s*\{\s*first:\s*\"([^\"]{1,80})\"", _text(folder / "metadata.pbtxt"))
    return match[1] if match else None


def bop_symmetries(path: Path, number: int) -> tuple[bool, tuple[tuple[float, ...], ...]]:
    """Return whether models_info.json states turns about z, and its discrete symmetries, 16 numbers each, row-major."""
    records = _json(path)
    record = records.get(str(number)) if isinstance(records, dict) else None
    if not isinstance(record, dict):
        return False, ()
    turns = False
    for item in _list(record.get("symmetries_continuous")):
        axis = _list(item.get("axis")) if isinstance(item, dict) else []
        turns = turns or axis in ([0, 0, 1], [0, 0, -1])
    found = []
    for item in _list(record.get("symmetries_discrete")):
        numbers = [float(x) for x in _list(item) if isinstance(x, int | float) and math.isfinite(x)]
        if len(numbers) == 16:
            found.append(tuple(numbers))
    return turns, tuple(found)


def objaverse_record(path: Path, root: Path) -> tuple[str | None, str]:
    """Return an object's LVIS category (None without one) and licence from Objaverse's files above it."""
    category: str | None = None
    licence = "unknown"
    for folder in (root, *path.absolute().parents[1:4]):
        category = category or _lvis(folder / "lvis-annotations.json.gz").get(path.stem)
        records = _json(folder / "metadata" / f"{path.parent.name}.json.gz")
        record = records.get(path.stem) if isinstance(records, dict) else None
        if isinstance(record, dict) and isinstance(record.get("license"), str):
            short = str(record["license"])[:80]
            licence = _OBJAVERSE_LICENCES.get(short, short)
    return category, licence


@lru_cache(maxsize=4096)
def licence_beside(folder: Path, root: Path) -> str:
    """Return the licence that a file such as LICENSE states, nearest above a mesh inside the user's folder."""
    for place in (folder, *folder.parents):
        if not place.is_relative_to(root):
            break
        for path in _entries(place):
            if path.name.lower() in _LICENCE_NAMES:
                return licence_named(_text(path)) or "unknown"
    return "unknown"


def licence_named(text: str) -> str:
    """Return a licence by its short name, else the first line of its text."""
    for pattern, name in _KNOWN_LICENCES:
        if pattern.search(text):
            return name
    return next((line.strip()[:80] for line in text.splitlines() if line.strip()), "")


def _list(value: Any) -> list:
    return value if isinstance(value, list) else []


@lru_cache(maxsize=4)
def _lvis(path: Path) -> dict[str, str]:
    records = _json(path)
    if not isinstance(records, dict):
        return {}
    return {str(uid): str(name) for name, uids in records.items() if isinstance(uids, list) for uid in uids}


@lru_cache(maxsize=64)
def _json(path: Path) -> Any:
    try:
        return json.loads(_bytes(path))
    except (ValueError, RecursionError):
        return None


def _text(path: Path) -> str:
    return _bytes(path).decode("utf-8", "replace")


def _bytes(path: Path) -> bytes:
    """Return a record's content, unpacked; nothing where it cannot be read or is too large."""
    try:
        if not path.is_file():
            return b""
        with gzip.open(path) if path.suffix == ".gz" else path.open("rb") as file:
            content = file.read(_LARGEST_RECORD + 1)
    except (OSError, EOFError, zlib.error):
        return b""
    return content if len(content) <= _LARGEST_RECORD else b""


def _entries(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError:
        return []
