"""A scene of closed forms, and a ray caster for it that shares nothing with the product but its types.

A board, a ball and a block (opaque), and a straight glass: a cylinder less a narrower one. Everything is float64 NumPy;
hits come from quadratics and slabs, not from triangles. The meshes in the description follow these shapes to within
`SAGITTA`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh

from glassware.core.mesh import Mesh
from glassware.procedural.description.camera import Camera
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import Interface, Prop, Scene, Vessel
from glassware.procedural.description.surroundings import SkyEnvironment
from glassware.procedural.optics.medium import AIR, Medium
from glassware.procedural.primitives import bodies, scenes
from glassware.render.frame import Frame, Geometry

SEGMENTS = 256
RADIUS, BORE, HEIGHT, FLOOR = 0.04, 0.036, 0.11, 0.008
BALL = 0.045
BLOCK = (0.07, 0.05, 0.1)
BOARD = (0.9, 0.7, 0.03)
#: Largest distance between the glass and its mesh [m].
SAGITTA = RADIUS * (1 - np.cos(np.pi / SEGMENTS))


@dataclass(frozen=True)
class Sight:
    first_distance: np.ndarray
    opaque_distance: np.ndarray


def scene(views: int = 3) -> Scene:
    clay = scenes.matte((0.6, 0.3, 0.2), "clay").model_copy(update={"roughness": 0.8})
    solid = trimesh.creation.icosphere(subdivisions=4, radius=BALL)
    ball = scenes.block(Mesh("ball", solid.vertices, solid.faces), clay, id=3, category="sphere")
    block = scenes.block(bodies.box_mesh(BLOCK, "block"), clay, id=4, category="box")
    sky = SkyEnvironment(
        sun_elevation=0.7,
        sun_radiance=20.0,
        sun_radius=0.05,
        turbidity=3.0,
        cloudiness=0.1,
        ground=(0.3, 0.3, 0.3),
        seed=1,
    )
    return scenes.scene(
        (_glass(),),
        tuple(camera(i) for i in range(views)),
        props=(
            ball.model_copy(update={"symmetric": True, "world_T_object": pose((-0.09, 0.06, BALL), 0.0)}),
            block.model_copy(update={"world_T_object": pose((0.08, 0.05, BLOCK[2] / 2), 0.6)}),
        ),
        table=scenes.board(BOARD, clay),
        environment=sky,
        picture=Picture(spp=4, max_depth=8),
        seed=7,
    )


def pose(origin: tuple[float, float, float], turn: float) -> np.ndarray:
    c, s = np.cos(turn), np.sin(turn)
    matrix = np.eye(4)
    matrix[:2, :2] = [[c, -s], [s, c]]
    matrix[:3, 3] = origin
    return matrix


def camera(index: int, width: int = 160, height: int = 120) -> Camera:
    """A camera half a metre or so from the table's middle, looking at it."""
    azimuth, elevation, distance = -1.6 + 0.5 * index, 0.45 + 0.2 * index, 0.55
    eye = distance * np.array(
        [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)]
    )
    return scenes.camera(
        tuple(eye),
        (0.0, 0.02, 0.04),
        width=width,
        height=height,
        focal=1.1 * width,
        baseline=0.03,
        grid_index=index,
    )


def geometry(description: Scene, view: Camera, eye: str = "left") -> Geometry:
    world_T_camera = view.world_T_camera if eye == "left" else view.world_T_right
    rotation, origin = world_T_camera[:3, :3], world_T_camera[:3, 3]
    rows, columns = np.mgrid[: view.height, : view.width].reshape(2, -1)
    local = np.stack([(columns - view.centre[0]), (rows - view.centre[1]), np.full(len(rows), view.focal)], axis=1)
    local = local / view.focal  # Z is 1, so that distances in units of the direction are planar depths
    t, normals = cast(description, origin, local @ rotation.T)
    ids = np.array([1, *(item.id for item in description.objects)])
    opaque = np.array([True, *(isinstance(item, Prop) for item in description.objects)])
    solid = np.where(opaque[:, None], t, np.inf)
    first, behind = t.min(axis=0), solid.min(axis=0)
    winner = t.argmin(axis=0)
    shape = (view.height, view.width)
    others = np.stack([np.delete(solid, i, axis=0).min(axis=0) for i in range(1, len(t))])
    normal = normals[winner, np.arange(len(rows))] @ rotation
    normal *= -np.sign((normal * local).sum(axis=1, keepdims=True))
    hit = np.isfinite(first)
    through = np.where((first < behind) & hit, 0.8, 1.0).astype(np.float32)
    return Geometry(
        Z=first.astype(np.float32).reshape(shape),
        normal=np.where(hit[:, None], normal, 0.0).astype(np.float32).reshape(*shape, 3),
        id=np.where(hit, ids[winner], 0).astype(np.uint16).reshape(shape),
        background_Z=behind.astype(np.float32).reshape(shape),
        background_id=np.where(np.isfinite(behind), ids[solid.argmin(axis=0)], 0).astype(np.uint16).reshape(shape),
        transmittance=np.repeat(through[:, None], 3, axis=1).reshape(*shape, 3),
        crossed=np.isfinite(t[1:]).reshape(-1, *shape),
        reached=(np.isfinite(t[1:]) & (t[1:] <= others)).reshape(-1, *shape),
    )


def sight(description: Scene, view: Camera, points: np.ndarray) -> Sight:
    """What rays from the left camera through points, (n, 3), meet."""
    origin = view.world_T_camera[:3, 3]
    directions = points - origin
    t, _ = cast(description, origin, directions / np.linalg.norm(directions, axis=1, keepdims=True))
    opaque = [0, *(1 + i for i, item in enumerate(description.objects) if isinstance(item, Prop))]
    return Sight(t.min(axis=0), t[opaque].min(axis=0))


def frame(description: Scene, view: Camera) -> Frame:
    """Pictures shaded by the normals alone: enough to be looked at."""
    pictures = []
    for eye in ("left", "right"):
        seen = geometry(description, view, eye)
        colours = np.array([[0.2, 0.3, 0.5], [0.45, 0.36, 0.3], [0.5, 0.7, 0.7], [0.7, 0.2, 0.15], [0.15, 0.35, 0.2]])
        shade = np.clip(-seen.normal[..., 2:], 0.25, 1.0).astype(np.float32)
        glass = (seen.id == 2)[..., None]
        picture = colours[seen.background_id] * 0.7 + 0.3 * colours[2]
        pictures.append(np.where(glass, picture * (0.4 + 0.6 * shade), colours[seen.id] * shade).astype(np.float32))
    seconds = {"picture": 2.0, "geometry": 0.1, "denoise": 0.3}
    number = next(i for i, camera in enumerate(description.cameras) if camera is view)
    left, right = pictures
    return Frame(number, left, right, None, None, geometry(description, view), seconds)


def cast(description: Scene, origin: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First hit of each thing (table, then objects): distance in units of the direction, (m, n); normals (m, n, 3)."""
    n = len(directions)
    hits = [_block(np.broadcast_to(np.add(origin, (0, 0, BOARD[2] / 2)), (n, 3)), directions, BOARD)]
    for item in description.objects:
        rotation, shift = item.world_T_object[:3, :3], item.world_T_object[:3, 3]
        o, d = np.broadcast_to((origin - shift) @ rotation, (n, 3)), directions @ rotation
        shape = {"tumbler": _tumbler, "sphere": _ball, "box": lambda a, b: _block(a, b, BLOCK)}[item.category]
        t, normal = shape(o, d)
        hits.append((t, normal @ rotation.T))
    return np.stack([t for t, _ in hits]), np.stack([normal for _, normal in hits])


def _ball(o: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    start, _ = _quadratic((d * d).sum(1), (o * d).sum(1), (o * o).sum(1) - BALL**2)
    t = np.where(start > 0, start, np.inf)
    return t, np.where(np.isfinite(t)[:, None], o + np.where(np.isfinite(t), t, 0)[:, None] * d, 0) / BALL


def _block(o: np.ndarray, d: np.ndarray, size: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    start, end, axis = _slabs(o, d, np.array(size) / 2)
    t = np.where((start <= end) & (start > 0), start, np.inf)
    normal = np.eye(3)[axis] * -np.sign(np.take_along_axis(d, axis[:, None], 1))
    return t, normal


def _tumbler(o: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The solid is [a, c] and [d, b]: the outer cylinder's stretch of the ray less the bore's."""
    low, high = -HEIGHT / 2, HEIGHT / 2
    a, b = _cylinder(o, d, RADIUS, low, high)
    c, e = _cylinder(o, d, BORE, low + FLOOR, high)
    empty = ~(c < e)
    c, e = np.where(empty, b, c), np.where(empty, b, e)
    met = (a < b) & (a > 0)
    t = np.where(met & (a < c - 1e-12), a, np.where(met & (e < b - 1e-12), e, np.inf))
    hit = np.isfinite(t)
    p = o + np.where(hit, t, 0.0)[:, None] * d
    flat = (np.abs(p[:, 2] - high) < 1e-9) | (np.abs(p[:, 2] - low) < 1e-9) | (np.abs(p[:, 2] - low - FLOOR) < 1e-9)
    radial = np.stack([p[:, 0], p[:, 1], np.zeros(len(p))], axis=1)
    radial /= np.maximum(np.linalg.norm(radial, axis=1, keepdims=True), 1e-12)
    return t, np.where(flat[:, None], [[0.0, 0.0, 1.0]], radial)


def _cylinder(o: np.ndarray, d: np.ndarray, radius: float, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    start, end = _quadratic((d[:, :2] ** 2).sum(1), (o[:, :2] * d[:, :2]).sum(1), (o[:, :2] ** 2).sum(1) - radius**2)
    with np.errstate(divide="ignore"):
        ends = np.sort(np.stack([(low - o[:, 2]) / d[:, 2], (high - o[:, 2]) / d[:, 2]]), axis=0)
    return np.maximum(start, ends[0]), np.minimum(end, ends[1])


def _quadratic(a: np.ndarray, half_b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    root = half_b**2 - a * c
    with np.errstate(divide="ignore", invalid="ignore"):
        width = np.sqrt(np.maximum(root, 0.0))
        start, end = (-half_b - width) / a, (-half_b + width) / a
    return np.where(root > 0, start, np.inf), np.where(root > 0, end, -np.inf)


def _slabs(o: np.ndarray, d: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    with np.errstate(divide="ignore"):
        a, b = (-half - o) / d, (half - o) / d
    near, far = np.minimum(a, b), np.maximum(a, b)
    return near.max(axis=1), far.min(axis=1), near.argmax(axis=1)


def _glass() -> Vessel:
    low, high = -HEIGHT / 2, HEIGHT / 2
    crown = (RADIUS + BORE) / 2
    outer = ((0.0, low), (RADIUS, low), (RADIUS, high), (crown, high))
    inner = ((0.0, low + FLOOR), (BORE, low + FLOOR), (BORE, high), (crown, high))
    silica = Medium(name="soda-lime", eta=1.52, sigma_a=(0.1, 0.05, 0.1))
    solid = trimesh.creation.revolve(np.array([*outer, *inner[::-1]]), sections=SEGMENTS)
    mesh = Mesh("glass-outside", solid.vertices, solid.faces)
    return Vessel(
        id=2,
        name="glass",
        category="tumbler",
        glass=silica,
        roughness=0.0,
        wall=RADIUS - BORE,
        outer=outer,
        inner=inner,
        interfaces=(Interface(part="outside", mesh=mesh, front=AIR, back=silica),),
        size=(2 * RADIUS, 2 * RADIUS, HEIGHT),
        world_T_object=pose((-0.01, -0.06, HEIGHT / 2), 0.3),
    )
