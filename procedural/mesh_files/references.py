"""Files that mesh files name: found where people's files have them, and only inside the user's folder."""

from __future__ import annotations

import os
from pathlib import Path

from ...core.assets import asset
from ...core.errors import InputError, cause_of
from ...core.user_text import usable_path, usable_text
from ..description.material import PictureTexture
from ..materials.picture_files import read_picture
from .inside import may_read
from .model import Source, check_fetched

#: Folders that hold pictures beside meshes, seen from the file that names them. Google Scanned Objects have
#: ``meshes/`` and ``materials/textures/``; ShapeNetCore has ``models/`` and ``images/``.
_PICTURE_FOLDERS = (
    ".",
    "../materials/textures",
    "../images",
    "../textures",
    "textures",
    "images",
    "materials/textures",
    "maps",
)


def named_file(source: Source, asking: Path, name: str, what: str) -> Path | None:
    """Return the file that another one names; None, with a remark, where it is not inside the user's folder.

    Tried are the name as it stands, then its last part beside the file and in the folders where pictures usually are,
    each also in other capitals. Names may be paths of another computer.

    Parameters
    ----------
    source : Source
        The mesh file.
    asking : Path
        The file with the name: the mesh itself, or its MTL file.
    name : str
        As it stands there.
    what : str
        What is named, for the remark, such as "the picture of material 'oak'".
    """
    text = name.strip().strip("\"'").replace("\\", "/")
    try:
        usable_text(text)
        usable_path(asking.parent / text)
    except ValueError:
        _say_missing(source, asking, name, what, "a name that no file can have")
        return None
    last = text.rsplit("/", 1)[-1]
    tried = [asking.parent / text, *(asking.parent / folder / last for folder in _PICTURE_FOLDERS)]
    outside = False
    for candidate in tried:
        path = Path(os.path.normpath(candidate.absolute()))
        found = _in_any_case(path)
        if found is None:
            continue
        if may_read(found, source.root):
            source.notes.others.append(found)
            return found
        outside = True
    source.notes.others.append(Path(os.path.normpath((asking.parent / last).absolute())))
    _say_missing(source, asking, name, what, "only one outside the folder" if outside else "none")
    return None


def picture(source: Source, path: Path | None, what: str) -> PictureTexture | None:
    """Return a picture as a texture; None, with a remark, where it cannot be read."""
    if path is None:
        return None
    try:
        with path.open("rb") as file:
            check_fetched(path, file.read(64))
        if source.check_pictures:
            read_picture(path)
        return PictureTexture(asset=asset(path))
    except OSError as error:
        source.notes.say(f"{what}: {InputError(path, 'a readable picture', cause_of(error))}")
    except InputError as error:
        source.notes.say(f"{what}: {error}")
    return None


def _say_missing(source: Source, asking: Path, name: str, what: str, found: str) -> None:
    shown = ascii(name[:80])
    source.notes.say(f"{asking.name}: expected {what} ({shown}) inside {source.root.name}, found {found}")


def _in_any_case(path: Path) -> Path | None:
    """Return a file by its name, or by its name in other capitals."""
    try:
        if path.is_file():
            return path
        twins = [item for item in path.parent.iterdir() if item.name.lower() == path.name.lower() and item.is_file()]
    except (OSError, RuntimeError, ValueError):
        return None
    return min(twins, default=None)
