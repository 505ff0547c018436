"""Pictures inside mesh files, kept as files of their own so that scenes can name them."""

from __future__ import annotations

import hashlib
import os
import tempfile
from pathlib import Path

from ...core.cache_folder import cache_folder
from ...core.errors import InputError, cause_of
from .model import Source

#: First bytes of picture formats, with their suffixes.
_MAGIC = {b"\x89PNG": ".png", b"\xff\xd8\xff": ".jpg", b"RIFF": ".webp", b"BM": ".bmp"}
#: First bytes of formats that are not read.
_UNREAD = {b"\xabKTX 20": "KTX2", b"\xabKTX 11": "KTX", b"DDS ": "DDS", b"GIF8": "GIF"}


def picture_folder() -> Path:
    """Return the folder for pictures that are inside mesh files.

    It is in the user's cache, or in the system's folder of temporary files where that cannot be written.

    Raises
    ------
    InputError
        Where neither can be written.
    """
    user = os.getuid() if hasattr(os, "getuid") else 0
    last = Path(tempfile.gettempdir(), f"glassware-{user}")
    for folder in (_cache(), last):
        if folder is None:
            continue
        try:
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            # A folder of another user, in a place that all can write, is not used.
            if os.access(folder, os.W_OK) and (folder != last or folder.stat().st_uid == user):
                return folder / "pictures"
        except OSError:
            continue
    raise InputError(_cache() or last, "a folder that can be written (set XDG_CACHE_HOME)", "none")


def kept_picture(source: Source, content: bytes, what: str) -> Path:
    """Write a picture to the folder of pictures, atomically, named by its digest; return its path.

    Raises
    ------
    InputError
        Where it is of a format that is not read, or the folder cannot be written.
    """
    suffix = next((suffix for magic, suffix in _MAGIC.items() if content.startswith(magic)), None)
    if suffix is None:
        kind = next((name for magic, name in _UNREAD.items() if content.startswith(magic)), "something else")
        raise InputError(source.path.name, f"{what} as PNG, JPEG or WebP", kind)
    folder = source.pictures
    target = folder / f"{hashlib.sha256(content).hexdigest()}{suffix}"
    try:
        if target.is_file() and target.stat().st_size == len(content):
            return target
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, suffix=suffix, delete=False) as file:
            file.write(content)
        Path(file.name).replace(target)
    except OSError as error:
        raise InputError(folder, "a folder that can be written (set XDG_CACHE_HOME)", cause_of(error)) from error
    return target


def _cache() -> Path | None:
    try:
        return cache_folder()
    except RuntimeError:  # no home
        return None
