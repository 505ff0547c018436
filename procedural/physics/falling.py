"""How an object of a pile falls: turned anyhow or nearly flat, over a disc, from a height over what is below."""

from __future__ import annotations

import numpy as np

from ..placement.placement import apart, inside
from ..placement.resting import resting_turn
from .pile_state import Run, outline_of
from .world import advance, let_go, poses, speeds

#: Time between two props that fall [s]: the first has landed, or nearly so.
_INTERVAL = 0.15
#: Speed below which vessels that were held are let go [m/s], and the longest time until then [s].
_SLOW, _HOLD_TIME = 0.05, 2.0
#: Places tried for a prop before the disc grows, and its growth [1].
_TRIES, _GROWTH = 30, 1.2
#: Fraction of props that begin to fall in a pose in which they could lie, and the tilt that they then have [rad].
_FLAT_FRACTION, _FLAT_TILT = 0.5, 0.15


def fall(run: Run, number: int) -> None:
    """Let an object fall over the disc, from a height over what is below it."""
    hull_points = run.case.bodies[number].parts.hull
    pose = _tumbled(run.rng, hull_points)
    outline = outline_of(hull_points, pose)
    shift = _spot(run, outline)
    below = 0.0
    for other, other_pose in enumerate(poses(run.world)):
        if other in run.here and other != number:
            points = run.case.bodies[other].parts.hull
            if not apart(outline_of(points, other_pose), outline + shift, 0.0):
                below = max(below, float((points @ other_pose[2, :3]).max() + other_pose[2, 3]))
    height = run.rng.uniform(*run.case.settings.drop_height)
    pose[:3, 3] = [*shift, below + height - float((hull_points @ pose[2, :3]).min())]
    let_go(run.world, number, pose)
    run.here.add(number)
    advance(run.world, _INTERVAL)
    run.seconds += _INTERVAL


def calm(run: Run) -> None:
    """Simulate while the vessels are held, until what fell is slow."""
    numbers, time = [number for number in run.case.falls if number in run.here], 0.0
    while time < _HOLD_TIME and numbers and speeds(run.world)[numbers].max() > _SLOW:
        advance(run.world, _INTERVAL)
        time += _INTERVAL
    run.seconds += time


def _tumbled(rng: np.random.Generator, points: np.ndarray) -> np.ndarray:
    """Return a turn of an object that falls: any, or one in which it could nearly lie."""
    from scipy.spatial.transform import Rotation

    lies = rng.random() < _FLAT_FRACTION
    any_turn = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    tilt = Rotation.from_rotvec(_FLAT_TILT * rng.normal(size=3) / np.sqrt(3.0)).as_matrix()
    pose = np.eye(4)
    pose[:3, :3] = tilt @ resting_turn(points, rng)[:3, :3] if lies else any_turn
    return pose


def _spot(run: Run, outline: np.ndarray) -> np.ndarray:
    """Return a place for an outline in the disc, on the table and over no filled vessel."""
    current = poses(run.world)
    mouths = [outline_of(run.case.bodies[number].parts.hull, current[number]) for number in run.case.filled]
    radius, shift = run.radius, run.centre
    while radius < 2.0 * float(np.linalg.norm(run.case.board, axis=1).max()):
        for _ in range(_TRIES):
            angle, distance = run.rng.uniform(0.0, 2.0 * np.pi), radius * np.sqrt(run.rng.random())
            shift = run.centre + distance * np.array([np.cos(angle), np.sin(angle)])
            at = outline + shift
            if inside(at, run.case.board, 0.0) and all(apart(at, mouth, 0.0) for mouth in mouths):
                return shift
        radius = radius * _GROWTH + 0.005
    return shift
