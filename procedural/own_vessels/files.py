"""The files of vessels that a user has: a folder of them, a collection, or a single one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ...core.folders import files_in
from ..mesh_files.layouts import Listing, PlacedFile, listing, place_of
from ..mesh_files.read import MESH_SUFFIXES
from ..props.mesh_files import root_of


@dataclass(frozen=True)
class VesselFile(PlacedFile):
    """A file of a vessel."""


def vessel_files(folder: Path) -> tuple[VesselFile, ...]:
    """Return the files of vessels in a folder and its subfolders, ordered by their paths, or a single one.

    Each object is used once: hulls and further formats of it are left out, as those of props are.

    Raises
    ------
    InputError
        Where there are none, or the folder cannot be read.
    """
    used = vessel_listing(folder).used  # first, as it refuses files of other kinds
    root = root_of(folder)
    return tuple(VesselFile(path, root, place) for path, place in used)


def vessel_listing(folder: Path) -> Listing:
    """Return the files of vessels, and further files of the same objects; InputError as for `vessel_files`."""
    if folder.is_file() and folder.suffix.lower() in MESH_SUFFIXES:
        return Listing(((folder, place_of(folder, folder.parent)),), ())
    return listing(files_in(folder, "vessels", MESH_SUFFIXES, below=True), folder)
