"""Rooms in their places: their light against closed forms, their disparity, their shadows, and how they are sampled."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.procedural.description.surroundings import FIRST_ROOM_ID, ROOM_IDS, Panel, RoomEnvironment, Window
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives import bodies, scenes
from glassware.procedural.surroundings.metering import polygon_form_factor
from glassware.render._mitsuba import dr, mi
from glassware.render.labels.geometry import trace_geometry
from glassware.render.pictures.picture import denoise_image, trace_picture
from glassware.render.scene.emitters import emitted, sample_emitter, unoccluded
from glassware.render.scene.loaded_scene import LoadedScene, load
from glassware.render.scene.room_emitter import radiance_towards

SIZE, EYE = (4.0, 3.0, 2.5), (1.7, 1.6, 0.74)
LAMP = Window(kind="lamp", wall="ceiling", centre=(1.2, 1.0), size=(0.6, 0.4), radiance=(3.0, 3.0, 3.0))
WINDOW = Window(wall="+x", centre=(1.5, 1.5), size=(1.2, 1.0), radiance=(5.0, 5.0, 5.0))
PRINT = Panel(wall="-x", centre=(1.5, 0.9), size=(0.8, 0.6), colour=(0.05, 0.05, 0.05))


def _room(reflectance: float, *windows: Window, panels: tuple[Panel, ...] = ()) -> RoomEnvironment:
    return RoomEnvironment(
        at_infinity=False,
        size=SIZE,
        eye=EYE,
        wall_colours=((reflectance, reflectance, reflectance),) * 6,
        windows=windows,
        panels=panels,
        seed=1,
        rotation=0.3,
    )


def _loaded(room: RoomEnvironment, *glass, table: float = 0.02, **changes) -> LoadedScene:
    board = scenes.board((table, table, 0.02), scenes.matte((0.0, 0.0, 0.0)))
    camera = scenes.camera((1.0, 0.1, 0.4), width=96, height=72)
    return load(scenes.scene(glass, (camera,), table=board, environment=room, seed=3), **changes)


def _in_world(room: RoomEnvironment, points: np.ndarray) -> np.ndarray:
    cos, sin = np.cos(room.rotation), np.sin(room.rotation)
    return (points - np.array(room.eye)) @ np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]).T


def _floor_irradiance(loaded: LoadedScene, room: RoomEnvironment, places: np.ndarray, reflectance: float) -> np.ndarray:
    """Return the irradiance of the floor under places in the room, seen from 5 cm above it, (n,)."""
    above = _in_world(room, np.column_stack([places, np.full(len(places), 0.05)]))
    points, down = mi.Point3f(above.T.astype(np.float32)), mi.Vector3f(0.0, 0.0, -1.0)
    assert loaded.room is not None
    radiance, _ = radiance_towards(loaded.room, points, down + dr.zeros(mi.Vector3f, len(places)))
    return np.pi * np.array(radiance.x) / reflectance


def test_black_walls_get_the_light_of_a_lamp_that_lambert_s_formula_gives(backend: str) -> None:
    # Walls that reflect a hundredth: what they add is below the tolerance, and the floor can still be read.
    room = _room(0.01, LAMP)
    places = np.array([[1.2, 1.0], [2.0, 2.0], [3.5, 0.4], [0.3, 2.7]])
    found = _floor_irradiance(_loaded(room), room, places, 0.01)
    half = 0.5 * np.array(LAMP.size)
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    corners = np.column_stack([LAMP.centre + signs * half, np.full(4, SIZE[2] - 0.03)])
    expected = [np.pi * 3.0 * polygon_form_factor(corners - [*place, 0.0]) for place in places]
    # Paint varies by 5 %, and light between vertices is interpolated.
    np.testing.assert_allclose(found, expected, rtol=0.08)


def test_white_walls_get_the_light_of_an_integrating_cavity(backend: str) -> None:
    # All walls reflect r: the mean irradiance is the lamp's flux over A (1 - r), whatever the room's shape.
    r, lamp = 0.6, LAMP
    loaded = _loaded(_room(r, lamp))
    assert loaded.room is not None
    rows = np.array(loaded.room.first_face)[np.flatnonzero(np.array(loaded.room.is_room))]
    corners = np.array(loaded.room.irradiance).reshape(-1, 3, 3)[..., 0]
    scene = loaded.room.surfaces
    total = area = 0.0
    for shape, first in zip(scene.shapes(), sorted(rows), strict=True):
        p = np.array(shape.vertex_positions_buffer()).reshape(-1, 3)
        faces = np.array(shape.faces_buffer()).reshape(-1, 3)
        a, b, c = (p[faces[:, k]] for k in range(3))
        sides = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        light = corners[first : first + len(faces)].mean(axis=1)
        if light.min() > 0.99 * np.pi * 3.0:  # the lamp itself
            continue
        total, area = total + float(sides @ light), area + float(sides.sum())
    flux = np.pi * 3.0 * lamp.size[0] * lamp.size[1]
    # The lamp and its frame, which reflect another part, are 0.4 % of the area; two rounds of gathering follow an
    # estimate on coarse cells.
    assert total / area == pytest.approx(flux / (area * (1.0 - r)), rel=0.05)


def test_the_table_throws_a_shadow_on_the_floor(backend: str) -> None:
    room = _room(0.5, LAMP)
    places = np.array([[*EYE[:2]], [EYE[0] + 1.2, EYE[1] + 0.9], [EYE[0] - 1.2, EYE[1] - 0.9]])
    under, *beside = _floor_irradiance(_loaded(room, table=1.0), room, places, 0.5)
    assert under < 0.6 * min(beside)


def test_emitter_sampling_and_chance_find_the_same_light_away_from_the_middle(backend: str) -> None:
    room = _room(0.5, LAMP, WINDOW)
    loaded = _loaded(room)
    count = 1 << 16
    rng = np.random.default_rng(4)
    for place in ([0.0, 0.0, 0.3], [0.7, -0.6, 0.2], [-0.8, 0.5, 0.5]):
        u = [mi.Float(x.astype(np.float32)) for x in rng.random((4, count))]
        si = dr.zeros(mi.SurfaceInteraction3f, count)
        si.p, si.n = mi.Point3f(*place), mi.Normal3f(0.6, 0.0, 0.8)
        ds, arriving = sample_emitter(loaded.emitters, si, mi.Point2f(u[0], u[1]))
        cos = dr.dot(si.n, ds.d)
        light = unoccluded(loaded.emitters, si, (ds, arriving), mi.Float(1e-5), (ds.pdf > 0.0) & (cos > 0.0))
        by_emitters = np.array(dr.select(cos > 0.0, cos * light.x, 0.0))
        direction = mi.Frame3f(si.n).to_world(mi.warp.square_to_cosine_hemisphere(mi.Point2f(u[2], u[3])))
        ray = mi.Ray3f(si.p, direction)
        pi = loaded.mi_scene.ray_intersect_preliminary(ray, False, True)
        met = pi.compute_surface_interaction(ray, mi.RayFlags.All, True)
        by_chance = np.pi * np.array(emitted(loaded.emitters, pi, met, ray, mi.Bool(True)).x)
        error = np.hypot(*(values.std() / np.sqrt(count) for values in (by_emitters, by_chance)))
        # Points of the window's reveal lie outside the room's faces and are found by chance alone.
        assert abs(by_emitters.mean() - by_chance.mean()) < 4.0 * error + 0.002 * by_chance.mean()


def test_a_point_of_a_wall_has_the_disparity_of_its_depth(backend: str) -> None:
    loaded = _loaded(_room(0.5, LAMP, panels=(PRINT,)))
    camera = loaded.description.cameras[0]
    geometry = trace_geometry(loaded, camera)
    left, right = (trace_picture(loaded, camera, eye, 1).radiance[..., 0] for eye in ("left", "right"))
    on_wall = np.isin(geometry.id, [ROOM_IDS["wall"], ROOM_IDS["picture"]])
    assert on_wall.mean() > 0.3
    assert np.isfinite(geometry.Z[on_wall]).all()
    rows, columns = np.nonzero(on_wall)
    shifted = columns - camera.focal * camera.baseline / geometry.Z[rows, columns]
    inside = shifted >= 0.0
    rows, columns, shifted = rows[inside], columns[inside], shifted[inside]
    below = np.floor(shifted).astype(int)
    there = right[rows, below] + (shifted - below) * (right[rows, np.minimum(below + 1, 95)] - right[rows, below])
    assert (columns - shifted).min() > 1.5
    here, unmoved = left[rows, columns], right[rows, columns]
    # The print's frame is an edge: without the disparity it is in another place.
    assert np.mean(np.abs(there - here)) < 0.5 * np.mean(np.abs(unmoved - here))
    assert np.median(np.abs(there / here - 1.0)) < 0.01


def test_pixels_that_see_the_room_directly_keep_their_light(backend: str) -> None:
    loaded = _loaded(_room(0.5, LAMP, WINDOW), bodies.ball(0.1, Medium(name="glass", eta=1.5), (0.0, 0.0, 0.11)))
    camera = loaded.description.cameras[0]
    noisy = trace_picture(loaded, camera, "left", 1)
    clean = denoise_image(noisy)
    ids = trace_geometry(loaded, camera).id
    around = np.pad(ids, 1, mode="edge")
    direct = np.all([around[y : y + 72, x : x + 96] >= FIRST_ROOM_ID for y in range(3) for x in range(3)], axis=0)
    assert direct.sum() > 1000
    np.testing.assert_array_equal(clean[direct], noisy.radiance[direct])
