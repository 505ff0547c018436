"""Named random streams: draws from one stream do not affect the others."""

from __future__ import annotations

import hashlib

import numpy as np

#: Largest seed of a data set [1]: it fits the signed 64-bit integers of its index.
MOST_SEED = 2**63 - 1


def stream(seed: int, scene_id: int, name: str) -> np.random.Generator:
    """Return the generator of one named stream of one scene.

    Parameters
    ----------
    seed : int
        Seed of the data set, >= 0.
    scene_id : int
        Number of the scene in the data set, >= 0.
    name : str
        Name of the stream, such as ``"vessels"``, or ``"vessels/3"`` for the third vessel alone.

    Returns
    -------
    numpy.random.Generator
        PCG64 generator that depends on the three arguments only.
    """
    return np.random.Generator(np.random.PCG64(_sequence(seed, scene_id, name)))


def stream_seed(seed: int, scene_id: int, name: str) -> int:
    """Return a 32-bit seed for code that takes an integer, from the same named streams."""
    return int(_sequence(seed, scene_id, name).generate_state(1, np.uint32)[0])


def _sequence(seed: int, scene_id: int, name: str) -> np.random.SeedSequence:
    # Python's own hash() differs between processes; a digest of the name does not.
    key = int.from_bytes(hashlib.sha256(name.encode()).digest()[:4], "little")
    return np.random.SeedSequence(seed, spawn_key=(scene_id, key))
