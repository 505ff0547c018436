"""The simulated world: rigid bodies of convex parts over a table top, stepped by MuJoCo on one thread.

Contacts are soft springs over a gap: bodies at rest are `CONTACT_GAP` to twice that apart, so that glass never touches
glass, which a renderer could not tell apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..optics.capillary import GRAVITY
from ..placement.placement import CONTACT_GAP
from .bodies import Mechanics
from .parts import BodyParts
from .substances import ROLLING_ARM, TURNING_ARM
from .wedges import ConvexPart

#: The most that a body moves in a step [m]: as much as the thinnest glass is thick.
_REACH = 1e-3
#: Time between two choices of the step [s], and the fewest and most steps in it [1]. At 1 m/s, a fall from 5 cm, a
#: millimetre takes a millisecond; contacts want a step of at most half their time constant.
_CHOICE, _FEWEST_STEPS, _MOST_STEPS = 0.01, 3, 10
#: Time constant of contacts [s] and their damping ratio [1]: some steps, critically damped, so nothing bounces.
_CONTACT = (0.01, 1.0)
#: Impedance of contacts (at no and full depth, width [m], midpoint, power): nearly rigid from the first tenth of a
#: millimetre on (MuJoCo's documentation, "Solver parameters").
_IMPEDANCE = (0.95, 0.99, 5e-4, 0.5, 2.0)
#: Stiffness of friction over that of contacts [1]: what leans does not creep.
FRICTION_STIFFNESS = 100.0
#: Directions in which a contact resists: with friction against sliding, and against turning and rolling as well. A pair
#: has the larger of both. Parts of one body touch another in many places, which keep each other from turning.
SLIDING, ROLLING = 3, 6
#: Damping of motion and of turning while bodies fall [1/s].
_DAMPING = (0.5, 3.0)
#: Damping of bodies that are held [1/s]: they move by less than a micrometre under an impact.
_HELD = 1e6
#: Thickness of the table top [m]: nothing falls through it.
_TOP = 0.1
#: Height and distance of places where bodies wait [m], beyond every table.
_WAITING = (20.0, 2.0)
#: Kinds of geometry that meet: bodies with bodies, hulls with the table.
MEETS_BODIES, MEETS_TABLE = 1, 2


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A body of the world.

    Parameters
    ----------
    parts : BodyParts
        Its shape.
    mechanics : Mechanics
        Its mass and friction.
    pose : (4, 4) float64, optional
        ``world_T_object`` from the beginning, where it is held; without one it waits.
    """

    parts: BodyParts
    mechanics: Mechanics
    pose: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class World:
    """A simulation and its state, which functions of this module change."""

    model: Any  #: mujoco.MjModel
    data: Any  #: mujoco.MjData
    radii: np.ndarray  #: (n,) largest distance of a body's corners from its origin [m]


def build_world(bodies: Sequence[RigidBody], board: np.ndarray, friction: float) -> World:
    """Return a world in which all bodies are held or wait.

    Parameters
    ----------
    bodies : sequence of RigidBody
        The bodies; their order is that of all results.
    board : (k, 2) float
        Convex outline of the table's top, at z = 0 [m].
    friction : float
        Coefficient of friction of the table [1].
    """
    import mujoco  # here, as only piles need it

    spec = mujoco.MjSpec()
    spec.option.gravity = [0.0, 0.0, -GRAVITY]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone, spec.option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, FRICTION_STIFFNESS
    spec.compiler.balanceinertia = True
    half = np.abs(board).max(0)
    table = {"type": mujoco.mjtGeom.mjGEOM_BOX, "size": [*half, 0.5 * _TOP], "pos": [0.0, 0.0, -0.5 * _TOP]}
    spec.worldbody.add_geom(**table, **contact_settings(friction, (MEETS_TABLE, 0)))
    for number, body in enumerate(bodies):
        _add_body(spec, number, body)
    model = spec.compile()
    data = mujoco.MjData(model)
    radii = np.array([np.linalg.norm(body.parts.hull, axis=1).max() for body in bodies])
    world = World(model, data, radii)
    restart(world, [body.pose for body in bodies])
    return world


def restart(world: World, held: Sequence[np.ndarray | None]) -> None:
    """Begin anew, with each body held in a pose, or waiting where it has none."""
    import mujoco

    mujoco.mj_resetData(world.model, world.data)
    for number, pose in enumerate(held):
        if pose is None:
            put_away(world, number)
        else:
            place(world, number, pose)
            hold(world, number)
    mujoco.mj_forward(world.model, world.data)


def hold(world: World, number: int) -> None:
    """Keep a body where it is: no gravity, and nothing moves it."""
    world.model.body_gravcomp[number + 1] = 1.0
    _set_damping(world, number, (_HELD, _HELD))


def let_go(world: World, number: int, pose: np.ndarray | None = None) -> None:
    """Let a body move freely, from where it is or from a pose, without speed."""
    world.model.body_gravcomp[number + 1] = 0.0
    _set_damping(world, number, _DAMPING)
    if pose is not None:
        place(world, number, pose)


def slow_down(world: World, number: int, rate: float) -> None:
    """Damp the motion and the turning of a body that is free [1/s], so that it comes to rest soon."""
    _set_damping(world, number, (rate, rate))


def place(world: World, number: int, pose: np.ndarray) -> None:
    """Put a body into a pose, without speed."""
    world.data.qpos[7 * number : 7 * number + 7] = [*pose[:3, 3], *_quaternion(pose)]
    world.data.qvel[6 * number : 6 * number + 6] = 0.0


def put_away(world: World, number: int) -> None:
    """Take a body out of the scene, to where it waits."""
    pose = np.eye(4)
    pose[:3, 3] = _waiting_place(number)
    place(world, number, pose)
    hold(world, number)


def advance(world: World, seconds: float) -> None:
    """Simulate for some time [s], in steps that are short while bodies are fast."""
    import mujoco

    for _ in range(max(1, round(seconds / _CHOICE))):
        fastest = float(speeds(world).max(initial=0.0)) + GRAVITY * _CHOICE
        # (What is not finite is no number of steps; `is_broken` says so.)
        wanted = fastest * _CHOICE / _REACH if np.isfinite(fastest) else _MOST_STEPS
        steps = int(np.clip(np.ceil(wanted), _FEWEST_STEPS, _MOST_STEPS))
        world.model.opt.timestep = _CHOICE / steps
        mujoco.mj_step(world.model, world.data, nstep=steps)


def is_broken(world: World) -> bool:
    """Return whether the simulation has lost a body: MuJoCo then starts all over again, and says so."""
    return bool(any(warning.number for warning in world.data.warning)) or not np.isfinite(world.data.qpos).all()


def poses(world: World) -> np.ndarray:
    """Return ``world_T_object`` of all bodies, (n, 4, 4) float64."""
    import mujoco

    found = np.tile(np.eye(4), (len(world.radii), 1, 1))
    rotation = np.empty(9)
    for number, pose in enumerate(found):
        state = world.data.qpos[7 * number : 7 * number + 7]
        mujoco.mju_quat2Mat(rotation, state[3:] / np.linalg.norm(state[3:]))
        pose[:3, :3], pose[:3, 3] = rotation.reshape(3, 3), state[:3]
    return found


def speeds(world: World) -> np.ndarray:
    """Return the most that a point of each body can move in a second, (n,) [m/s]."""
    rates = world.data.qvel.reshape(-1, 6)
    return np.linalg.norm(rates[:, :3], axis=1) + world.radii * np.linalg.norm(rates[:, 3:], axis=1)


def contacts(world: World) -> set[tuple[int, int]]:
    """Return the pairs of bodies that touch, by number, the smaller first; -1 is the table."""
    bodies = world.model.geom_bodyid[np.asarray(world.data.contact.geom).reshape(-1, 2)] - 1
    return {(int(min(pair)), int(max(pair))) for pair in bodies}


def _add_body(spec: Any, number: int, body: RigidBody) -> None:
    pose = np.eye(4) if body.pose is None else body.pose
    place = _waiting_place(number) if body.pose is None else body.pose[:3, 3]
    frame = spec.worldbody.add_body(name=f"body-{number}", pos=place, quat=_quaternion(pose), gravcomp=1.0)
    frame.add_freejoint()
    whole = body.mechanics.whole
    frame.explicitinertial, frame.mass, frame.ipos = True, whole.mass, whole.centre_of_mass
    rows = np.array(whole.inertia)
    frame.fullinertia = [rows[0, 0], rows[1, 1], rows[2, 2], rows[0, 1], rows[0, 2], rows[1, 2]]
    friction = body.mechanics.friction
    # The table meets the hull alone, which touches a plane where the body does; bodies meet each other's parts.
    meets = MEETS_TABLE if body.parts.parts else MEETS_TABLE | MEETS_BODIES
    kind = 0 if body.parts.parts else MEETS_BODIES
    _add_part(spec, frame, f"hull-{number}", ConvexPart(body.parts.hull), contact_settings(friction, (kind, meets)))
    touch = contact_settings(friction, (MEETS_BODIES, MEETS_BODIES)) | {"condim": SLIDING}
    for index, part in enumerate(body.parts.parts):
        _add_part(spec, frame, f"part-{number}-{index}", part, touch)


def _add_part(spec: Any, frame: Any, name: str, part: ConvexPart, contact: dict[str, Any]) -> None:
    import mujoco

    mesh = spec.add_mesh(name=name, uservert=part.points.ravel())
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    for turn in range(part.turns):
        half = np.pi * turn / part.turns
        frame.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=name,
            quat=[np.cos(half), 0.0, 0.0, np.sin(half)],
            **contact,
        )


def contact_settings(friction: float, kinds: tuple[int, int]) -> dict[str, Any]:
    """Return what a geometry does in contacts: its kind, and the kinds that it meets."""
    return {
        "contype": kinds[0],
        "conaffinity": kinds[1],
        "condim": ROLLING,
        "friction": [friction, TURNING_ARM, ROLLING_ARM],
        "margin": CONTACT_GAP,  # a pair keeps the sum of both
        "solref": _CONTACT,
        "solimp": _IMPEDANCE,
    }


def _set_damping(world: World, number: int, rates: tuple[float, float]) -> None:
    model, start = world.model, 6 * number
    model.dof_damping[start : start + 3] = rates[0] * model.body_mass[number + 1]
    model.dof_damping[start + 3 : start + 6] = rates[1] * model.body_inertia[number + 1].mean()


def _waiting_place(number: int) -> list[float]:
    height, distance = _WAITING
    return [distance * (number + 5), 0.0, height]


def _quaternion(pose: np.ndarray) -> np.ndarray:
    import mujoco

    found = np.empty(4)
    mujoco.mju_mat2Quat(found, np.ascontiguousarray(pose[:3, :3]).ravel())
    return found
