"""Render a glass of water twice: glass and water share one surface, and the water is a second solid inside the glass.

    .venv/bin/python examples/shared_interface.py [--out docs/images/shared_interface.png] [--gap 0.0003] [--spp 256]

On the left light passes from glass to water with the relative index 1.333 / 1.52, as in a real glass. On the right the
water has a surface of its own, a gap of air away from the wall, as many generators of training data model it. Light
then meets glass, air, and water: the wall mirrors what it should let through, and the water looks like silvered glass.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import trimesh

import glassware as gw
from glassware.core.images import srgb8
from glassware.core.mesh import Mesh
from glassware.procedural.description.material import OpaqueMaterial, ProceduralTexture
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import GlassBody, Scene, Vessel
from glassware.procedural.optics.catalogue import catalogue
from glassware.procedural.placement.placement import CONTACT_GAP
from glassware.procedural.primitives.bodies import box_mesh, glass_body, vessel
from glassware.procedural.primitives.scenes import block, board, camera, metered, scene

#: A tumbler [m]: radius of the outside at the foot and at the rim, height, wall, base; fraction of the brimful volume.
FOOT, RIM, HEIGHT, WALL, BASE, FILL = 0.030, 0.038, 0.110, 0.0022, 0.008, 0.6
SLICES = 512  #: segments round the water [1]


def main() -> int:
    """Render both and write them side by side."""
    parser = ArgumentParser(description="Render a glass of water with a shared surface, and with a gap of air.")
    parser.add_argument("--out", type=Path, default=Path("docs/images/shared_interface.png"), help="the picture")
    parser.add_argument("--gap", type=float, default=3e-4, help="width of the gap of air [m]")
    parser.add_argument("--spp", type=int, default=256, help="samples per pixel")
    parser.add_argument("--width", type=int, default=420, help="of each picture [px]")
    given = parser.parse_args()
    both = [_picture(bodies, given.width, given.spp) for bodies in (shared(), gapped(given.gap))]
    given.out.parent.mkdir(parents=True, exist_ok=True)
    line = np.full((len(both[0]), 8, 3), 255, np.uint8)
    cv2.imwrite(str(given.out), np.concatenate([both[0], line, both[1]], axis=1)[..., ::-1])
    return 0


def shared() -> list[Vessel]:
    """Return the glass with water whose wet wall is one surface between glass and water."""
    media = catalogue()
    return [vessel(_profile(), media["soda-lime glass"], wall=WALL, base=BASE, liquid=media["water"], fill=FILL)]


def gapped(gap: float) -> list[GlassBody]:
    """Return the empty glass, and the water as a second solid that is a gap away from its wall."""
    media = catalogue()
    glass = vessel(_profile(), media["soda-lime glass"], wall=WALL, base=BASE)
    (full,) = shared()
    assert full.liquid is not None
    level = full.liquid.level + float(full.world_T_object[2, 3])
    return [glass, glass_body(_water(gap, level), media["water"], id=3, name="water")]


def _profile() -> list[tuple[float, float]]:
    return [(FOOT, 0.0), (RIM, HEIGHT)]


def _water(gap: float, level: float) -> Mesh:
    """Return a solid of revolution with a flat top that stays inside the cavity."""
    low = BASE + CONTACT_GAP + gap
    slope = (RIM - FOOT) / HEIGHT
    wall = WALL * np.hypot(1.0, slope) + gap + 5e-5  # the wall's thickness is across it, the profile's radius level
    corner = 3e-3  # radius of the corner between the cavity's floor and its wall
    angle = np.linspace(-0.5 * np.pi, 0.0, 24)
    foot = FOOT + slope * (low + corner) - wall
    rounded = np.stack([foot - corner + corner * np.cos(angle), low + corner + corner * np.sin(angle)], axis=1)
    profile = np.concatenate([[[0.0, low]], rounded, [[FOOT + slope * level - wall, level], [0.0, level]]])
    solid = trimesh.creation.revolve(profile, sections=SLICES)
    return _creased(solid)


def _creased(solid: trimesh.Trimesh) -> Mesh:
    """Return a mesh with smooth normals but for the edge round the top."""
    smooth = trimesh.graph.smooth_shade(solid, angle=np.radians(40.0))
    return Mesh("water", np.asarray(smooth.vertices), np.asarray(smooth.faces), np.asarray(smooth.vertex_normals))


def _picture(bodies: Sequence[GlassBody], width: int, spp: int) -> np.ndarray:
    """Return the 8-bit picture of bodies on a table, in front of a striped card."""
    description = _on_a_table(bodies, width, spp)
    return srgb8(gw.Renderer(description).frame(0).left, description.cameras[0].exposure)


def _on_a_table(bodies: Sequence[GlassBody], width: int, spp: int) -> Scene:
    room = gw.draw(seed=12, environment={"shipped_share": 0.0})
    stripes = ProceduralTexture(kind="checker", colours=((0.04, 0.10, 0.30), (0.8, 0.8, 0.75)), seed=1)
    paper = OpaqueMaterial(name="card", base_colour=stripes, repeats=20.0, roughness=0.8)
    card = block(_card(), paper, id=9, category="card")
    eye = camera((0.12, -0.42, 0.13), (0.0, 0.0, 0.045), width=width, height=width, focal=3.4 * width)
    wood = ProceduralTexture(kind="wood", colours=((0.30, 0.17, 0.08), (0.45, 0.28, 0.14)), seed=3, resolution=1024)
    top = board((1.2, 0.8, 0.03), OpaqueMaterial(name="oak", base_colour=wood, repeats=2.0, roughness=0.5))
    return metered(
        scene(
            bodies,
            [eye],
            props=[card],
            table=top,
            environment=room.environment,
            lights=room.lights,
            picture=Picture(spp=spp),
        )
    )


def _card() -> Mesh:
    """Return an upright card behind the glass, with texture coordinates in metres over its front."""
    mesh = box_mesh((0.30, 0.004, 0.09), "card", (0.0, 0.09, 0.0455))
    return Mesh("card", mesh.vertices, mesh.faces, uv=mesh.vertices[:, [0, 2]])


if __name__ == "__main__":
    sys.exit(main())
