"""Liquids in vessels that lean or lie: the level is a plane across gravity, wherever the vessel's axis points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh
from ...core.units import volume_text
from ..cavities.interior import interior_of, most_volume
from ..cavities.split import whole
from ..profiles.liquid import brimful_volume
from .bodies import Cavity, MeshVessel, Vessel
from .edits import UPRIGHT, moved
from .filling import fill_vessel
from .mesh_vessel import dry_interfaces_of, mesh_vessel
from .stack import Pour


def poured_in_pose(
    vessel: Vessel | MeshVessel, world_T_object: np.ndarray, pours: Sequence[Pour]
) -> Vessel | MeshVessel:
    """Return a vessel in a pose, with liquids in it as they stand there.

    An upright vessel of revolution keeps its type and gets capillary surfaces. One that leans becomes a vessel of any
    shape: its liquids have flat surfaces, and each record has the direction that is up in the vessel's frame.

    Parameters
    ----------
    vessel : Vessel or MeshVessel
        Without ice or other bodies in it; what it holds is gone.
    world_T_object : (4, 4) float
        Its pose.
    pours : sequence of Pour
        The liquids, heaviest lowest in the end; none leaves it empty.

    Raises
    ------
    InputError
        Where the pose is not rigid, there are bodies in the vessel, or it holds less in this pose.
    """
    placed = moved(vessel, world_T_object)
    assert isinstance(placed, Vessel | MeshVessel)
    if vessel.contents:
        raise InputError(f"{vessel.name}, contents", "none in a vessel that leans", vessel.contents[0].kind)
    turn = placed.world_T_object[:3, :3]
    if turn[2, 2] > np.cos(UPRIGHT):
        return fill_vessel(placed, pours).vessel
    solid = vessel.solid if isinstance(vessel, MeshVessel) else solid_of_glass(vessel)
    empty = _as_mesh_vessel(placed, solid)
    if not pours:
        return empty
    stands = _turned(solid, turn)
    inside = interior_of(stands)
    most, wanted = most_volume(inside), sum(pour.volume for pour in pours)
    if wanted > most:
        limit = f"at most {volume_text(most)} in this pose" if most > 0.0 else "none in this pose, as all flows out"
        raise InputError(f"{vessel.name}, liquids", limit, volume_text(wanted))
    names = {"id": vessel.id, "name": vessel.name, "category": vessel.category, "roughness": vessel.roughness}
    filled = fill_vessel(mesh_vessel(stands, vessel.glass, inside=inside, **names), pours, inside=inside).vessel
    back = turn.T
    interfaces = tuple(part.model_copy(update={"mesh": _turned(part.mesh, back)}) for part in filled.interfaces)
    up = tuple(turn[2].tolist())
    brimful = sum(cavity.volume for cavity in empty.cavities)
    records = [
        liquid.model_copy(update={"up": up, "fill": min(liquid.volume / brimful, 1.0)}) for liquid in filled.liquids
    ]
    return empty.model_copy(update={"interfaces": interfaces, "liquid": records[0], "layers": tuple(records[1:])})


def solid_of_glass(vessel: Vessel) -> Mesh:
    """Return the closed surface of a vessel's glass with its normals, as `MeshVessel.solid` is named."""
    pieces = [part.mesh for part in vessel.interfaces if part.part in ("outside", "wet_wall")]
    return whole(pieces, pieces[0].name.removesuffix("-outside") + "-solid")


def _as_mesh_vessel(vessel: Vessel | MeshVessel, solid: Mesh) -> MeshVessel:
    """Return an empty vessel of any shape of the same glass, whose cavities are those that it has upright."""
    dry = {"liquid": None, "layers": (), "interfaces": dry_interfaces_of(solid, vessel.glass, vessel.roughness)}
    if isinstance(vessel, MeshVessel):
        return vessel.model_copy(update=dry)
    inner = np.array(vessel.inner)
    cavity = Cavity(floor=float(inner[0, 1]), brim=float(inner[-1, 1]), volume=brimful_volume(inner))
    fields = {name: getattr(vessel, name) for name in type(vessel).model_fields if name not in ("outer", "inner")}
    return MeshVessel.model_validate(fields | dry | {"solid": solid, "cavities": (cavity,)})


def _turned(mesh: Mesh, rotation: np.ndarray) -> Mesh:
    # Element by element, so that equal points stay equal.
    x, y, z = mesh.vertices.astype(np.float64).T
    points = np.stack([a * x + b * y + c * z for a, b, c in rotation], axis=1)
    return replace(mesh, vertices=points, normals=None if mesh.normals is None else mesh.normals @ rotation.T)
