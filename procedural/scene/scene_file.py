"""Scenes on disk: ``scene.json``, its meshes, and the external files that it uses.

::

    <data set>/assets/<sha16>-<name>         environment maps and pictures, named by their content
    <data set>/scenes/000007/scene.json
    <data set>/scenes/000007/meshes/*.ply

Names in a scene file are checked before they are used as paths: meshes are named by a plain word, and assets lie in one
of two folders, inside the data set, with the digest that the scene states.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from ...core.arguments import as_path, check_type
from ...core.assets import Asset, checked_path
from ...core.errors import InputError
from ...core.json_file import check_schema, json_text, parsed, read_json
from ...core.mesh import Mesh
from ...core.mesh_file import read_mesh, write_mesh
from ...core.model import Model
from ..description.scene import SCENE_SCHEMA, Scene
from .validate import check_scene

MESHES_FOLDER = "meshes"
ASSETS_FOLDER = "assets"
_MESH_NAME = re.compile(r"[A-Za-z0-9_-]+")
#: Where an asset of a scene file may lie: beside the scene (a scene saved alone), or beside ``scenes/``.
_ASSET_PATH = re.compile(rf"(?:\.\./\.\./)?{ASSETS_FOLDER}/[0-9a-f]{{16}}-[A-Za-z0-9._-]+")
#: Longest tail of a file's own name that is kept in its name in the data set [characters].
_KEPT_NAME = 80

V = TypeVar("V")


def save_scene(scene: Scene, path: Path | str, assets_dir: Path | None = None) -> None:
    """Write a scene, its meshes and the assets it uses.

    Parameters
    ----------
    scene : Scene
        The scene; its assets are absolute paths of files with the stated digest.
    path : Path or str
        The JSON file to write; meshes go to ``meshes/`` beside it.
    assets_dir : Path, optional
        Where assets go: ``assets/`` beside the scene file (the default) or beside its grandparent, which is the data
        set's folder. An existing file is kept.

    Raises
    ------
    InputError
        Where an asset is missing or has changed since the scene was drawn, or the scene contradicts itself
        (`validate.check_scene`).
    """
    check_type("save_scene: scene", scene, Scene, "a Scene")
    path = as_path("save_scene: path", path)
    check_scene(scene)
    save_checked_scene(scene, path, assets_dir)


def save_checked_scene(scene: Scene, path: Path, assets_dir: Path | None = None) -> None:
    """Do what `save_scene` does with a scene that was checked before, as that of a renderer was.

    The check of a scene of ten objects takes half a second.
    """
    assets_dir = path.parent / ASSETS_FOLDER if assets_dir is None else assets_dir
    meshes: dict[str, Mesh] = {}
    stored = _with_assets(scene, lambda item: _store_asset(item, assets_dir, path))
    data = stored.model_dump(mode="json", context={"write_mesh": lambda mesh: _collected(mesh, meshes)})
    folder = path.parent / MESHES_FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    for name, mesh in meshes.items():
        write_mesh(mesh, folder / f"{name}.ply")
    path.write_text(json_text(data), encoding="utf-8")


def load_scene(path: Path | str) -> Scene:
    """Read a scene that `save_scene` wrote; assets come back as absolute paths, their content checked.

    Raises
    ------
    InputError
        For a damaged or unknown file, a missing mesh, an asset that is missing, changed or outside the data set, or
        a scene that cannot exist (`validate.check_scene`).
    """
    path = as_path("load_scene: path", path)
    data = read_json(path)
    check_schema(path, data, SCENE_SCHEMA)
    folder = path.parent / MESHES_FOLDER
    scene = parsed(Scene, data, path, {"read_mesh": lambda name: _read_named(name, folder)})
    found = _with_assets(scene, lambda item: _found_asset(item, path))
    try:
        check_scene(found)
    except InputError as error:
        error.args = (f"{path}: {error}",)
        raise
    return found


def scene_digest(scene: Scene) -> str:
    """Return the SHA-256 of all that a scene is: its description, its meshes, and the content of its assets."""
    bare = _with_assets(scene, lambda item: item.model_copy(update={"path": Path(item.sha256)}))
    data = bare.model_dump(mode="json", context={"write_mesh": _mesh_digest})
    return hashlib.sha256(json_text(data).encode()).hexdigest()


def _mesh_digest(mesh: Mesh) -> str:
    digest = hashlib.sha256(mesh.name.encode())
    for array in (mesh.vertices, mesh.faces, mesh.normals, mesh.uv):
        digest.update(b"none" if array is None else array.tobytes())
    if mesh.colours is not None:
        digest.update(mesh.colours.tobytes())
    return digest.hexdigest()


def assets_of(scene: Scene) -> tuple[Asset, ...]:
    """Return every asset that a scene uses, each content once, in the order of their digests."""
    found: dict[str, Asset] = {}
    _with_assets(scene, lambda item: found.setdefault(item.sha256, item))
    return tuple(found[digest] for digest in sorted(found))


def stored_name(item: Asset) -> str:
    """Return the name of an asset's file in a data set: start of the digest, and its own name in plain characters."""
    name = re.sub(r"[^A-Za-z0-9._-]", "_", item.source)[-_KEPT_NAME:]
    return f"{item.sha256[:16]}-{name}"


def _collected(mesh: Mesh, meshes: dict[str, Mesh]) -> str:
    if not _MESH_NAME.fullmatch(mesh.name):
        raise ValueError(f"mesh name: expected letters, digits, - and _, got {mesh.name!r}")
    if meshes.setdefault(mesh.name, mesh) is not mesh:
        raise ValueError(f"mesh name {mesh.name!r}: expected it once in a scene, got it twice")
    return mesh.name


def _read_named(name: object, folder: Path) -> Mesh:
    if not isinstance(name, str) or not _MESH_NAME.fullmatch(name):
        raise InputError(f"{folder}: mesh name", "letters, digits, - and _", repr(name)[:80])
    return read_mesh(folder / f"{name}.ply", name)


def _with_assets(value: V, change: Callable[[Asset], Asset]) -> V:
    """Return a description with each asset in it changed."""
    if isinstance(value, Asset):
        return change(value)  # pyright: ignore[reportReturnType]
    if isinstance(value, tuple):
        return tuple(_with_assets(item, change) for item in value)  # pyright: ignore[reportReturnType]
    if isinstance(value, Model):
        fields = {name: getattr(value, name) for name in type(value).model_fields}
        changed = {name: _with_assets(item, change) for name, item in fields.items()}
        return value.model_copy(update={name: item for name, item in changed.items() if item is not fields[name]})
    return value


def _store_asset(item: Asset, assets_dir: Path, path: Path) -> Asset:
    source = checked_path(item)
    target = assets_dir / stored_name(item)
    if not (target.is_file() and _digest(target) == item.sha256):
        assets_dir.mkdir(parents=True, exist_ok=True)
        # Beside and renamed, so that another process never reads half a file.
        partial = assets_dir / f".{target.name}.partial-{os.getpid()}"
        shutil.copyfile(source, partial)
        partial.replace(target)
    relative = Path(os.path.relpath(target.absolute(), path.parent.absolute()))
    if not _ASSET_PATH.fullmatch(relative.as_posix()):
        raise ValueError(f"assets_dir: expected ./assets or ../../assets from {path.parent}, got {assets_dir}")
    return item.model_copy(update={"path": relative})


def _found_asset(item: Asset, path: Path) -> Asset:
    name = item.path.as_posix()
    where = f"{path}: asset {item.source}"
    if not _ASSET_PATH.fullmatch(name):
        raise InputError(where, f"a path such as ../../{ASSETS_FOLDER}/0123456789abcdef-name", repr(name)[:80])
    folder = path.parent.resolve()
    root = folder.parent.parent if name.startswith("..") else folder
    target = (folder / item.path).resolve()
    if not target.is_relative_to(root):
        raise InputError(where, f"a file inside {root}", f"a link to {target}")
    found = item.model_copy(update={"path": target})
    checked_path(found)
    return found


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
