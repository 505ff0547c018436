"""``manifest.json``: every asset file that the scenes of a data set may use, with its digest.

Scenes draw an index into the list of files, which means another file once the list changes. So the whole list is
recorded, and not only the files that some scene has used. Each file is hashed once: a cache in the user's cache folder
has the digest by path, size and modification time.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Literal

from pydantic import Field

from ...core.atomic_io import write_atomically
from ...core.cache_folder import cache_folder
from ...core.errors import InputError, cause_of
from ...core.folders import files_in
from ...core.json_file import check_schema, json_text, parsed, read_json
from ...core.model import Model
from ...procedural.materials.picture_files import PICTURE_SUFFIXES
from ...procedural.materials.surface_files import SURFACE_SUFFIXES
from ...procedural.own_vessels.files import vessel_files
from ...procedural.props.mesh_files import MESH_SUFFIXES, root_of
from ...procedural.scene.asset_places import check_asset_places
from ...procedural.scene.settings import SceneSettings
from ...procedural.surroundings.hdri import SUFFIXES
from ..format.checksums import Sha256, file_digest
from ..format.layout import MANIFEST

MANIFEST_SCHEMA = "glassware/manifest/1"

Folder = Literal[
    "hdri_dir",
    "mesh_dir",
    "texture_dir",
    "table.texture_dir",
    "environment.texture_dir",
    "vessel_dir",
    "cameras.poses",
    "vessels.media",
    "sensors.depth",
    "sensors.polarisation",
    "sensors.sensitivities",
]
_SINGLE_FILES = ("cameras.poses", "vessels.media", "sensors.depth", "sensors.polarisation", "sensors.sensitivities")
#: Suffixes of meshes and of what they or their layouts refer to.
_MESH_FILES = (*MESH_SUFFIXES, ".bin", ".gz", ".json", ".mtl", ".pbtxt", *PICTURE_SUFFIXES)
#: Identifies an unchanged file without reading it: size [bytes] and modification time [ns].
Stamp = tuple[int, int]


class ManifestFile(Model):
    """A file in one of the asset folders, or the file of camera poses or of own media."""

    folder: Folder = Field(description="The setting that names its folder, or the file itself")
    path: str = Field(description="Below the folder, with forward slashes")
    size: int = Field(ge=0, description="[bytes]")
    sha256: Sha256


class Manifest(Model):
    """All asset files, by folder and path."""

    schema_version: Literal["glassware/manifest/1"] = MANIFEST_SCHEMA
    files: tuple[ManifestFile, ...] = ()


def asset_paths(settings: SceneSettings) -> dict[tuple[Folder, str], Path]:
    """Return the files in the asset folders, those that meshes may refer to, and that of the poses.

    Raises InputError for an unusable folder.
    """
    check_asset_places(settings)
    folders: tuple[tuple[Folder, Path | None, tuple[str, ...], bool], ...] = (
        ("hdri_dir", settings.environment.hdri_dir, SUFFIXES, True),
        ("mesh_dir", settings.mesh_dir and root_of(settings.mesh_dir), _MESH_FILES, True),
        ("texture_dir", settings.texture_dir, SURFACE_SUFFIXES, True),
        ("table.texture_dir", settings.table.texture_dir, SURFACE_SUFFIXES, True),
        ("environment.texture_dir", settings.environment.texture_dir, SURFACE_SUFFIXES, True),
    )
    found: dict[tuple[Folder, str], Path] = {
        (name, path.relative_to(folder).as_posix()): path
        for name, folder, suffixes, below in folders
        if folder is not None
        for path in files_in(folder, "asset files", suffixes, below)
        if path.exists()  # a link to nothing is passed over
    }
    if settings.vessel_dir is not None:
        found |= {("vessel_dir", file.name): file.path for file in vessel_files(settings.vessel_dir)}
    for name, path in _single_files(settings).items():
        if not path.is_file():
            raise InputError(path, f"the file of {name}", "none")
        found[name, path.name] = path
    return found


def scan(settings: SceneSettings) -> Manifest:
    """Return the manifest of the asset folders as they are now; files are read where the cache has no digest."""
    cache, files = _DigestCache(), []
    for (folder, name), path in sorted(asset_paths(settings).items()):
        size, digest = path.stat().st_size, cache.digest(path)
        files.append(ManifestFile(folder=folder, path=name, size=size, sha256=digest))
    cache.save()
    return Manifest(files=tuple(files))


def check_manifest(kept: Manifest, found: Manifest, settings: SceneSettings) -> None:
    """Raise InputError that names the first file that is missing, changed or new against a data set's manifest."""
    before, now = ({(item.folder, item.path): item for item in manifest.files} for manifest in (kept, found))
    for key in sorted(before.keys() | now.keys()):
        path = _asset_path(settings, *key)
        if key not in now:
            raise InputError(path, f"the asset that {MANIFEST} names", "no such file")
        if key not in before:
            raise InputError(path, f"only assets that {MANIFEST} names", "a new file")
        if before[key] != now[key]:
            expected, actual = (f"SHA-256 {item.sha256[:12]}..., {item.size} bytes" for item in (before[key], now[key]))
            raise InputError(path, f"the asset as {MANIFEST} has it ({expected})", f"another content ({actual})")


def stamps(settings: SceneSettings) -> dict[Path, Stamp]:
    """Return size and modification time of each asset file, to notice changes without reading the files."""
    statuses = ((path, path.stat()) for path in asset_paths(settings).values())
    return {path: (status.st_size, status.st_mtime_ns) for path, status in statuses}


def check_unchanged(before: dict[Path, Stamp]) -> None:
    """Raise InputError that names the first file that was removed or changed since `stamps`."""
    for path, stamp in before.items():
        try:
            status = path.stat()
        except OSError as error:
            raise InputError(path, "the asset that the worker found when it started", cause_of(error)) from error
        if (status.st_size, status.st_mtime_ns) != stamp:
            raise InputError(path, "the asset as it was when the worker started", "a changed file")


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


def _single_files(settings: SceneSettings) -> dict[Folder, Path]:
    """Return the files that settings name one by one, by the names of the settings."""
    sensors = settings.sensors
    # Others are devices by their names.
    named = (sensors.depth, sensors.polarisation, sensors.sensitivities)
    devices = [one if isinstance(one, Path) else None for one in named]
    files = dict(zip(_SINGLE_FILES, (settings.cameras.poses, settings.vessels.media, *devices), strict=True))
    return {name: path for name, path in files.items() if path is not None}


def _asset_path(settings: SceneSettings, folder: str, name: str) -> Path:
    single = {str(setting): path for setting, path in _single_files(settings).items()}
    if folder in _SINGLE_FILES:
        return single.get(folder, Path(name)).with_name(name)
    if folder == "vessel_dir" and settings.vessel_dir is not None and settings.vessel_dir.is_file():
        return settings.vessel_dir
    places = {
        "hdri_dir": settings.environment.hdri_dir,
        "table.texture_dir": settings.table.texture_dir,
        "environment.texture_dir": settings.environment.texture_dir,
    }
    return Path((places[folder] if folder in places else getattr(settings, folder)) or "", name)


class _DigestCache:
    """Digests by path, size and modification time, kept between runs; only for this run where no folder can be used."""

    def __init__(self) -> None:
        self._known: dict[str, list] = {}
        self._changed = False
        try:
            content = json.loads(_cache_file().read_text("utf-8"))
            self._known = content if isinstance(content, dict) else {}
        except (OSError, ValueError, RuntimeError):  # missing, damaged, or no home: files are hashed again
            pass

    def digest(self, path: Path) -> str:
        """Return the SHA-256 of a file; InputError where it cannot be read."""
        try:
            status = path.stat()
            key, stamp = str(path.resolve()), [status.st_size, status.st_mtime_ns]
            known = self._known.get(key)
            if isinstance(known, list) and known[:2] == stamp and isinstance(known[-1], str):
                return known[-1]
            digest = file_digest(path)
        except OSError as error:
            raise InputError(path, "a readable asset", cause_of(error)) from error
        self._known[key], self._changed = [*stamp, digest], True
        return digest

    def save(self) -> None:
        """Write the cache where it has changed."""
        if not self._changed:
            return
        try:
            path = _cache_file()
            path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile("w", encoding="utf-8", dir=path.parent, delete=False) as file:
                json.dump(self._known, file, sort_keys=True)
            Path(file.name).replace(path)
        except (OSError, RuntimeError):  # files are hashed again next time
            return


def _cache_file() -> Path:
    return cache_folder() / "digests.json"
