"""Meshes from a user's folder: which there are, what each is, and one read as the surface of a prop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ...core.errors import InputError
from ...core.folders import files_in
from ...core.mesh import Mesh, check_closed
from ...core.passed_over import Finding, Progress, checked_files
from ...core.remembered import Checked
from ...core.user_text import counted
from ..mesh_files.embedded import picture_folder
from ..mesh_files.layouts import Listing, Place, PlacedFile, listing, place_of
from ..mesh_files.model import FilePart, GlassLook, Look, Notes, Source
from ..mesh_files.read import MESH_SUFFIXES, read_parts
from .pieces import Piece, joined_pieces, sewn, without_ground

#: Number of the check; what was remembered of another one is forgotten.
CHECK_VERSION = 8
#: A file of unknown unit whose longest side is in this range is taken to be in metres and keeps its size [m]: objects
#: on tables. Any other such file gets a drawn size.
TRUE_SIZES = (0.01, 0.5)
#: Least and greatest longest side of an object whose size is known [m]. Smaller ones are below the depth resolution of
#: cameras at a metre; larger ones do not fit on a table among others.
KNOWN_SIZES = (0.005, 0.6)
#: Least ratio of the shortest to the longest side [1]. A prop thinner than a thousandth (0.1 mm at 10 cm) cannot be
#: distinguished from the table under it.
LEAST_THICKNESS = 1e-3
#: Lengths of units [m].
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}


@dataclass(frozen=True)
class MeshChoice:
    """Which meshes of a folder are used, and what is stated about them."""

    include: tuple[str, ...] = ()  #: patterns of names or categories; empty is all
    exclude: tuple[str, ...] = ()
    unit: Literal["auto", "m", "cm", "mm", "inch"] = "auto"
    up: Literal["auto", "y", "z"] = "auto"


@dataclass(frozen=True)
class MeshFile(PlacedFile):
    """A mesh file of a prop.

    Parameters
    ----------
    pictures : Path
        Folder to which pictures inside the file are written.
    """

    pictures: Path = field(kw_only=True)


@dataclass(frozen=True)
class FileMesh:
    """A mesh from a file with what the file says of its surface.

    Parameters
    ----------
    mesh : Mesh
        Centred on its bounding box, z up, with normals; with `uv` if the file has them.
    pieces : tuple of Piece
        Numbers of faces that follow each other, and the look of each.
    glass : GlassLook, optional
        Of a file that is transparent all over.
    centre : (float, float, float)
        Centre of the bounding box, axes and unit of the file.
    metres_per_unit : float
        Scale that was applied.
    longest : float
        Longest side in the unit of the file.
    """

    mesh: Mesh
    pieces: tuple[Piece, ...]
    glass: GlassLook | None
    centre: tuple[float, float, float]
    metres_per_unit: float
    longest: float


def mesh_listing(folder: Path, choice: MeshChoice | None = None) -> Listing:
    """Return the meshes under a folder, in the order of their paths, and further files of the same objects.

    Parameters
    ----------
    folder : Path
        Searched with its subfolders for `MESH_SUFFIXES`; or one mesh file.
    choice : MeshChoice, optional
        Which of them are used, and what is stated about them.

    Raises
    ------
    InputError
        Where there are none.
    """
    choice = choice or MeshChoice()
    if folder.is_file() and folder.suffix.lower() in MESH_SUFFIXES:
        found = Listing(((folder, place_of(folder, folder.parent)),), ())
    else:
        found = listing(files_in(folder, "meshes", MESH_SUFFIXES, below=True), folder)
    root = root_of(folder)
    kept = tuple((path, _stated(place, choice)) for path, place in found.used if _is_chosen(path, place, root, choice))
    if not kept:
        patterns = " ".join((*choice.include, *choice.exclude))
        raise InputError(folder, "meshes that props.include and props.exclude choose", f"none with {patterns}")
    return Listing(kept, found.left_out)


def mesh_files(folder: Path, pictures: Path | None = None, choice: MeshChoice | None = None) -> tuple[MeshFile, ...]:
    """Return the meshes under a folder, ordered by their relative paths; InputError if there are none.

    Parameters
    ----------
    folder : Path
        Searched with its subfolders for `MESH_SUFFIXES`; or one mesh file.
    pictures : Path, optional
        Folder for pictures inside mesh files; by default in the user's cache.
    choice : MeshChoice, optional
        Which of them are used, and what is stated about them.
    """
    used = mesh_listing(folder, choice).used  # first, as it refuses files of other kinds
    kept, root = pictures or picture_folder(), root_of(folder)
    return tuple(MeshFile(path, root, place, pictures=kept) for path, place in used)


def root_of(folder: Path) -> Path:
    """Return the folder inside which files are read: for a single file, that of its object."""
    if not folder.is_file():
        return folder
    nested = place_of(folder, folder.parent).layout in ("gso", "shapenet")
    return folder.parent.parent if nested else folder.parent


def usable_meshes(
    folder: Path | None,
    progress: Progress | None = None,
    pictures: Path | None = None,
    choice: MeshChoice | None = None,
) -> tuple[tuple[MeshFile, ...], tuple[Finding, ...]]:
    """Return the meshes under a folder that can be used, each read once, and what was found about the files.

    Parameters
    ----------
    folder : Path, optional
        None has no meshes.
    progress : callable, optional
        Is told how far the check is.
    pictures, choice : optional
        As for `mesh_files`.

    Raises
    ------
    InputError
        Where the folder cannot be used, or no mesh in it can.
    """
    checked, findings = checked_meshes(folder, progress, pictures, choice)
    return tuple(file for file, _ in checked), findings


def checked_meshes(
    folder: Path | None,
    progress: Progress | None = None,
    pictures: Path | None = None,
    choice: MeshChoice | None = None,
) -> tuple[tuple[tuple[MeshFile, Checked], ...], tuple[Finding, ...]]:
    """Return what `usable_meshes` does, with the facts about each file."""
    if folder is None:
        return (), ()
    good, findings = checked_files(
        mesh_files(folder, pictures, choice),
        lambda file: file.path,
        _checked,
        folder="mesh_dir",
        root=root_of(folder),
        content="meshes",
        version=CHECK_VERSION,
        progress=progress,
    )
    kept, refused = [], []
    for file, outcome in good:
        fault = _size_fault(file, float(outcome.facts["longest"]))
        if fault is None:
            licence = file.place.licence if file.place.licence != "unknown" else outcome.facts["licence"]
            kept.append((replace(file, place=replace(file.place, licence=licence)), outcome))
        else:
            refused.append(Finding(folder="mesh_dir", path=file.name, reason=fault))
    if not kept:
        raise InputError(folder, "meshes that can be used", f"none in {counted(len(good), 'file')}; {refused[0]}")
    drawn = [file for file, outcome in kept if metres_per_unit(file, float(outcome.facts["longest"])) is None]
    if drawn:
        more = f" (as {counted(len(drawn) - 1, 'more file')})" if len(drawn) > 1 else ""
        reason = f"no known size{more}; one is drawn, the same in all scenes (props.unit states the unit)"
        refused.append(Finding(folder="mesh_dir", path=drawn[0].name, reason=reason, used=True))
    return tuple(kept), (*findings, *refused)


def metres_per_unit(file: MeshFile, longest: float) -> float | None:
    """Return the unit of a file [m]; None where nothing says it and its size is not that of an object on a table.

    Parameters
    ----------
    file : MeshFile
        The file.
    longest : float
        Its longest side, in its unit.
    """
    unit = file.place.unit
    if unit == "unknown":
        return 1.0 if TRUE_SIZES[0] <= longest <= TRUE_SIZES[1] else None
    return None if isinstance(unit, str) else unit


def read_mesh(file: MeshFile, name: str, longest: float, notes: Notes | None = None) -> FileMesh:
    """Return a file's surface, all its parts as one mesh.

    The surface may be open and may have several parts. An axis y that points up is turned to z. Usable normals of the
    file are kept; otherwise they are computed, with creases at `normals.CREASE`.

    Parameters
    ----------
    file : MeshFile
        The file.
    name : str
        Name of the mesh.
    longest : float
        Longest side of a file whose unit is not known (`metres_per_unit`) [m].
    notes : Notes, optional
        Takes remarks; then pictures are decoded, so that a broken one is found.

    Raises
    ------
    InputError
        If the file cannot be read, has no faces, has coordinates that are not finite, or is flat.
    """
    source = Source(file.path, file.root, file.pictures, notes or Notes(), notes is not None)
    stored = read_parts(source)
    parts, glass = _without_glass(source, stored)
    left_out = " in what is not transparent" if len(parts) < len(stored) else ""
    if file.place.up == "y":
        parts = [part.moved(Z_UP) for part in parts]
    parts = without_ground(source.notes, parts)
    used = np.concatenate([part.vertices[np.unique(part.faces)] for part in parts])
    low, high = used.min(0), used.max(0)
    with np.errstate(over="ignore"):
        extent = high - low
    if not np.isfinite(extent).all() or extent.min() <= LEAST_THICKNESS * extent.max():
        found = " x ".join(f"{side:g}" for side in extent)
        raise InputError(file.path, "a body with three extents", f"{found}{left_out}")
    side = float(extent.max())
    scale = metres_per_unit(file, side) or longest / side
    centre = low + 0.5 * extent
    placed = [replace(part, vertices=(part.vertices - centre) * scale) for part in parts]
    mesh, pieces = joined_pieces(file.path, name, placed if glass is None else sewn(placed))
    if file.place.up == "y":
        centre = Z_UP[:3, :3].T @ centre
    x, y, z = centre.tolist()
    return FileMesh(mesh, pieces, glass, (x, y, z), scale, side)


def box_mapped(mesh: Mesh) -> Mesh:
    """Return a mesh with box-mapped texture coordinates, by the dominant axis of each face, over its longest side."""
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normal).argmax(1)
    pairs, index = np.unique(np.stack([mesh.faces.reshape(-1), np.repeat(axis, 3)], 1), axis=0, return_inverse=True)
    vertices = mesh.vertices[pairs[:, 0]]
    # The two axes beside the dominant one, z as v on upright sides.
    first, second = np.array([1, 0, 0])[pairs[:, 1]], np.array([2, 2, 1])[pairs[:, 1]]
    rows = np.arange(len(pairs))
    uv = np.stack([vertices[rows, first], vertices[rows, second]], 1) / np.ptp(mesh.bounds, axis=0).max()
    normals, colours = (None if x is None else x[pairs[:, 0]] for x in (mesh.normals, mesh.colours))
    return Mesh(mesh.name, vertices, index.reshape(-1, 3), normals, uv, colours)


#: From y up to z up: a quarter turn about x.
Z_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


def _without_glass(source: Source, parts: list[FilePart]) -> tuple[list[FilePart], GlassLook | None]:
    """Return the opaque parts; where there are none, all parts and the look of their glass."""
    opaque = [part for part in parts if part.look.glass is None]
    if not opaque:
        return parts, parts[0].look.glass
    if len(opaque) < len(parts):
        names = sorted({repr(part.look.name) for part in parts if part.look.glass is not None})
        source.notes.say(f"its transparent parts ({', '.join(names[:3])}) are left out: a prop is opaque or all glass")
    return opaque, None


def _checked(file: MeshFile) -> Checked:
    notes = Notes()
    found = read_mesh(file, "check", 1.0, notes)
    if found.glass is not None:
        _check_glass(file, found.mesh)
    facts: dict[str, Any] = {
        "longest": found.longest,
        "faces": len(found.mesh.faces),
        "materials": [piece.look.name for piece in found.pieces][:50],
        "kinds": [_kind(piece.look) for piece in found.pieces][:50],
        "licence": notes.facts.get("licence", "unknown"),
    }
    return Checked(remarks=tuple(notes.remarks), others=tuple(dict.fromkeys(notes.others)), facts=facts)


def _check_glass(file: MeshFile, mesh: Mesh) -> None:
    try:
        check_closed(str(file.path), mesh)
    except InputError as error:
        found = str(error).rpartition("found ")[2]
        raise InputError(file.path, "a closed surface, as its material is glass", found) from error


def _kind(look: Look) -> str:
    if look.glass is not None:
        return "glass"
    kind = "no material" if look.texture is None else look.texture.kind
    return kind if look.glow is None else f"{kind} that shines"


def _size_fault(file: MeshFile, longest: float) -> str | None:
    unit = metres_per_unit(file, longest)
    if unit is None or KNOWN_SIZES[0] <= unit * longest <= KNOWN_SIZES[1]:
        return None
    least, most = KNOWN_SIZES
    return (
        f"expected an object of {1e3 * least:g} mm to {most:g} m, found one of {unit * longest:.4g} m "
        "(props.unit states another unit, props.exclude leaves it out)"
    )


def _is_chosen(path: Path, place: Place, root: Path, choice: MeshChoice) -> bool:
    name = path.relative_to(root).as_posix().lower() if path.is_relative_to(root) else path.name.lower()
    texts = (name, (place.category or name).lower())

    def matches(patterns: Sequence[str]) -> bool:
        return any(fnmatchcase(text, pattern.lower()) for pattern in patterns for text in texts)

    return (not choice.include or matches(choice.include)) and not matches(choice.exclude)


def _stated(place: Place, choice: MeshChoice) -> Place:
    unit = place.unit if choice.unit == "auto" else UNITS[choice.unit]
    return replace(place, unit=unit, up=place.up if choice.up == "auto" else choice.up)
