"""Cryptomatte: the objects of each pixel with their coverage, as compositing programs read them.

Friedman and Jones, "Fully Automatic ID Mattes with Support for Motion Blur and Transparency" (SIGGRAPH 2015 talks), and
their "Cryptomatte Specification" 1.2: an object's id is the hash of its name, its bits read as a float; each pixel
lists its ids by descending coverage, two in the four channels of a level; attributes of the file hold the names.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...core.errors import InputError
from .exr import channel, exr_attributes, read_exr, write_exr

#: Name of the layer, as most renderers call the mattes of objects.
LAYER = "CryptoObject"
#: Ids of a pixel by level [1], and the fewest levels, which programs expect: six ids.
_IN_LEVEL, _LEVELS = 2, 3
_MASK = 0xFFFFFFFF


def murmur3_32(data: bytes) -> int:
    """Return MurmurHash3_x86_32 of some bytes, with seed 0 (Appleby 2011, public domain)."""
    state = 0
    for start in range(0, len(data), 4):
        block = data[start : start + 4]
        word = int.from_bytes(block, "little") * 0xCC9E2D51 & _MASK
        word = (word << 15 | word >> 17) * 0x1B873593 & _MASK
        state ^= word
        if len(block) == 4:
            state = (state << 13 | state >> 19) & _MASK
            state = (state * 5 + 0xE6546B64) & _MASK
    state ^= len(data)
    state = (state ^ state >> 16) * 0x85EBCA6B & _MASK
    state = (state ^ state >> 13) * 0xC2B2AE35 & _MASK
    return state ^ state >> 16


def name_hash(name: str) -> int:
    """Return the id of a name as the bits of a float that is neither infinite, nor none, nor denormal."""
    found = murmur3_32(name.encode("utf-8"))
    exponent = found >> 23 & 0xFF
    return found ^ 1 << 23 if exponent in (0, 0xFF) else found


def write_cryptomatte(path: Path, coverage: Mapping[str, np.ndarray], shape: tuple[int, int]) -> None:
    """Write a file.

    Parameters
    ----------
    path : Path
        The file, ``.exr``.
    coverage : mapping of str to (H, W) float32
        Fraction of each pixel by the object's name; at most 1 in all.
    shape : (int, int)
        Height and width of the picture [px].
    """
    names = sorted(coverage)
    bits = np.array([name_hash(name) for name in names], np.uint32)
    if len(set(bits.tolist())) < len(names):
        raise ValueError(f"{path}: two of the names {names} have the same hash")
    stack = np.stack([coverage[name] for name in names]) if names else np.zeros((0, *shape), np.float32)
    most = int((stack > 0.0).sum(axis=0).max(initial=0))
    levels = max(_LEVELS, -(-most // _IN_LEVEL))
    order = np.argsort(-stack, axis=0, kind="stable")[: levels * _IN_LEVEL]
    ranked = np.take_along_axis(stack, order, axis=0)
    ids = np.where(ranked > 0.0, bits.view(np.float32)[order] if names else 0.0, 0.0).astype(np.float32)
    channels = {}
    for rank in range(levels * _IN_LEVEL):
        level, place = divmod(rank, _IN_LEVEL)
        for letter, values in zip("RG" if place == 0 else "BA", (ids, ranked), strict=True):
            channel_values = values[rank] if rank < len(values) else np.zeros(shape, np.float32)
            channels[f"{LAYER}{level:02d}.{letter}"] = np.asarray(channel_values, np.float32)
    manifest = {name: f"{number:08x}" for name, number in zip(names, bits.tolist(), strict=True)}
    key = f"cryptomatte/{murmur3_32(LAYER.encode()):08x}"[: len("cryptomatte/") + 7]
    facts = {"name": LAYER, "hash": "MurmurHash3_32", "conversion": "uint32_to_float32"}
    facts["manifest"] = json.dumps(manifest, separators=(",", ":"))
    write_exr(path, channels, {f"{key}/{name}": text for name, text in facts.items()})


def read_cryptomatte(path: Path) -> dict[str, np.ndarray]:
    """Return the coverage by name, each (H, W) float32, of a file of `write_cryptomatte`."""
    channels, manifest = read_exr(path), _manifest(path)
    shape = channel(channels, f"{LAYER}00.R", path).shape
    found = {name: np.zeros(shape, np.float32) for name in manifest}
    for level in range(len(channels) // 4):
        for letters in ("RG", "BA"):
            ids, part = (channel(channels, f"{LAYER}{level:02d}.{letter}", path) for letter in letters)
            bits = np.ascontiguousarray(ids, np.float32).view(np.uint32)
            for name, number in manifest.items() if part.any() else ():
                mine = bits == np.uint32(int(number, 16))
                found[name][mine] += part[mine]
    return found


def _manifest(path: Path) -> dict[str, str]:
    attributes = exr_attributes(path)
    text = next((value for key, value in attributes.items() if key.endswith("/manifest")), None)
    try:
        manifest = json.loads(text or "")
        good = isinstance(manifest, dict) and all(int(number, 16) >= 0 for number in manifest.values())
    except (ValueError, TypeError) as error:
        raise InputError(path, "a Cryptomatte manifest of names and hashes", str(text)[:80]) from error
    if not good:
        raise InputError(path, "a Cryptomatte manifest of names and hashes", str(text)[:80])
    return manifest
