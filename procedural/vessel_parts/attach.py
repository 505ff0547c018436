"""Parts as objects: their own frames, and the relation to the vessel that they go with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...core.mesh import Mesh
from ..description.bodies import GlassBody, Interface, Prop
from ..description.material import OpaqueMaterial
from ..optics.medium import AIR, Medium

#: Distance between a part and the glass that it touches [m]: as between objects and the table, but of what is pressed
#: or glued on.
CONTACT = 3e-5


def opaque_part(
    host: str, category: str, mesh: Mesh, material: OpaqueMaterial, place: np.ndarray, symmetric: bool = False
) -> Prop:
    """Return an opaque part of a vessel.

    Parameters
    ----------
    host : str
        Name of the vessel.
    category : str
        Such as 'cap' or 'label'.
    mesh : Mesh
        Its surface, in a frame of its own.
    material : OpaqueMaterial
        What it is made of.
    place : (3,) float
        Where the origin of the mesh's frame is in the vessel's [m].
    symmetric : bool
        Whether it is a solid of revolution about z.

    Returns
    -------
    Prop
        With ``world_T_object`` as it is in the vessel's frame, and an id that is still to be set.
    """
    mesh, pose, size = _centred(f"{host}-{category}", mesh, place)
    return Prop(
        id=2,
        name=f"{host}-{category}",
        category=category,
        part_of=host,
        mesh=mesh,
        material=material,
        size=size,
        symmetric=symmetric,
        world_T_object=pose,
    )


def glass_part(host: str, category: str, mesh: Mesh, glass: Medium, place: np.ndarray) -> GlassBody:
    """Return a transparent part of revolution of a vessel; as `opaque_part`."""
    name = f"{host}-{category}"
    mesh, pose, size = _centred(f"{name}-outside", mesh, place)
    outside = Interface(part="outside", mesh=replace(mesh, uv=None), front=AIR, back=glass)
    return GlassBody(
        id=2,
        name=name,
        category=category,
        part_of=host,
        glass=glass,
        roughness=0.0,
        interfaces=(outside,),
        size=size,
        symmetric=True,
        world_T_object=pose,
    )


def _centred(name: str, mesh: Mesh, place: np.ndarray) -> tuple[Mesh, np.ndarray, tuple[float, float, float]]:
    middle = mesh.bounds.mean(0)
    vertices = mesh.vertices.astype(np.float64) - middle
    pose = np.eye(4)
    pose[:3, 3] = place + middle
    x, y, z = np.ptp(mesh.bounds, axis=0).tolist()
    return replace(mesh, name=name, vertices=vertices), pose, (x, y, z)
