"""The folder of an export: what it holds is recorded, so that an export goes on where it was stopped."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Literal

from pydantic import Field

from ...core.atomic_io import is_leftover, write_atomically
from ...core.errors import InputError
from ...core.json_file import check_schema, json_text, parsed, read_json
from ...core.model import Model
from ..format.dataset_file import DatasetFile
from .job import ExportOptions, Job

EXPORT_SCHEMA = "glassware/export/1"
#: The record of an export in its folder.
RECORD = "glassware-export.json"


class ExportRecord(Model):
    """From what an export is made, and how far it is."""

    schema_version: Literal["glassware/export/1"] = EXPORT_SCHEMA
    format: str
    options: ExportOptions
    name: str = Field(description="Of the data set")
    seed: int = Field(description="Of the data set")
    config: str = Field(description="SHA-256 of the data set's settings")
    finished: tuple[int, ...] | None = Field(default=None, description="Scenes of a finished export; null before")


def new_record(job: Job, format_name: str) -> ExportRecord:
    """Return the record of an export that begins."""
    head = job.dataset.head
    return ExportRecord(format=format_name, options=job.options, name=head.name, seed=head.seed, config=_digest(head))


def check_target(job: Job, record: ExportRecord) -> ExportRecord | None:
    """Return the record that an output folder has; None where it is absent or empty.

    Raises
    ------
    InputError
        Where the folder holds something else, or another export, or lies in the data set.
    """
    out, root = job.out.resolve(), job.dataset.root.resolve()
    if out == root or root in out.parents:
        raise InputError("--out", "a folder outside of the data set", job.out)
    if not job.out.exists():
        return None
    if not job.out.is_dir():
        raise InputError(job.out, "a folder to write to", "a file")
    names = {entry.name for entry in job.out.iterdir() if not is_leftover(entry.name)}
    if not names:
        return None
    if RECORD not in names:
        raise InputError(job.out, "an empty folder or an earlier export", f"something else ({min(names)}, ...)")
    found = read_record(job.out)
    _check_same(job.out, found, record)
    return found


def read_record(out: Path) -> ExportRecord:
    """Read the record of an export; InputError where it is missing or damaged."""
    path = out / RECORD
    data = read_json(path)
    check_schema(path, data, EXPORT_SCHEMA)
    return parsed(ExportRecord, data, path)


def write_record(out: Path, record: ExportRecord) -> None:
    """Write the record of an export."""
    write_atomically(out / RECORD, json_text(record.model_dump(mode="json")).encode())


def _check_same(out: Path, found: ExportRecord, wanted: ExportRecord) -> None:
    pairs = {"format": (wanted.format, found.format)}
    pairs |= {
        f"option {name.replace('_', '-')}": (getattr(wanted.options, name), getattr(found.options, name))
        for name in ExportOptions.model_fields
    }
    pairs |= {f"data set's {name}": (getattr(wanted, name), getattr(found, name)) for name in ("name", "seed")}
    pairs["data set's settings"] = (wanted.config[:12], found.config[:12])
    for name, (expected, value) in pairs.items():
        if expected != value:
            raise InputError(f"{out}: {name}", f"{expected}, or another --out", f"an export with {value}")


def _digest(head: DatasetFile) -> str:
    return hashlib.sha256(json_text(head.config).encode()).hexdigest()
