"""What holds vessels that do not stand: a block for test tubes, a ring of cork for round flasks."""

from __future__ import annotations

import numpy as np

from ...core.mesh import Mesh
from ..description.bodies import Prop
from ..description.material import OpaqueMaterial, ProceduralTexture, UniformTexture
from ..props.normals import creased
from ..props.revolution import revolve, rounded
from .attach import CONTACT, opaque_part
from .host import Host

#: Block: number of holes, play of a tube in its hole, distance between holes beside the tube's width, wall beside them
#: and below them [m]; depth of the holes, of the tube's height.
_HOLES, _PLAY, _BETWEEN, _BESIDE, _BELOW, _DEPTH = (1, 6), 4e-4, (0.006, 0.012), (0.006, 0.01), 0.008, (0.35, 0.55)
#: Ring: radius at which a flask touches it, of the flask's; width and height of its section, of that radius.
_TOUCH, _WIDTH, _HEIGHT = (0.5, 0.64), (0.5, 0.7), (0.42, 0.6)
#: Segments of a hole [1].
_ROUND = 64
#: Plastics of racks, linear Rec.709, and the tones of their woods.
_PLASTICS = ((0.72, 0.72, 0.71), (0.05, 0.13, 0.42), (0.6, 0.3, 0.02), (0.45, 0.04, 0.04))
_WOOD = ((0.60, 0.40, 0.24), (0.33, 0.19, 0.10))
_CORK = ((0.42, 0.27, 0.15), (0.56, 0.39, 0.24))


def draw_block(rng: np.random.Generator, host: Host) -> Prop:
    """Draw a block with holes, in one of which a tube stands."""
    import manifold3d  # here, as few scenes need it

    radius, height = float(host.radius(np.linspace(-0.9 * host.rim, 0.6 * host.rim, 64)).max()), 2.0 * host.rim
    count = int(rng.integers(_HOLES[0], _HOLES[1] + 1))
    pitch, beside = 2.0 * radius + rng.uniform(*_BETWEEN), rng.uniform(*_BESIDE)
    depth, own, wooden = rng.uniform(*_DEPTH) * height, int(rng.integers(count)), rng.random() < 0.5
    plastic, seed = _PLASTICS[int(rng.integers(len(_PLASTICS)))], int(rng.integers(2**31))
    hole = radius + _PLAY
    size = ((count - 1) * pitch + 2.0 * (hole + beside), 2.0 * (hole + beside), depth + _BELOW)
    solid = manifold3d.Manifold.cube(size, True)
    for number in range(count):
        drill = manifold3d.Manifold.cylinder(2.0 * depth, hole, hole, _ROUND)
        x = (number - 0.5 * (count - 1)) * pitch
        solid = solid - drill.translate((x, 0.0, _BELOW - 0.5 * size[2]))
    mesh = solid.to_mesh()
    vertices, faces = np.asarray(mesh.vert_properties, np.float64)[:, :3], np.asarray(mesh.tri_verts, np.int64)
    points, corners, normals, _ = creased(vertices, faces)
    # Planks run along x; texture coordinates are in metres.
    uv = np.stack([points[:, 0] + 0.3 * points[:, 2], points[:, 1] + points[:, 2]], axis=1)
    material = (
        OpaqueMaterial(
            name="wood",
            base_colour=ProceduralTexture(kind="wood", colours=_WOOD, seed=seed),
            repeats=4.0,
            roughness=0.55,
        )
        if wooden
        else OpaqueMaterial(name="plastic", base_colour=UniformTexture(colour=plastic), roughness=0.4)
    )
    x = (own - 0.5 * (count - 1)) * pitch
    place = np.array([-x, 0.0, -host.rim - CONTACT - _BELOW + 0.5 * size[2]])
    return opaque_part(host.body.name, "rack", Mesh("rack", points, corners, normals, uv), material, place)


def draw_ring(rng: np.random.Generator, host: Host) -> Prop:
    """Draw a ring of cork on which a round flask stands."""
    radius = float(host.radius(np.linspace(-host.rim, host.rim, 256)).max())
    touch, width, height = (rng.uniform(*limits) for limits in (_TOUCH, _WIDTH, _HEIGHT))
    seed, inner = int(rng.integers(2**31)), touch * radius
    # A sphere touches the inner edge of the ring's top; the edge is a small bevel.
    outer, top = inner * (1.0 + width), inner * height
    corners = [(inner, 0.5 * top), (inner, 0.0), (outer, 0.0), (outer, top), (inner, top), (inner, 0.5 * top)]
    mesh, unit = revolve(f"{host.body.name}-ring", rounded(corners, [5e-4, 1e-3, 1e-3, 5e-4]), closed=True)
    below = radius - np.sqrt(radius**2 - inner**2)  # of the sphere, from its lowest point to the edge
    material = OpaqueMaterial(
        name="cork",
        base_colour=ProceduralTexture(kind="noise", colours=_CORK, seed=seed, resolution=256),
        repeats=max(1.0, round(unit / 0.04)),
        roughness=0.9,
    )
    place = np.array([0.0, 0.0, -host.rim + below - CONTACT - 0.5 * top])
    return opaque_part(host.body.name, "ring", mesh, material, place, symmetric=True)
