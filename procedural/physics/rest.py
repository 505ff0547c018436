"""When a simulated scene is at rest: slow for a second, and by its end where it was at the beginning.

A speed below a bound is not enough. A pendulum stands still where it turns, a cylinder that rolls at 1 mm/s is as slow
as one whose contacts tremble, and a tower on a wedge gives way after a while. So every body has to be slow all the
time and no point of it may have moved over a second, in which a body that is out of balance by a thousandth of its
weight moves by a quarter of a millimetre under the strongest damping.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .world import World, advance, poses, slow_down, speeds

#: Speed of a body at rest [m/s]: contacts of light bodies tremble by a centimetre a second for single steps, which is
#: some micrometres of way.
STILL_SPEED = 0.03
#: Time for which bodies have to be still [s], and the most that any point of them may move within it [m].
STILL_TIME, STILL_DISTANCE = 1.0, 2e-4
#: Damping of motion and of turning once all have fallen, and in the second half of the time [1/s]: balls stop rolling
#: in a second or two. What is out of balance moves all the same; poses at rest do not depend on it. Friction here is
#: that of soft springs, under which a pen goes on rolling by 0.3 mm a second in the first half; a real one, whose
#: rolling friction holds a tenth of its weight, stays.
_DAMPING, _LATE_DAMPING = 10.0, 40.0
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


class Settling(NamedTuple):
    """How a simulation ended."""

    still: bool  #: whether all bodies that count are at rest
    seconds: float  #: simulated time [s]
    moved: float  #: the most that a point has moved in the last `STILL_TIME`, or since all were still [m]
    restless: np.ndarray  #: (n,) bool, the bodies that were not still in the last `STILL_TIME`


def comes_to_rest(world: World, among: np.ndarray, seconds: float, stops: Callable[[np.ndarray], bool]) -> Settling:
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
    """
    time, since, reference = 0.0, 0.0, poses(world)
    distance, last = np.zeros(len(among)), np.full(len(among), -np.inf)  # when each was last not still [s]
    while time < seconds:
        for number in np.flatnonzero(among):
            slow_down(world, int(number), _DAMPING if time < 0.5 * seconds else _LATE_DAMPING)
        advance(world, LOOK)
        time += LOOK
        now = poses(world)
        distance = moved(reference, now, world.radii)
        moves = among & ((speeds(world) > STILL_SPEED) | (distance > STILL_DISTANCE))
        last[moves] = time
        if moves.any():
            since, reference = time, now
        elif time - since >= STILL_TIME - 0.5 * LOOK:
            return Settling(True, time, float(distance[among].max(initial=0.0)), moves)
        if not np.isfinite(now).all() or stops(now):
            break
    return Settling(False, time, float(distance[among].max(initial=0.0)), time - last < STILL_TIME)
