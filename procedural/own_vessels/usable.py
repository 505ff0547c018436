"""Which of a user's vessels can be used: each is read once, and a bad one is passed over and listed."""

from __future__ import annotations

import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...core.passed_over import Finding, Progress, checked_files
from ...core.remembered import Checked
from ..props.mesh_files import root_of
from ..vessels.settings import VesselSettings
from .choice import FileChoice
from .files import VesselFile, vessel_files

#: Number of the check of files; another one forgets what was remembered of them.
CHECK_VERSION = 3


def usable_vessels(
    folder: Path | None, settings: VesselSettings, progress: Progress | None = None
) -> tuple[tuple[VesselFile, ...], tuple[Finding, ...]]:
    """Return the files of vessels that can be used, and what was found about the others.

    Parameters
    ----------
    folder : Path, optional
        A folder or a single file; None has no vessels.
    settings : VesselSettings
        Unit, axis, thickness and smoothing of the files.
    progress : callable, optional
        Is told how far the check is.

    Raises
    ------
    InputError
        Where there are no files, or none can be used.
    """
    checked, findings = checked_vessels(folder, settings, progress)
    return tuple(file for file, _ in checked), findings


def checked_vessels(
    folder: Path | None, settings: VesselSettings, progress: Progress | None = None
) -> tuple[tuple[tuple[VesselFile, Checked], ...], tuple[Finding, ...]]:
    """Return what `usable_vessels` does, with the facts about each file."""
    if folder is None:
        return (), ()

    def check(file: VesselFile) -> Checked:
        return _checked(file, settings)

    good, findings = checked_files(
        vessel_files(folder),
        lambda file: file.path,
        check,
        folder="vessel_dir",
        root=root_of(folder),
        content="vessels",
        # What can be used depends on the settings as well.
        version=zlib.crc32(f"{CHECK_VERSION} {FileChoice.of(settings)}".encode()),
        progress=progress,
    )
    return tuple((_licensed(file, outcome), outcome) for file, outcome in good), findings


def _checked(file: VesselFile, settings: VesselSettings) -> Checked:
    from ..cavities.interior import interior_of  # here, as these load SciPy
    from .shape import read_shape

    shape, notes = read_shape(file, settings)
    inside = interior_of(shape.solid)
    facts = {
        "faces": len(shape.solid.faces),
        "size": np.ptp(shape.solid.bounds, axis=0).tolist(),
        "volumes": [hollow.volume for hollow in inside.hollows],
        "wall": inside.wall,
        "glass": shape.glass.name if shape.glass is not None else None,
        "symmetric": shape.symmetric,
        "licence": notes.facts.get("licence", "unknown"),
    }
    # What is lost of the opaque look of a file does not matter: it is glass.
    return Checked(others=tuple(dict.fromkeys(notes.others)), facts=facts)


def _licensed(file: VesselFile, outcome: Checked) -> VesselFile:
    """Return a file with the licence that it states itself, where its folder states none."""
    if file.place.licence != "unknown":
        return file
    return replace(file, place=replace(file.place, licence=outcome.facts["licence"]))
