"""``manifest.json``: every file that a build draws from, pinned by its content.

A drawn index into a list of files means another file once the list changes, so the whole list is pinned, not only the
files that some scene has used. Content is hashed once: a cache in the user's cache folder knows the digest of each file
by its path, size and time of change.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Literal

from pydantic import Field

from ...core.atomic_io import write_atomically
from ...core.errors import InputError
from ...core.folders import files_in
from ...core.json_file import check_schema, json_text, parsed, read_json
from ...core.model import Model
from ...procedural.materials.picture_files import PICTURE_SUFFIXES
from ...procedural.props.mesh_files import MESH_SUFFIXES
from ...procedural.scene.settings import SceneSettings
from ...procedural.surroundings.hdri import SUFFIXES
from ..format.checksums import Sha256, file_digest
from ..format.layout import MANIFEST

MANIFEST_SCHEMA = "glassware/manifest/1"

Folder = Literal["hdri_dir", "mesh_dir", "texture_dir"]
#: What identifies an unchanged file without reading it: size [bytes] and time of change [ns].
Stamp = tuple[int, int]


class ManifestFile(Model):
    """A file of one of the folders."""

    folder: Folder
    path: str = Field(description="Below the folder, with forward slashes")
    size: int = Field(ge=0, description="[bytes]")
    sha256: Sha256


class Manifest(Model):
    """All files that scenes may be drawn from, by folder and path."""

    schema_version: Literal["glassware/manifest/1"] = MANIFEST_SCHEMA
    files: tuple[ManifestFile, ...] = ()


def found_files(settings: SceneSettings) -> dict[tuple[Folder, str], Path]:
    """Return the files in the settings' folders, with what meshes may refer to; InputError for a useless folder."""
    folders: tuple[tuple[Folder, Path | None, tuple[str, ...], bool], ...] = (
        ("hdri_dir", settings.environment.hdri_dir, SUFFIXES, False),
        ("mesh_dir", settings.mesh_dir, (*MESH_SUFFIXES, ".mtl", *PICTURE_SUFFIXES), True),
        ("texture_dir", settings.texture_dir, PICTURE_SUFFIXES, True),
    )
    return {
        (name, path.relative_to(folder).as_posix()): path
        for name, folder, suffixes, below in folders
        if folder is not None
        for path in files_in(folder, "files to draw from", suffixes, below)
    }


def scan(settings: SceneSettings) -> Manifest:
    """Return the manifest of the settings' folders as they are; files are read where the cache does not know them."""
    cache, files = _Digests(), []
    for (folder, name), path in sorted(found_files(settings).items()):
        size, digest = path.stat().st_size, cache.of(path)
        files.append(ManifestFile(folder=folder, path=name, size=size, sha256=digest))
    cache.save()
    return Manifest(files=tuple(files))


def check_same(kept: Manifest, found: Manifest, settings: SceneSettings) -> None:
    """Raise InputError that names the first file that is missing, changed or new against a data set's manifest."""
    was, now = ({(item.folder, item.path): item for item in manifest.files} for manifest in (kept, found))
    for key in sorted(was.keys() | now.keys()):
        path = _place(settings, *key)
        if key not in now:
            raise InputError(path, f"the asset that {MANIFEST} names", "no such file")
        if key not in was:
            raise InputError(path, f"only assets that {MANIFEST} names", "a new file")
        if was[key] != now[key]:
            told, seen = (f"SHA-256 {item.sha256[:12]}..., {item.size} bytes" for item in (was[key], now[key]))
            raise InputError(path, f"the asset as {MANIFEST} has it ({told})", f"another content ({seen})")


def stamps(settings: SceneSettings) -> dict[Path, Stamp]:
    """Return what tells that the files of the folders are unchanged, without reading them."""
    return dict(_stamped(found_files(settings).values()))


def check_unchanged(before: dict[Path, Stamp]) -> None:
    """Raise InputError that names the first file that is gone or was changed since `stamps`."""
    for path, stamp in before.items():
        try:
            status = path.stat()
        except OSError as error:
            raise InputError(path, "the asset that was there when the worker began", error.strerror) from error
        if (status.st_size, status.st_mtime_ns) != stamp:
            raise InputError(path, "the asset as it was when the worker began", "a changed file")


def read_manifest(root: Path) -> Manifest | None:
    """Return the manifest of a data set; None where it has none."""
    path = root / MANIFEST
    if not path.exists():
        return None
    data = read_json(path)
    check_schema(path, data, MANIFEST_SCHEMA)
    return parsed(Manifest, data, path)


def write_manifest(root: Path, manifest: Manifest) -> None:
    """Write ``manifest.json``."""
    write_atomically(root / MANIFEST, json_text(manifest.model_dump(mode="json")).encode())


def _place(settings: SceneSettings, folder: str, name: str) -> Path:
    holder = settings.environment if folder == "hdri_dir" else settings
    return Path(getattr(holder, folder) or "", name)


def _stamped(paths: Iterable[Path]) -> Iterator[tuple[Path, Stamp]]:
    for path in paths:
        status = path.stat()
        yield path, (status.st_size, status.st_mtime_ns)


class _Digests:
    """Digests by path, size and time of change, kept between runs; without a cache folder for this run only."""

    def __init__(self) -> None:
        self._known: dict[str, list] = {}
        self._fresh = False
        try:
            content = json.loads(_cache_file().read_text("utf-8"))
            self._known = content if isinstance(content, dict) else {}
        except (OSError, ValueError, RuntimeError):  # it only saves the reading: missing, damaged, or no home
            pass

    def of(self, path: Path) -> str:
        """Return the SHA-256 of a file; InputError where it cannot be read."""
        try:
            status = path.stat()
            key, stamp = str(path.resolve()), [status.st_size, status.st_mtime_ns]
            known = self._known.get(key)
            if isinstance(known, list) and known[:2] == stamp and isinstance(known[-1], str):
                return known[-1]
            digest = file_digest(path)
        except OSError as error:
            raise InputError(path, "a readable asset", error.strerror) from error
        self._known[key], self._fresh = [*stamp, digest], True
        return digest

    def save(self) -> None:
        """Keep what was found, if anything is new."""
        if not self._fresh:
            return
        try:
            path = _cache_file()
            path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile("w", encoding="utf-8", dir=path.parent, delete=False) as file:
                json.dump(self._known, file, sort_keys=True)
            Path(file.name).replace(path)
        except (OSError, RuntimeError):  # files are read again next time, and nothing else
            return


def _cache_file() -> Path:
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (base if base.is_absolute() else Path.home() / ".cache") / "glassware" / "digests.json"
