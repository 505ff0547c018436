"""The files of vessels that a user has: a folder of them or a single one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ...core.folders import files_in

#: Formats that are read.
SUFFIXES = (".glb", ".obj", ".ply", ".stl")


@dataclass(frozen=True)
class VesselFile:
    """A file of a vessel.

    Parameters
    ----------
    path : Path
        The file.
    name : str
        Its path below the user's folder, with forward slashes.
    """

    path: Path
    name: str


def vessel_files(place: Path) -> tuple[VesselFile, ...]:
    """Return the files of vessels in a folder and its subfolders, ordered by their paths, or a single one.

    Raises
    ------
    InputError
        Where there are none, or the folder cannot be read.
    """
    if place.is_file() and place.suffix.lower() in SUFFIXES:
        return (VesselFile(place, place.name),)
    found = files_in(place, "vessels", SUFFIXES, below=True)
    return tuple(VesselFile(path, path.relative_to(place).as_posix()) for path in found)
