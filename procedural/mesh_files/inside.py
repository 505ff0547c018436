"""Which files may be read: those in the user's folder, and what links in it lead to."""

from __future__ import annotations

import os
from pathlib import Path


def may_read(path: Path, root: Path) -> bool:
    """Return whether a file may be used: it stands in the user's folder, and a link in it leads to the user's own.

    A link is followed where it ends in the folder, or at a file of the user who runs the program.
    """
    given = Path(os.path.normpath(root.absolute()))
    try:
        target = path.resolve()
        inside = path.is_relative_to(given) or target.is_relative_to(root.resolve())
        if not inside or not target.is_file():
            return False
        return target.is_relative_to(root.resolve()) or target.stat().st_uid == os.getuid()
    except (OSError, RuntimeError):  # links in a loop
        return False
