"""Pictures of a user's folder on the walls and floors of rooms."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from glassware.core.assets import asset
from glassware.core.errors import InputError
from glassware.core.randomness import stream
from glassware.procedural.description.material import PictureTexture
from glassware.procedural.description.surroundings import RoomEnvironment, RoomPicture
from glassware.procedural.surroundings.room_bodies import room_bodies
from glassware.procedural.surroundings.room_pictures import picture_over, usable_room_pictures, with_pictures
from glassware.procedural.surroundings.room_surfaces import room_surfaces
from glassware.procedural.surroundings.rooms import draw_room


def _write(path: Path, pixels: np.ndarray) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), pixels)
    return path


def _halves(left: int, right: int) -> np.ndarray:
    """Return a picture of two halves side by side, twice as wide as high."""
    pixels = np.full((4, 8, 3), left, np.uint8)
    pixels[:, 4:] = right
    return pixels


def _room(folder: Path, **changes: object) -> RoomEnvironment:
    room = draw_room(stream(3, 0, "environment")).model_copy(update=changes)
    files, findings = usable_room_pictures(folder, (0.5, 0.5))
    assert not findings
    found = with_pictures(stream(3, 0, "environment/textures"), room, files)
    assert isinstance(found, RoomEnvironment)
    return found


def test_walls_and_floor_have_pictures_of_their_folders_and_all_else_stays(tmp_path: Path) -> None:
    _write(tmp_path / "walls" / "brick_diff.png", _halves(0, 255))
    _write(tmp_path / "walls" / "brick_rough.png", _halves(9, 9))
    _write(tmp_path / "floors" / "a.png", np.full((4, 4, 3), 255, np.uint8))
    _write(tmp_path / "others" / "b.png", _halves(0, 0))
    plain, room = draw_room(stream(3, 0, "environment")), _room(tmp_path)
    assert room.wall_picture is not None
    assert room.floor_picture is not None
    assert (room.wall_picture.texture.asset.path.name, room.wall_picture.size) == ("brick_diff.png", (0.5, 0.25))
    assert (room.floor_picture.texture.asset.path.name, room.floor_picture.size) == ("a.png", (0.5, 0.5))
    # Light in the room comes back from its walls: they have the mean of their picture.
    assert np.allclose(room.wall_colours[:4], 0.5)
    assert np.allclose(room.wall_colours[5], 1.0)
    unchanged = {"wall_picture": None, "floor_picture": None, "wall_colours": plain.wall_colours}
    assert room.model_copy(update=unchanged) == plain


def test_a_folder_for_floors_alone_leaves_the_walls(tmp_path: Path) -> None:
    _write(tmp_path / "floors" / "a.png", _halves(0, 255))
    room = _room(tmp_path)
    assert room.wall_picture is None
    assert room.wall_colours[:5] == draw_room(stream(3, 0, "environment")).wall_colours[:5]


def test_a_folder_without_walls_and_floors_is_one_line(tmp_path: Path) -> None:
    _write(tmp_path / "a.png", _halves(0, 255))
    with pytest.raises(InputError, match=r"environment\.texture_dir: expected a folder with a subfolder walls or floo"):
        usable_room_pictures(tmp_path, (0.5, 0.5))


def test_a_picture_repeats_at_its_size(tmp_path: Path) -> None:
    path = _write(tmp_path / "a.png", _halves(0, 255))
    picture = RoomPicture(texture=PictureTexture(asset=asset(path)), size=(0.5, 0.25))
    texels = picture_over(picture, np.array([2.0, 1.0]), np.array([200, 100]))
    assert texels.shape == (200, 100, 3)
    # Along the first coordinate a quarter of a metre of each half, four times.
    x = (np.arange(200) + 0.5) / 100
    assert np.array_equal(texels[:, 3, 0] > 0.5, x % 0.5 >= 0.25)
    assert np.array_equal(texels[:, 0], texels[:, 99])


def test_rooms_as_maps_and_in_their_places_show_the_same_walls(tmp_path: Path) -> None:
    _write(tmp_path / "walls" / "a.png", np.full((4, 4, 3), [0, 0, 188], np.uint8))  # red: sRGB 188 is half of white
    room = _room(tmp_path, panels=(), blocks=())
    (body,) = [body for body in room_bodies(room) if body.part == "wall" and body.pixels.shape == (4, 4, 3)]
    assert np.allclose(body.pixels, [0.503, 0.0, 0.0], atol=1e-3)
    surfaces = room_surfaces(room)
    for face in range(4):
        assert surfaces.textures[face][5, 5, 0] > 0.0
        window_free = surfaces.textures[face][2, 2]
        assert window_free[1] == pytest.approx(0.0, abs=1e-6)
