"""The user's cache folder."""

from __future__ import annotations

import os
from pathlib import Path


def cache_folder() -> Path:
    """Return glassware's folder in the user's cache: ``$XDG_CACHE_HOME/glassware``, by default ``~/.cache/glassware``.

    A relative ``XDG_CACHE_HOME`` is ignored (XDG Base Directory Specification 0.8).

    Raises
    ------
    RuntimeError
        Where the user has no home folder.
    """
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (base if base.is_absolute() else Path.home() / ".cache") / "glassware"
