"""Which of a user's vessels can be used: each is read once, and a bad one is passed over and listed."""

from __future__ import annotations

import zlib
from pathlib import Path

from ...core.passed_over import Finding, Progress, checked_files
from ...core.remembered import Checked
from ..vessels.settings import VesselSettings
from .files import VesselFile, vessel_files

#: Number of the check of files; another one forgets what was remembered of them.
CHECK_VERSION = 1


def usable_vessels(
    place: Path | None, settings: VesselSettings, progress: Progress | None = None
) -> tuple[tuple[VesselFile, ...], tuple[Finding, ...]]:
    """Return the files of vessels that can be used, and what was found about the others.

    Parameters
    ----------
    place : Path, optional
        A folder or a single file; None has no vessels.
    settings : VesselSettings
        Unit, axis and thickness of the files.
    progress : callable, optional
        Is told how far the check is.

    Raises
    ------
    InputError
        Where there are no files, or none can be used.
    """
    if place is None:
        return (), ()
    choice = f"{CHECK_VERSION} {settings.unit} {settings.up} {settings.shell}"

    def check(file: VesselFile) -> Checked:
        from .shape import own_shape  # here, as it loads SciPy

        own_shape(file, settings)
        return Checked()

    good, findings = checked_files(
        vessel_files(place),
        lambda file: file.path,
        check,
        folder="vessel_dir",
        root=place if place.is_dir() else place.parent,
        content="vessels",
        # What can be used depends on the settings as well.
        version=zlib.crc32(choice.encode()),
        progress=progress,
    )
    return tuple(file for file, _ in good), findings
