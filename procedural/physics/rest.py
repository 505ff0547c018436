"""When a simulated scene is at rest: slow for a second, and by its end where it was at the beginning.

A speed below a bound is not enough. A pendulum stands still where it turns, a cylinder that rolls at 1 mm/s is as slow
as one whose contacts tremble, and a tower on a wedge gives way after a while. So every body has to be slow all the
time and no point of it may have moved over a second, in which a body that is out of balance by a thousandth of its
weight moves by a millimetre under the damping of this stage.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .world import World, advance, poses, slow_down, speeds

#: Speed of a body at rest [m/s]: contacts of light bodies tremble by a centimetre a second for single steps, which is
#: some micrometres of way.
STILL_SPEED = 0.03
#: Time for which bodies have to be still [s], and the most that any point of them may move within it [m].
STILL_TIME, STILL_DISTANCE = 1.0, 2e-4
#: Time between two looks at the state [s].
LOOK = 0.05


def moved(before: np.ndarray, after: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Return the most that a point of each body has moved between two poses (n, 4, 4), (n,) [m].

    Parameters
    ----------
    before, after : (n, 4, 4) float
        ``world_T_object``.
    radii : (n,) float
        Largest distance of a body's points from its origin [m].
    """
    shift = np.linalg.norm(after[:, :3, 3] - before[:, :3, 3], axis=1)
    turn = np.linalg.norm(after[:, :3, :3] - before[:, :3, :3], ord=2, axis=(1, 2))
    return shift + turn * radii


def comes_to_rest(
    world: World, among: np.ndarray, seconds: float, stops: Callable[[np.ndarray], bool]
) -> tuple[bool, float, float]:
    """Simulate until the bodies are at rest.

    Parameters
    ----------
    world : World
        Its state is changed.
    among : (n,) bool
        The bodies that count.
    seconds : float
        Longest simulated time [s].
    stops : callable
        Poses (n, 4, 4) -> whether it makes no sense to go on.

    Returns
    -------
    bool
        Whether they are at rest.
    float
        The time that was simulated [s].
    float
        The most that a point has moved in the last `STILL_TIME` [m]; where they are not at rest, since the last
        time at which they were still.
    """
    time, since, reference = 0.0, 0.0, poses(world)
    distance = 0.0
    for number in np.flatnonzero(among):
        slow_down(world, int(number))
    while time < seconds:
        advance(world, LOOK)
        time += LOOK
        now = poses(world)
        distance = float(moved(reference, now, world.radii)[among].max(initial=0.0))
        if speeds(world)[among].max(initial=0.0) > STILL_SPEED or distance > STILL_DISTANCE:
            since, reference = time, now
        elif time - since >= STILL_TIME - 0.5 * LOOK:
            return True, time, distance
        if not np.isfinite(now).all() or stops(now):
            break
    return False, time, distance
