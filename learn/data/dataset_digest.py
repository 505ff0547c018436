"""Identity of a data set: name, seed, and a digest of all its files."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

from pydantic import Field

from ...core.errors import InputError, cause_of
from ...core.model import Model
from ...dataset.format import layout
from ...dataset.reader import Dataset


class DatasetRecord(Model):
    """The data set that a network was trained on."""

    name: str
    seed: int
    sha256: str = Field(description="Of its head, its splits and the checksums of every scene (`dataset_digest`)")


def dataset_record(root: Path, also: Sequence[Path] = ()) -> DatasetRecord:
    """Return the record of the data set in a folder; with others, its digest is that of all their digests."""
    head = Dataset.open(root).head
    digest = dataset_digest(root)
    if also:
        digest = hashlib.sha256("".join([digest, *map(dataset_digest, also)]).encode()).hexdigest()
    return DatasetRecord(name=head.name, seed=head.seed, sha256=digest)


def dataset_digest(root: Path) -> str:
    """Return the SHA-256 of a data set's head, splits, scene numbers and file checksums."""
    digest = hashlib.sha256(_content(root / layout.DATASET))
    if (root / layout.SPLITS).is_file():
        digest.update((root / layout.SPLITS).read_bytes())
    for scene_id in layout.scene_ids(root):
        digest.update(layout.scene_name(scene_id).encode())
        digest.update(_content(layout.scene_folder(root, scene_id) / layout.CHECKSUMS))
    return digest.hexdigest()


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, "a readable file of a data set", cause_of(error)) from error
