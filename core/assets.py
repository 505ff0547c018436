"""External files that a scene uses: pictures, environment maps, meshes."""

from __future__ import annotations

import hashlib
from pathlib import Path

from pydantic import Field

from .errors import InputError, cause_of
from .model import Model

#: First bytes of what Git LFS and git-annex leave in a file's place until it is fetched.
_POINTERS = {b"version https://git-lfs": "git lfs pull", b"/annex/objects/": "git annex get"}


class Asset(Model):
    """An external file, identified by the digest of its content.

    A data set stores it in ``assets/`` beside ``scenes/``, named by its digest, so that it is self-contained.
    """

    path: Path = Field(description="Where the file is (absolute while a scene is drawn; relative in a scene file)")
    sha256: str = Field(pattern="^[0-9a-f]{64}$", description="Digest of the content")
    source: str = Field(description="Name of the file where it came from, without its folder")
    licence: str = Field(default="unknown", description="Licence, if the folder it came from says so")


def asset(path: Path) -> Asset:
    """Return the record of a file with its digest; InputError where it cannot be read."""
    try:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(path, "a readable file", cause_of(error)) from error
    return Asset(path=path.resolve(), sha256=digest, source=path.name)


def checked_path(item: Asset) -> Path:
    """Return the asset's path; InputError where the file is missing or its content has changed."""
    found = asset(item.path).sha256
    if found != item.sha256:
        raise InputError(item.path, f"the file with SHA-256 {item.sha256[:12]}...", f"{found[:12]}...")
    return item.path


def check_content(path: Path, content: bytes) -> None:
    """Raise InputError where a file's first bytes are a pointer to what has to be fetched first."""
    for start, command in _POINTERS.items():
        if content.startswith(start):
            raise InputError(path, "the file itself", f"a pointer to it ({command} fetches it)")
