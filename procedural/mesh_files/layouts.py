"""How folders of known collections are laid out: which of their files are objects, their unit, up axis and category.

A file's place tells: a collection, a part of it, or single objects from several collections may be given. What no
layout claims is plain: every mesh is an object, except collision hulls and further files of the same object.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from .records import bop_symmetries, gso_category, licence_beside, objaverse_record, synset_name

#: What an object's size is known from: the unit of its file [m], "none" where the collection has scaled all objects to
#: one size, and "unknown" where nothing says it.
Unit = float | Literal["none", "unknown"]


@dataclass(frozen=True)
class Place:
    """What a mesh file's place in its folder says about it."""

    layout: str = "plain"
    category: str | None = None  #: None: the file's name stands for it
    unit: Unit = "unknown"
    up: Literal["y", "z"] = "z"
    licence: str = "unknown"
    object: str = ""  #: files of one object have the same; the best one is used
    rank: tuple = ()  #: the smallest is the best
    #: Stated rotations and shifts that leave the object unchanged, in axes and unit of the file.
    symmetries: tuple[tuple[float, ...], ...] = ()
    turns: bool = False  #: whether it is stated to be a solid of revolution about z


@dataclass(frozen=True)
class PlacedFile:
    """A mesh file in a user's folder, and what its place there says.

    Parameters
    ----------
    path : Path
        The file.
    root : Path
        The user's folder; all files that the mesh file refers to must be inside.
    place : Place
        What its place in the folder says, such as its unit and its licence.
    """

    path: Path
    root: Path
    place: Place = field(default_factory=Place)

    @property
    def name(self) -> str:
        """Its path below the root, with forward slashes."""
        return self.path.relative_to(self.root).as_posix()

    @property
    def category(self) -> str:
        """What it is called in labels: its category where its layout states one, else its name."""
        return self.place.category or self.name


@dataclass(frozen=True)
class Listing:
    """The mesh files of a folder."""

    used: tuple[tuple[Path, Place], ...]
    left_out: tuple[tuple[Path, str], ...]  #: further files of objects that are used, and why they are not


_HULL = re.compile(r"(^|[_\-. ])(collision|collider|vhacd|v-hacd|coacd|convex|hull)([_\-. 0-9]|$)", re.IGNORECASE)
_PLAIN_TWIN = re.compile(r"(^|[_\-. ])(nontextured|untextured|notexture)([_\-. ]|$)", re.IGNORECASE)
_SYNSET = re.compile(r"0\d{7}")
_YCB = re.compile(r"(\d{3}(?:-[a-z])?)_([a-z0-9_\-]+)", re.IGNORECASE)
_BOP = re.compile(r"obj_\d{6}")
_OBJAVERSE = re.compile(r"[0-9a-f]{32}")
#: YCB's folders of one object, best first: laser scans with pictures, then fused depth pictures.
_YCB_FOLDERS = ("google_64k", "google_16k", "google_512k", "poisson", "tsdf", "clouds")
#: BOP's folders of models, best first: for rendering, from CAD, reconstructed; simplified ones for evaluation last.
_BOP_FOLDERS = ("models", "models_cad", "models_reconst", "models_fine", "models_eval")
#: Formats of meshes that are not read: files of other programs and of CAD.
UNREAD_SUFFIXES = (".3ds", ".3mf", ".blend", ".c4d", ".dae", ".fbx", ".iges", ".igs", ".lwo", ".ma", ".max", ".mb")
UNREAD_SUFFIXES += (".off", ".step", ".stp", ".usd", ".usda", ".usdc", ".usdz", ".wrl", ".x3d")
#: Formats by how much of a surface they can state, best first.
_FORMATS = (".glb", ".gltf", ".obj", ".ply", ".stl")
#: A millimetre [m].
_MM = 1e-3


def listing(paths: Sequence[Path], root: Path) -> Listing:
    """Return which mesh files of a folder are objects, and what their places say.

    Parameters
    ----------
    paths : sequence of Path
        All mesh files in the folder, in order.
    root : Path
        The folder that the user gave.
    """
    places = {path: place_of(path, root) for path in paths}
    places = {path: _beside_others(path, place, places) for path, place in places.items()}
    best: dict[str, Path] = {}
    for path in paths:
        key = places[path].object
        if key not in best or places[path].rank < places[best[key]].rank:
            best[key] = path
    used, left_out = [], []
    for path in paths:
        chosen = best[places[path].object]
        if path == chosen:
            used.append((path, replace(places[path], licence=_licence(path, places[path], root))))
        else:
            kind = "a collision hull of" if _HULL.search(path.stem) else "the same object as"
            left_out.append((path, f"{kind} {chosen.relative_to(root).as_posix()}"))
    return Listing(tuple(used), tuple(left_out))


def place_of(path: Path, root: Path) -> Place:
    """Return what a file's place says, without its licence."""
    for recognise in _LAYOUTS:
        found = recognise(path, root)
        if found is not None:
            return found
    return _plain(path)


def _shapenet(path: Path, root: Path) -> Place | None:
    """ShapeNetCore.v2: <synset>/<model>/models/model_normalized.obj, y up, all scaled to a diagonal of 1."""
    parts = path.absolute().parts
    if path.stem != "model_normalized" or len(parts) < 4 or not _SYNSET.fullmatch(parts[-4]):
        return None
    licence = "ShapeNet terms of use"
    return Place("shapenet", synset_name(parts[-4], path, root), "none", "y", licence, str(path.parent), (path.suffix,))


def _gso(path: Path, root: Path) -> Place | None:
    """Google Scanned Objects: <object>/meshes/model.obj beside metadata.pbtxt and materials/textures; metres, z up."""
    folder = path.parent.parent
    marks = ("metadata.pbtxt", "model.config", "materials/textures")
    if path.name != "model.obj" or path.parent.name != "meshes" or not any((folder / mark).exists() for mark in marks):
        return None
    return Place("gso", gso_category(folder) or folder.name, 1.0, "z", "CC BY 4.0", str(path))


def _ycb(path: Path, root: Path) -> Place | None:
    """YCB: <number>_<name>/<kind of scan>/textured.obj and others; metres, z up."""
    parts = path.absolute().parts
    if len(parts) < 3 or parts[-2] not in _YCB_FOLDERS or (match := _YCB.fullmatch(parts[-3])) is None:
        return None
    rank = (not path.stem.startswith("textured"), _YCB_FOLDERS.index(parts[-2]), _FORMATS.index(path.suffix.lower()))
    return Place("ycb", match[2], 1.0, "z", "CC BY 4.0", str(path.parent.parent), rank)


def _bop(path: Path, root: Path) -> Place | None:
    """BOP: models/obj_000001.ply with models_info.json; millimetres."""
    if path.suffix.lower() != ".ply" or not _BOP.fullmatch(path.stem):
        return None
    folder = path.parent
    known = folder.name in _BOP_FOLDERS
    rank = (_BOP_FOLDERS.index(folder.name) if known else 0,)
    one = folder.parent if known else folder
    turns, symmetries = bop_symmetries(folder / "models_info.json", int(path.stem[4:]))
    key = str(one / path.stem)
    return Place("bop", path.stem, _MM, "z", "unknown", key, rank, symmetries, turns)


def _objaverse(path: Path, root: Path) -> Place | None:
    """Objaverse 1.0: glbs/<shard>/<uid>.glb, with metadata/<shard>.json.gz; of any size."""
    if path.suffix.lower() != ".glb" or not _OBJAVERSE.fullmatch(path.stem):
        return None
    category, licence = objaverse_record(path, root)
    return Place("objaverse", category, "unknown", "y", licence, str(path))


def _plain(path: Path) -> Place:
    """Return the place of any other file; glTF defines y as up, other formats define nothing."""
    suffix = path.suffix.lower()
    hull, twin = bool(_HULL.search(path.stem)), bool(_PLAIN_TWIN.search(path.stem))
    rank = (hull, twin, _FORMATS.index(suffix), path.name)
    return Place(up="y" if suffix in (".glb", ".gltf") else "z", object=str(path.with_suffix("")), rank=rank)


def _beside_others(path: Path, place: Place, places: dict[Path, Place]) -> Place:
    """Return the place of a hull or an untextured twin as that of the object whose name it has, or stands alone with.

    Where there is no such object, it is one itself.
    """
    if place.layout != "plain" or not (place.rank[0] or place.rank[1]):
        return place
    others = [
        other
        for other, its in places.items()
        if other.parent == path.parent and its.layout == "plain" and not (its.rank[0] or its.rank[1])
    ]
    named = [other for other in others if path.stem.lower().startswith(other.stem.lower())]
    others = named or (others if len({places[other].object for other in others}) == 1 else [])
    return replace(place, object=places[others[0]].object) if others else place


_LAYOUTS: tuple[Callable[[Path, Path], Place | None], ...] = (_shapenet, _gso, _ycb, _bop, _objaverse)


def _licence(path: Path, place: Place, root: Path) -> str:
    return place.licence if place.licence != "unknown" else licence_beside(path.parent, root)
