"""What the surfaces of a room look like: paint, boards, tiles, wood and pictures, as tiles of reflectance."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from ...core.model import Reflectance
from ..description.material import ProceduralTexture
from ..description.surroundings import RoomEnvironment, RoomPicture
from ..materials.noise import fractal_gradient_noise, tile_grid
from ..materials.textures import bake
from .room_pictures import picture_of

# Texels along the side of a tile [1]: boards and tiles, 2 mm on a tile of a metre; paint, whose blotches are larger.
_FINE, _COARSE = 512, 128
# Side of a tile of paint, of wood on furniture and of a floor [m].
_PAINT_TILE, _WOOD_TILE, _FLOOR_TILE = 1.6, 1.1, 2.0
# Largest relative deviation of paint from its mean.
_PAINT_SPREAD = 0.05
# Light and dark wood over the mean colour: a board of that mean has these in its rings.
_WOOD_LIGHT, _WOOD_DARK = 1.25, 0.5
# Factor of the joint between boards, and its width [m]; relative spread of the boards' shades and of the grain in them.
_JOINT_SHADE, _JOINT, _BOARD_SPREAD, _GRAIN_SPREAD = 0.35, 0.003, 0.2, 0.25
# Boards in a row on the tile of a floor, along their length: joints stand a metre apart.
_BOARD_ROWS = 2
# Width of the grout between floor tiles [m], its factor, and relative spread of the tiles' shades.
_GROUT, _GROUT_SHADE, _TILE_SPREAD = 0.004, 0.55, 0.06
_FLOOR = 5


@dataclass(frozen=True)
class Finish:
    """A tile of reflectance; equal ones are the same picture."""

    kind: str  #: "plain", "paint", "wood", "boards", "tiles", "picture", or "file" of a user
    colour: Reflectance
    seed: int = 0
    tile: float = 1.0  #: side of the tile [m]; of a picture 1, as its texture coordinates are repeats
    width: float = 0.0  #: of boards or floor tiles [m]
    file: RoomPicture | None = None

    @property
    def sides(self) -> np.ndarray:
        """Width and height of the tile, (2,) [m]."""
        return np.array((self.tile, self.tile) if self.file is None else self.file.size)

    def pixels(self) -> np.ndarray:
        """Return the tile, (h, w, 3) float32, linear Rec.709; rows along v, columns along u."""
        return _pixels(self)


def shell_finish(room: RoomEnvironment, face: int) -> Finish:
    """Return the finish of a wall, the ceiling or the floor."""
    colour = room.wall_colours[face]
    picture = picture_of(room, face)
    if picture is not None:
        return Finish("file", colour, file=picture)
    if face == _FLOOR and room.board_width > 0.0:
        boards = max(1, round(_FLOOR_TILE / room.board_width))
        return Finish("boards", colour, room.seed, _FLOOR_TILE, _FLOOR_TILE / boards)
    if face == _FLOOR and room.floor_tile > 0.0:
        tiles = max(1, round(_FLOOR_TILE / room.floor_tile))
        return Finish("tiles", colour, room.seed, _FLOOR_TILE, _FLOOR_TILE / tiles)
    return Finish("paint", colour, room.seed, _PAINT_TILE)


def solid_finish(room: RoomEnvironment, colour: Reflectance, finish: str) -> Finish:
    """Return the finish of furniture and small bodies."""
    if finish == "wood":
        return Finish("wood", colour, room.seed, _WOOD_TILE)
    return Finish("plain", colour)


def panel_finish(room: RoomEnvironment, number: int, picture: bool) -> Finish:
    """Return the finish of a door, a frame, or the picture in it."""
    colour = room.panels[number].colour
    return Finish("picture", colour, room.seed + number, 1.0) if picture else Finish("plain", colour)


def palette(colours: list[Reflectance]) -> np.ndarray:
    """Return plain colours as one picture, (1, n, 3) float32: colour k at u = (k + 1/2) / n."""
    return np.array(colours, np.float32)[None]


@lru_cache(maxsize=64)
def _pixels(finish: Finish) -> np.ndarray:
    make = {
        "plain": _plain,
        "paint": _paint,
        "wood": _wood,
        "boards": _boards,
        "tiles": _tiles,
        "picture": _picture,
        "file": _file,
    }
    pixels = np.clip(make[finish.kind](finish), 0.0, 0.95).astype(np.float32)
    pixels.setflags(write=False)
    return pixels


def _file(finish: Finish) -> np.ndarray:
    assert finish.file is not None
    return bake(finish.file.texture)


def _plain(finish: Finish) -> np.ndarray:
    return np.array(finish.colour, np.float32).reshape(1, 1, 3)


def _rng(finish: Finish) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(finish.seed))


def _paint(finish: Finish) -> np.ndarray:
    u, v = tile_grid(_COARSE)
    factor = 1.0 + _PAINT_SPREAD * fractal_gradient_noise(u, v, (5, 5), 4, _rng(finish))
    return _plain(finish) * factor[..., None]


def _wood(finish: Finish) -> np.ndarray:
    colour = np.array(finish.colour)
    light, dark = (tuple(np.clip(k * colour, 0.0, 0.9).tolist()) for k in (_WOOD_LIGHT, _WOOD_DARK))
    return bake(ProceduralTexture(kind="wood", colours=(light, dark), seed=finish.seed, resolution=_FINE))


def _boards(finish: Finish) -> np.ndarray:
    """Return planks along u, two in a row, each of another shade and grain, with dark joints."""
    rng, (u, v) = _rng(finish), tile_grid(2 * _FINE)
    count = round(finish.tile / finish.width)
    row = np.minimum((v * count).astype(int), count - 1)
    along = (u + rng.uniform(size=count)[row]) % 1.0
    column = (along * _BOARD_ROWS).astype(int)
    shade = 1.0 + _BOARD_SPREAD * rng.uniform(-1.0, 1.0, (count, _BOARD_ROWS))[row, column]
    # Periods are whole numbers, so that the tile has no seam; each board is shifted to another piece of the noise.
    shift = rng.uniform(size=(2, count, _BOARD_ROWS))[:, row, column]
    grain = fractal_gradient_noise((u + shift[0]) % 1.0, (v + shift[1]) % 1.0, (4, 80), 3, rng)
    edge = np.minimum(*(np.abs((x + 0.5) % 1.0 - 0.5) * d for x, d in ((v * count, finish.width), (along * 2, 1.0))))
    joint = np.clip(edge / (0.5 * _JOINT), 0.0, 1.0)
    factor = shade * (1.0 + _GRAIN_SPREAD * grain) * (_JOINT_SHADE + (1.0 - _JOINT_SHADE) * joint)
    return _plain(finish) * factor[..., None]


def _tiles(finish: Finish) -> np.ndarray:
    rng, (u, v) = _rng(finish), tile_grid(2 * _FINE)
    count = round(finish.tile / finish.width)
    row, column = ((x * count).astype(int) % count for x in (v, u))
    shade = 1.0 + _TILE_SPREAD * rng.uniform(-1.0, 1.0, (count, count))[row, column]
    shade += _TILE_SPREAD * fractal_gradient_noise(u, v, (16, 16), 3, rng)
    edge = np.minimum(*(np.abs((x * count + 0.5) % 1.0 - 0.5) * finish.width for x in (u, v)))
    face = np.clip(edge / _GROUT, 0.0, 1.0)
    return _plain(finish) * (shade * (_GROUT_SHADE + (1.0 - _GROUT_SHADE) * face))[..., None]


def _picture(finish: Finish) -> np.ndarray:
    """Return a print: a horizon under a sky, or fields of colour, inside a pale mount."""
    rng, (u, v) = _rng(finish), tile_grid(_COARSE)
    colour = np.array(finish.colour)
    colours = np.clip(colour * rng.uniform(0.3, 1.7, (4, 3)), 0.02, 0.85)
    level = 0.35 + 0.3 * rng.random() + 0.12 * fractal_gradient_noise(u, v, (2, 1), 3, rng)
    below = v < level
    depth = np.where(below, v / level, (v - level) / (1.0 - level))[..., None]
    image = np.where(below[..., None], colours[0] + depth * (colours[1] - colours[0]), 0.0)
    image += np.where(below[..., None], 0.0, colours[2] + depth * (colours[3] - colours[2]))
    image *= (1.0 + 0.35 * fractal_gradient_noise(u, v, (6, 9), 4, rng))[..., None]
    if rng.random() < 0.6:
        mount = (np.abs(u - 0.5) > 0.38) | (np.abs(v - 0.5) > 0.36)
        image = np.where(mount[..., None], 0.75, image)
    return cv2.GaussianBlur(image.astype(np.float32), (0, 0), 0.5)
