"""A pile that is being made: what all attempts have in common, and one attempt under way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..description.bodies import SceneObject
from ..placement.placement import PlacementSettings
from .sections import hull
from .settings import PhysicsSettings
from .world import RigidBody, World


@dataclass(frozen=True, eq=False)
class Case:
    """What all attempts at a scene have in common."""

    objects: Sequence[SceneObject]
    bodies: list[RigidBody]
    falls: list[int]  #: numbers of the objects that fall
    stands: list[int]  #: numbers of those that stand from the beginning
    filled: list[int]  #: numbers of those that hold something, which keeps its place while they stand
    board: np.ndarray
    settings: PhysicsSettings
    placement: PlacementSettings
    attached: list[Sequence[SceneObject]]  #: parts that move with each object, in its frame
    world: World


@dataclass(eq=False)
class Run:
    """An attempt under way."""

    case: Case
    rng: np.random.Generator
    centre: np.ndarray  #: of the disc over which props fall [m]
    radius: float
    fell_again: int = 0
    seconds: float = 0.0
    moved: float = 0.0
    standing: dict[int, np.ndarray] = field(default_factory=dict)  #: poses of vessels as they were placed
    here: set[int] = field(default_factory=set)  #: numbers of the objects that are in the scene

    @property
    def world(self) -> World:
        """The world of all attempts."""
        return self.case.world


def outline_of(points: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Return the convex outline of a body seen from above, (k, 2) [m]."""
    return hull(points @ pose[:2, :3].T + pose[:2, 3])


def tilt(pose: np.ndarray) -> float:
    """Return the angle of an object's z axis to the vertical [rad]."""
    return float(np.arctan2(np.hypot(*pose[:2, 2]), pose[2, 2]))
