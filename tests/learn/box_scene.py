"""Pictures of boxes by slabs: exact instance ids and depth, without a renderer."""

from __future__ import annotations

import numpy as np

from glassware.annotate.projection import inverse_pose, pixel_rays
from glassware.annotate.symmetries import ASYMMETRIC, REVOLUTION
from glassware.core.pose import look_at
from glassware.learn.targets.objects import ViewObject, canonical_pose


def camera(rng: np.random.Generator, height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """A pose over the table and a K with a principal point that is not the middle."""
    angle, distance = rng.uniform(0, 2 * np.pi), rng.uniform(0.7, 1.1)
    elevation = rng.uniform(0.3, 1.2)
    eye = distance * np.array([np.cos(elevation) * np.cos(angle), np.cos(elevation) * np.sin(angle), np.sin(elevation)])
    focal = rng.uniform(0.9, 1.1) * width
    shift = rng.uniform(-3, 3, 2)
    K = np.array([[focal, 0, (width - 1) / 2 + shift[0]], [0, focal, (height - 1) / 2 + shift[1]], [0, 0, 1.0]])
    return look_at(eye, np.zeros(3), rng.uniform(-0.2, 0.2)), K


def boxes(rng: np.random.Generator, count: int) -> list[tuple[np.ndarray, np.ndarray, bool]]:
    """World poses, sizes and symmetry of boxes that stand on the table, each in a place of its own."""
    found = []
    places = [(x, y) for x in (-0.15, 0.0, 0.15) for y in (-0.15, 0.0, 0.15)]
    for index, place in enumerate(rng.permutation(len(places))[:count]):
        size, symmetric = rng.uniform(0.04, 0.12, 3), bool(index % 2)
        if symmetric:
            size[1] = size[0]
        turn = rng.uniform(0, 2 * np.pi)
        pose = np.eye(4)
        pose[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        pose[:3, 3] = [*places[place], size[2] / 2]
        found.append((pose, size, symmetric))
    return found


def view(world_T_camera: np.ndarray, K: np.ndarray, scene: list, height: int, width: int):
    """Ids (H, W) uint16, depth (H, W) float32 and the objects of a view; the table is z = 0."""
    camera_T_world = inverse_pose(world_T_camera)
    rays = pixel_rays(height, width, K).reshape(-1, 3)
    down = rays @ world_T_camera[:3, :3].T
    Z = np.where(down[:, 2] < 0, -world_T_camera[2, 3] / np.minimum(down[:, 2], -1e-12), np.inf)
    ids = np.where(np.isfinite(Z), 1, 0)
    poses = [camera_T_world @ pose for pose, _, _ in scene]
    for number, (pose, (_, size, _)) in enumerate(zip(poses, scene, strict=True), start=2):
        origin, direction = -pose[:3, :3].T @ pose[:3, 3], rays @ pose[:3, :3]
        with np.errstate(divide="ignore"):
            enter, leave = (-size / 2 - origin) / direction, (size / 2 - origin) / direction
        first, last = np.minimum(enter, leave).max(1), np.maximum(enter, leave).min(1)
        hit = (first < last) & (first > 0) & (first < Z)
        Z, ids = np.where(hit, first, Z), np.where(hit, number, ids)
    objects = [
        ViewObject(
            id=number,
            category="box",
            transparent=bool(number % 2),
            symmetry=REVOLUTION if symmetric else ASYMMETRIC,
            fill=None,
            camera_T_object=canonical_pose(pose, REVOLUTION) if symmetric else pose,
            size=size,
            visible=int((ids == number).sum()),
        )
        for number, (pose, (_, size, symmetric)) in enumerate(zip(poses, scene, strict=True), start=2)
    ]
    return ids.reshape(height, width).astype(np.uint16), Z.reshape(height, width).astype(np.float32), objects
