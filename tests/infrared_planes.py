"""Infrared pictures of planes by closed forms: no renderer takes part."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import map_coordinates

from glassware.procedural.description.camera import Camera
from glassware.procedural.description.depth_camera import DepthCamera
from glassware.procedural.sensors.depth_cameras import DEPTH_CAMERAS
from glassware.render.frame import Infrared
from glassware.render.infrared.pattern import pattern_map


def small(**changes: object) -> DepthCamera:
    """The D435 with a third of its picture, at its own resolution."""
    device = DEPTH_CAMERAS["d435"]
    imager = device.imager.model_copy(update={"width": 320, "height": 120, "centre": None})
    return device.model_copy(update={"imager": imager} | changes)


def colour_camera(device: DepthCamera, focal: float = 430.0) -> Camera:
    """A colour camera in its place, with the world's axes."""
    width, height = device.imager.width, device.imager.height
    centre = ((width - 1) / 2, (height - 1) / 2)
    return Camera(
        width=width,
        height=height,
        focal=focal,
        centre=centre,
        world_T_camera=np.eye(4),
        baseline=0.05,
        exposure=1.0,
        grid_index=None,
    )


def plane_depth(device: DepthCamera, normal: np.ndarray, distance: float, place: float) -> np.ndarray:
    """Planar depth of n . p = distance, p from the left infrared camera, for an eye at x = place."""
    (cx, cy), focal = device.centre, device.imager.focal
    rows, columns = np.indices((device.imager.height, device.imager.width))
    x, y = (columns - cx) / focal, (rows - cy) / focal
    return (distance - normal[0] * place) / (normal[0] * x + normal[1] * y + normal[2])


def dots_on(device: DepthCamera, normal: np.ndarray, Z: np.ndarray, place: float, reflectance: float) -> np.ndarray:
    """Radiance of the pattern on a matte plane: intensity cos / r^2 times reflectance / pi, on 4 points a pixel."""
    pattern = pattern_map(device.projector, 0, device.name)
    (cx, cy), focal = device.centre, device.imager.focal
    total = np.zeros(Z.shape)
    for du, dv in ((-0.25, -0.25), (-0.25, 0.25), (0.25, -0.25), (0.25, 0.25)):
        rows, columns = np.indices(Z.shape)
        x, y = (columns + du - cx) / focal, (rows + dv - cy) / focal
        way = np.stack([x * Z + place - device.projector.place, y * Z, Z], axis=-1)
        at = [(way[..., k] / Z - pattern.corner[k]) / pattern.step - 0.5 for k in (1, 0)]
        density = map_coordinates(pattern.density.astype(float), at, order=1)
        r = np.linalg.norm(way, axis=-1)
        total += density * (r / Z) ** 3 * np.abs(way @ normal) / r / r**2 * reflectance / np.pi
    return (total / 4).astype(np.float32)


def plane(
    device: DepthCamera,
    distance: float,
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0),
    reflectance: float = 0.5,
    ambient: float = 0.05,
) -> Infrared:
    """What the device sees of a matte plane; ambient radiance in kcd/m^2."""
    n = np.array(normal) / np.linalg.norm(normal)
    depths = [plane_depth(device, n, distance, place) for place in (0.0, device.baseline)]
    places = (0.0, device.baseline)
    left, right = (dots_on(device, n, Z, place, reflectance) for Z, place in zip(depths, places, strict=True))
    even = np.full(left.shape, ambient, np.float32)
    pair = device.infrared_pair(colour_camera(device))
    seen = np.ones(left.shape, bool)
    return Infrared(pair, (left, right), (even, even.copy()), depths[0].astype(np.float32), seen, seen.copy())


def ball_before_wall(
    device: DepthCamera, radius: float, near: float, wall: float, reflectance: float = 0.5
) -> Infrared:
    """What the device sees of a matte ball on the axis of its left camera, `near` away, before a wall at z = `wall`."""
    centre = np.array([0.0, 0.0, near + radius])
    pattern = pattern_map(device.projector, 0, device.name)
    (cx, cy), focal = device.centre, device.imager.focal
    projector = np.array([device.projector.place, 0.0, 0.0])
    dots, depths = [], []
    for place in (0.0, device.baseline):
        total = np.zeros((device.imager.height, device.imager.width))
        for du, dv in ((0.0, 0.0), (-0.25, -0.25), (-0.25, 0.25), (0.25, -0.25), (0.25, 0.25)):
            rows, columns = np.indices(total.shape)
            ray = np.stack([(columns + du - cx) / focal, (rows + dv - cy) / focal, np.ones(total.shape)], axis=-1)
            eye = np.array([place, 0.0, 0.0])
            t = first_hit(eye, ray, centre, radius, wall)
            if du == 0.0:
                depths.append(t)
                continue
            points = eye + t[..., None] * ray
            way = points - projector
            lit = first_hit(projector, way, centre, radius, wall) > 1.0 - 1e-6
            on_ball = points[..., 2] < wall - 1e-9
            normal = np.where(on_ball[..., None], (centre - points) / radius, np.array([0.0, 0.0, 1.0]))
            at = [(way[..., k] / way[..., 2] - pattern.corner[k]) / pattern.step - 0.5 for k in (1, 0)]
            density = map_coordinates(pattern.density.astype(float), at, order=1)
            r = np.linalg.norm(way, axis=-1)
            cos = np.maximum(np.einsum("ijk,ijk->ij", way, normal) / r, 0.0)
            total += np.where(lit, density * (r / way[..., 2]) ** 3 * cos / r**2 * reflectance / np.pi, 0.0)
        dots.append((total / 4).astype(np.float32))
    even = np.full(dots[0].shape, 0.05, np.float32)
    pair = device.infrared_pair(colour_camera(device))
    rows, columns = np.indices(even.shape)
    points = depths[0][..., None] * np.stack(
        [(columns - cx) / focal, (rows - cy) / focal, np.ones(even.shape)], axis=-1
    )
    lit, shared = (
        first_hit(eye, points - eye, centre, radius, wall) > 1.0 - 1e-6
        for eye in (projector, np.array([device.baseline, 0.0, 0.0]))
    )
    return Infrared(pair, (dots[0], dots[1]), (even, even.copy()), depths[0].astype(np.float32), lit, shared)


def first_hit(eye: np.ndarray, ray: np.ndarray, centre: np.ndarray, radius: float, wall: float) -> np.ndarray:
    """Distance along rays, in their lengths, to a ball or the wall behind it."""
    to = eye - centre
    a, b, c = (ray * ray).sum(-1), (ray * to).sum(-1), to @ to - radius**2
    root = b * b - a * c
    ball = np.where(root > 0.0, (-b - np.sqrt(np.maximum(root, 0.0))) / a, np.inf)
    return np.minimum(ball, (wall - eye[2]) / ray[..., 2])
