"""Lists of scenes as text, in requests and in ``dataset.json``: numbers and half-open ranges, such as 3,7,10:20."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from ...core.errors import InputError

#: Folder names have six digits, and render-scene has the same limit.
LARGEST_SCENE = 999_999
_PART = re.compile(r"(?P<first>[0-9]{1,7})(?::(?P<end>[0-9]{1,7}))?")


def parse_scenes(text: str, where: str = "--scenes") -> list[int]:
    """Return the scenes of a text, in its order, each once.

    Raises
    ------
    InputError
        Where it is not a list of numbers and ranges, a range is empty, or a number is above `LARGEST_SCENE`.
    """
    found: dict[int, None] = {}
    for part in text.split(",") if text else []:
        match = _PART.fullmatch(part.strip())
        if match is None:
            raise InputError(where, "scenes such as 0:2000 or 3,7,10:20", repr(text)[:80])
        first = int(match["first"])
        end = first + 1 if match["end"] is None else int(match["end"])
        if not first < end <= LARGEST_SCENE + 1:
            raise InputError(where, f"ranges that hold a scene, at most {LARGEST_SCENE}", repr(part)[:80])
        found.update(dict.fromkeys(range(first, end)))
    return list(found)


def requested_scenes(scenes: str, count: int | None) -> list[int]:
    """Return the scenes of a request, of ``--scenes`` or of ``--count``.

    A number alone is refused: it names one scene, and most who write it want so many.

    Raises
    ------
    InputError
        Where neither or both are given, or `scenes` is a number alone or no list of scenes.
    """
    if scenes and count is not None:
        raise InputError("--count", "it without --scenes, or --scenes without it", "both")
    if count is not None:
        return parse_scenes(f"0:{count}", "--count")
    if scenes.strip().isdecimal():
        number = int(scenes)
        many = f"--count {number} or --scenes 0:{number} for {number} scenes" if number else "--count 1 for one scene"
        raise InputError("--scenes", f"{many}, {number}:{number + 1} for scene {number} alone", repr(scenes))
    if not scenes:
        raise InputError("--scenes", "scenes such as 0:2000, or --count 2000", "none")
    return parse_scenes(scenes)


def format_scenes(scenes: Iterable[int]) -> str:
    """Return the shortest text of ranges for a set of scenes, ascending."""
    parts: list[list[int]] = []
    for scene in sorted(set(scenes)):
        if parts and parts[-1][1] == scene:
            parts[-1][1] = scene + 1
        else:
            parts.append([scene, scene + 1])
    return ",".join(f"{first}:{end}" if end > first + 1 else f"{first}" for first, end in parts)


def shard(scenes: Sequence[int], text: str) -> list[int]:
    """Return one of n parts of nearly equal length, which together are all scenes.

    Parameters
    ----------
    scenes : sequence of int
        All scenes, in order.
    text : str
        ``i/n``, i from 1 to n.
    """
    match = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", text)
    number, count = (int(match[1]), int(match[2])) if match else (0, 0)
    if not 1 <= number <= count:
        raise InputError("--shard", "i/n with i from 1 to n, such as 1/3", repr(text)[:80])
    return list(scenes[len(scenes) * (number - 1) // count : len(scenes) * number // count])
