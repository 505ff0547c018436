"""Tar files of samples, as WebDataset reads them: members of a sample follow each other and share the key."""

from __future__ import annotations

import io
import tarfile
from collections.abc import Iterable
from pathlib import Path

from ...core.atomic_io import atomic_file


def write_tar(path: Path, samples: Iterable[tuple[str, Iterable[tuple[str, bytes]]]]) -> None:
    """Write a shard; it appears whole or not at all, and the same samples give the same bytes.

    Parameters
    ----------
    path : Path
        The file, ``.tar``.
    samples : iterable of (key, members)
        Members are endings with their contents; a key has no dot, because it ends at the first one.
    """
    with atomic_file(path) as partial, tarfile.open(partial, "w", format=tarfile.PAX_FORMAT) as tar:
        for key, members in samples:
            for ending, data in members:
                entry = tarfile.TarInfo(f"{key}.{ending}")
                entry.size = len(data)
                tar.addfile(entry, io.BytesIO(data))
