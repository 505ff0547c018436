"""Pictures of a user's folder on the walls and floors of rooms.

A room's surfaces send out stored light, the same in all directions, so of a material its picture in colour is used:
roughness, metalness and normals would show in reflections alone, which these surfaces do not have.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from ...core.assets import asset
from ...core.errors import InputError
from ...core.passed_over import Finding, Progress
from ..description.material import PictureTexture
from ..description.surroundings import Environment, RoomEnvironment, RoomPicture
from ..materials.surface_files import SurfaceFiles, usable_surfaces
from ..materials.textures import bake

#: Subfolders of the user's folder, and the faces of a room (+x -x +y -y ceiling floor) that they are for.
WALLS, FLOORS = "walls", "floors"
_WALL_FACES, _FLOOR = (0, 1, 2, 3), 5


def usable_room_pictures(
    folder: Path | None, side: tuple[float, float], progress: Progress | None = None
) -> tuple[tuple[SurfaceFiles, ...], tuple[Finding, ...]]:
    """Return the materials for rooms in a folder (`usable_surfaces`), and what was found about the other files.

    Raises
    ------
    InputError
        Where the folder has neither of the subfolders `WALLS` and `FLOORS`, or nothing in it can be used.
    """
    if folder is not None and not any((folder / name).is_dir() for name in (WALLS, FLOORS)):
        raise InputError("environment.texture_dir", f"a folder with a subfolder {WALLS} or {FLOORS}", str(folder))
    surfaces, findings = usable_surfaces(folder, side, progress, "environment.texture_dir")
    return tuple(item for item in surfaces if _place(item) in (WALLS, FLOORS)), findings


def _place(item: SurfaceFiles) -> str:
    return item.name.split("/", 1)[0]


def with_pictures(rng: np.random.Generator, environment: Environment, files: Sequence[SurfaceFiles]) -> Environment:
    """Return a room with a drawn picture on its walls and one on its floor; other surroundings stay as they are.

    The colours of these faces become the means of their pictures, so that the light in the room is that of its walls.

    Parameters
    ----------
    rng : numpy.random.Generator
        The stream ``"environment/textures"``.
    environment : Environment
        The surroundings.
    files : sequence of SurfaceFiles
        Materials in the folders `WALLS` and `FLOORS`; where one of them is empty, its faces stay as they are.
    """
    if not isinstance(environment, RoomEnvironment) or not files:
        return environment
    colours, changes = list(environment.wall_colours), {}
    for field, place, faces in (("wall_picture", WALLS, _WALL_FACES), ("floor_picture", FLOORS, (_FLOOR,))):
        chosen = [item for item in files if _place(item) == place]
        number, drawn = int(rng.integers(max(1, len(chosen)))), rng.random()
        if not chosen:
            continue
        item = chosen[number]
        low, high = item.drawn_side
        width = item.side or low + (high - low) * drawn
        texture = PictureTexture(asset=asset(item.colour))
        pixels = bake(texture)
        changes[field] = RoomPicture(texture=texture, size=(width, width * pixels.shape[0] / pixels.shape[1]))
        red, green, blue = pixels.mean((0, 1), dtype=np.float64).tolist()
        for face in faces:
            colours[face] = (red, green, blue)
    return environment.model_copy(update={**changes, "wall_colours": tuple(colours)})


def picture_of(room: RoomEnvironment, face: int) -> RoomPicture | None:
    """Return the picture on a face of a room (+x -x +y -y ceiling floor); None where there is none."""
    return room.floor_picture if face == _FLOOR else room.wall_picture if face in _WALL_FACES else None


def picture_over(picture: RoomPicture, size: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Return a face's reflectance in texels.

    Parameters
    ----------
    picture : RoomPicture
        What repeats on it, from its corner on: along its first coordinate, and upwards or along its second.
    size : (2,) float
        Of the face [m].
    shape : (2,) int
        Texels along both coordinates.

    Returns
    -------
    (rows, columns, 3) float32
        Rows along the first coordinate.
    """
    pixels = bake(picture.texture)
    across, up = (np.maximum(1, np.round(np.array(picture.size) / size * shape))).astype(int)
    # One repeat at the size of its texels, each the mean of what it covers.
    tile = cv2.resize(np.ascontiguousarray(pixels.swapaxes(0, 1)), (int(up), int(across)), interpolation=cv2.INTER_AREA)
    rows, columns = (
        np.floor((np.arange(n) + 0.5) / n * extent / side % 1.0 * count).astype(int)
        for n, extent, side, count in zip(shape, size, picture.size, (across, up), strict=True)
    )
    return tile[np.minimum(rows, across - 1)][:, np.minimum(columns, up - 1)]
