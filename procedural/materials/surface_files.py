"""Materials in a user's folder: pictures in colour, each with the maps beside it that belong to the same surface."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from ...core.errors import InputError
from ...core.folders import files_in
from ...core.passed_over import Finding, Progress, checked_files
from ...core.remembered import Checked
from .map_names import AMBIGUOUS, MapName, lettered, map_name
from .picture_files import PICTURE_SUFFIXES, check_picture

#: Pictures of surfaces: those in colour, and maps of floats.
SURFACE_SUFFIXES = (".exr", *PICTURE_SUFFIXES)
#: Range of the side of a picture on a table or prop [m], where no file states it. Table-top photographs show 0.3-1 m.
PICTURE_SIDE = (0.3, 1.0)
#: Width from which a larger picture of the same map is not preferred [1024 px]: textures are reduced to 4096 px.
_ENOUGH = 4
#: Which channel of a packed map holds roughness, and which metalness.
_PACKED: dict[str, tuple[Channel, Channel]] = {
    "arm": ("green", "blue"),
    "rma": ("red", "green"),
    "mra": ("green", "red"),
}
#: Number of the check of files; another one forgets what was remembered.
_CHECK = 1
#: The file of Poly Haven's interface (api.polyhaven.com/info) that has a surface's extent in millimetres.
_INFO, _LONGEST_INFO = "info.json", 1_000_000

Channel = Literal["grey", "red", "green", "blue"]


@dataclass(frozen=True)
class MapFile:
    """A map: roughness or metalness in a channel of a picture, normals, or heights."""

    path: Path
    channel: Channel = "grey"
    inverted: bool = False
    convention: Literal["opengl", "directx"] = "opengl"


@dataclass(frozen=True)
class SurfaceFiles:
    """The pictures of one surface.

    Parameters
    ----------
    colour : Path
        The picture in colour.
    root : Path
        The user's folder.
    base : str
        Name of the material; that of the picture where there are no maps.
    roughness, metalness, normal, height : MapFile, optional
        The maps; heights only where there are no normals.
    side : float, optional
        Side of the surface that the pictures show [m], if a file beside them says so.
    drawn_side : (float, float)
        Range that the side is drawn from otherwise [m].
    """

    colour: Path
    root: Path
    base: str
    roughness: MapFile | None = None
    metalness: MapFile | None = None
    normal: MapFile | None = None
    height: MapFile | None = None
    side: float | None = None
    drawn_side: tuple[float, float] = PICTURE_SIDE

    @property
    def name(self) -> str:
        """The path of the picture in colour below the root, with forward slashes."""
        return self.colour.relative_to(self.root).as_posix()

    @property
    def maps(self) -> tuple[MapFile, ...]:
        """The maps, without the colour."""
        return tuple(one for one in (self.roughness, self.metalness, self.normal, self.height) if one is not None)


def surface_files(folder: Path) -> tuple[tuple[SurfaceFiles, ...], tuple[Finding, ...]]:
    """Return the surfaces under a folder, ordered by the paths of their pictures in colour.

    Files whose names say that they are maps of one material (`map_names`) become one surface. A picture without such a
    name is a surface by itself; a map without a picture in colour is passed over.

    Raises
    ------
    InputError
        If the folder is missing, or has no picture.
    """
    groups: dict[tuple[Path, str], list[tuple[Path, MapName]]] = defaultdict(list)
    for path, name in _named(files_in(folder, "pictures", SURFACE_SUFFIXES, below=True)):
        groups[path.parent, name.base].append((path, name))
    surfaces: list[SurfaceFiles] = []
    findings: list[Finding] = []
    for members in groups.values():
        found, lost = _surfaces_of(folder, members)
        surfaces += found
        findings += lost
    if not surfaces:
        raise InputError(folder, "pictures in colour", f"maps alone, such as {findings[0].path}")
    surfaces.sort(key=lambda item: item.name)
    return tuple(surfaces), tuple(sorted(findings, key=lambda item: item.path))


def _named(paths: Sequence[Path]) -> Iterator[tuple[Path, MapName]]:
    """Yield each file with what its name says among those of its folder."""
    names: dict[Path, dict[str, MapName]] = defaultdict(dict)
    for path in paths:
        names[path.parent][path.stem] = map_name(path.stem)
    known = {parent: lettered(here) for parent, here in names.items()}
    yield from ((path, known[path.parent][path.stem]) for path in paths)


def usable_surfaces(
    folder: Path | None,
    side: tuple[float, float] = PICTURE_SIDE,
    progress: Progress | None = None,
    setting: str = "texture_dir",
) -> tuple[tuple[SurfaceFiles, ...], tuple[Finding, ...]]:
    """Return the surfaces in a folder whose pictures can all be read, and what was found about the other files.

    Parameters
    ----------
    folder : Path, optional
        Searched with its subfolders; None holds nothing.
    side : (float, float)
        Range of the side of what the pictures show [m], where no file states it.
    progress : callable, optional
        Is told how far the check is.
    setting : str
        Name of the setting that names the folder.

    Raises
    ------
    InputError
        If the folder is missing, or no surface in it can be used.
    """
    if folder is None:
        return (), ()
    surfaces, lost = surface_files(folder)
    lost = tuple(item.model_copy(update={"folder": setting}) for item in lost)
    good, findings = checked_files(
        surfaces,
        lambda item: item.colour,
        _check,
        folder=setting,
        root=folder,
        content="pictures",
        version=_CHECK,
        progress=progress,
    )
    return tuple(replace(item, drawn_side=side) for item, _ in good), (*lost, *findings)


def _check(item: SurfaceFiles) -> Checked:
    """Read all pictures of a surface once; a fault of a map is a fault of the surface."""
    others = tuple(dict.fromkeys(one.path for one in item.maps))
    try:
        for path in (item.colour, *others):
            check_picture(path)
    except InputError as error:
        return Checked(refused=str(error), others=others)
    return Checked(others=others)


def _surfaces_of(root: Path, members: Sequence[tuple[Path, MapName]]) -> tuple[list[SurfaceFiles], list[Finding]]:
    """Return the surfaces of files with one name in one folder, and findings about the files that are none."""
    colours = _colours([item for item in members if item[1].kind == "colour"])
    maps = [item for item in members if item[1].kind not in ("colour", "plain", "preview", "unused")]
    if not (colours and maps):
        return _plain(root, members)
    first = SurfaceFiles(colours[0], root, members[0][1].base or colours[0].parent.name)
    first = replace(first, side=_stated_side(first), **_map_files(maps))
    previews = [path for path, name in members if name.kind in ("plain", "preview")]
    findings = [_passed_over(root, path, f"a view of the material {first.base}") for path in previews]
    return [replace(first, colour=colour) for colour in colours], findings


def _plain(root: Path, members: Sequence[tuple[Path, MapName]]) -> tuple[list[SurfaceFiles], list[Finding]]:
    """Return pictures that stand alone as surfaces, and findings about maps without a colour."""
    surfaces, findings = [], []
    # Beside a map that no plain picture is named after, others of its name are maps too.
    maps = any(name.kind not in ("plain", *AMBIGUOUS) for _, name in members)
    for path, name in members:
        words = name.kind in AMBIGUOUS and not maps and (name.base or len(members) == 1)
        if name.kind == "plain" or name.kind == "colour" or words:
            surfaces.append(SurfaceFiles(path, root, path.stem))
        else:
            findings.append(_passed_over(root, path, f"a map ({name.kind}) without a picture in colour of its name"))
    return surfaces, findings


def _passed_over(root: Path, path: Path, found: str) -> Finding:
    reason = f"expected a picture in colour, found {found}"
    return Finding(folder="texture_dir", path=path.relative_to(root).as_posix(), reason=reason)


def _colours(found: list[tuple[Path, MapName]]) -> list[Path]:
    """Return one picture for each variant in colour, in the size that is nearest to what is needed."""
    variants: dict[str, list[tuple[Path, MapName]]] = defaultdict(list)
    for path, name in found:
        # diff_01 and diff_02 are two variants; diff_1k and diff_4k are one.
        variants[name.variant].append((path, name))
    return [_best(variants[key])[0] for key in sorted(variants)]


def _map_files(found: Sequence[tuple[Path, MapName]]) -> dict[str, MapFile | None]:
    """Return the maps of a surface by their fields in `SurfaceFiles`."""
    by_kind = {kind: [item for item in found if item[1].kind == kind] for kind in {name.kind for _, name in found}}
    files: dict[str, MapFile | None] = {}
    if "packed" in by_kind:
        path, name = _best(by_kind["packed"])
        rough, metal = _PACKED[name.detail]
        files |= {"roughness": MapFile(path, rough), "metalness": MapFile(path, metal)}
    if "glossiness" in by_kind:
        files["roughness"] = MapFile(_best(by_kind["glossiness"])[0], inverted=True)
    for kind in ("roughness", "metalness"):
        if kind in by_kind:
            files[kind] = MapFile(_best(by_kind[kind])[0])
    if "normal" in by_kind:
        best = [item for item in by_kind["normal"] if item[1].detail == "opengl"] or by_kind["normal"]
        path, name = _best(best)
        files["normal"] = MapFile(path, convention="directx" if name.detail == "directx" else "opengl")
    elif "height" in by_kind:
        files["height"] = MapFile(_best(by_kind["height"])[0])
    return files


def _best(found: list[tuple[Path, MapName]]) -> tuple[Path, MapName]:
    """Return the file whose size is the largest up to what is needed, or else the smallest; the first of equal ones."""

    def rank(item: tuple[Path, MapName]) -> tuple[bool, int, str]:
        size = item[1].size
        return (size > _ENOUGH, size if size > _ENOUGH else -size, item[0].name)

    return min(found, key=rank)


def _stated_side(item: SurfaceFiles) -> float | None:
    """Return the side of a surface that ``info.json`` beside it or one folder above states [m]."""
    for folder in (item.colour.parent, item.colour.parent.parent):
        path = folder / _INFO
        if not folder.is_relative_to(item.root) or not path.is_file() or path.stat().st_size > _LONGEST_INFO:
            continue
        try:
            stated = json.loads(path.read_text("utf-8")).get("dimensions")
            side = 1e-3 * float(stated[0])
        except (OSError, ValueError, TypeError, AttributeError, IndexError, RecursionError):
            continue
        if 0.01 <= side <= 1000.0:
            return side
    return None
