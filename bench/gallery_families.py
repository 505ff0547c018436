"""Render every family of vessels: the picture in `docs/vessels.md`.

``python bench/gallery_families.py out.jpg``: four rows of seven, the smallest first, each row at a scale of its own.
The names of the families, row by row, are printed. ``--rows 3`` renders one row, ``--width 1400`` a larger picture.
"""

from __future__ import annotations

import argparse
import sys

import imageio.v3 as iio
import numpy as np

import glassware as gw
from glassware.core.assets import asset
from glassware.core.images import srgb8
from glassware.core.mesh import Mesh
from glassware.procedural.description.edits import in_world
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import FIRST_OBJECT_ID, GlassBody, Prop, Scene, SceneObject
from glassware.procedural.description.surroundings import PictureEnvironment
from glassware.procedural.placement.placement import CONTACT_GAP
from glassware.procedural.placement.resting import lowered, turn_about_z
from glassware.procedural.primitives.scenes import board, camera, matte, metered, scene
from glassware.procedural.scene.asset_files import AssetFiles
from glassware.procedural.scene.draw_vessels import draw_vessels, group_mesh
from glassware.procedural.surroundings.shipped_light import shipped_maps
from glassware.procedural.vessels.settings import CATEGORIES, Category, VesselSettings

#: Vessels in a row; gap between them, and what is left free around a row [m].
ACROSS, GAP, BORDER = 7, 0.022, 0.014
#: Turn of each, so that handles and facets show; azimuth of labels and prints, towards the camera's right [rad].
TURN, LABEL_AZIMUTH = -0.6, np.radians(-70.0)
#: Families with a round bottom, which stand in a stand where they are filled.
HELD = ("test tube", "round flask")
#: Seed; map of the package; grey of the table [1]; largest distance of the meshes from the true surfaces [m].
SEED, MAP, GREY, CHORD_ERROR = 11, "interior", 0.3, 40e-6
#: Distance of the camera [m], its elevation [rad]: near enough to see into the vessels, and nothing but table behind.
DISTANCE, ELEVATION = 2.5, np.radians(20.0)


def main() -> None:
    """Render the rows that the command line asks for, one below the other."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path")
    parser.add_argument("--rows", type=int, nargs="+", default=[0, 1, 2, 3])
    parser.add_argument("--width", type=int, default=700, help="of the picture [px]")
    parser.add_argument("--spp", type=int, default=16, help="samples per pixel")
    parser.add_argument("--environment", default=MAP, help="map of the package")
    request = parser.parse_args()
    groups = sorted((drawn(number, name) for number, name in enumerate(CATEGORIES)), key=lambda group: height(group[1]))
    pictures = []
    for row in request.rows:
        chosen = groups[ACROSS * row : ACROSS * (row + 1)]
        sys.stdout.write(", ".join(str(objects[0].category) for objects, _ in chosen) + "\n")
        described = row_scene(chosen, request.width, request.spp, request.environment)
        frame = gw.Renderer(described).frame(0)
        pictures.append(srgb8(np.asarray(frame.left, np.float32), described.cameras[0].exposure))
        iio.imwrite(request.path, np.concatenate(pictures))


def drawn(number: int, category: Category) -> tuple[tuple[SceneObject, ...], Mesh]:
    """Return a vessel of a family with its parts, and the surfaces of all of them, in the vessel's frame."""
    settings = VesselSettings(
        categories=(category,),
        closed_probability=0.7,
        label_probability=1.0,
        fill_probability=1.0 if category in HELD else 0.7,
        rough_probability=0.0,
        chord_error=CHORD_ERROR,
    )
    (body,), parts = draw_vessels(settings, SEED, number, 1, AssetFiles())
    return (body, *parts[body.name]), group_mesh(body, parts[body.name])


def height(mesh: Mesh) -> float:
    """Return the height of a mesh [m]."""
    return float(np.ptp(mesh.bounds[:, 2]))


def turn(items: tuple[SceneObject, ...]) -> float:
    """Return the turn about the vertical in which a vessel is shown [rad]: its label is to the front."""
    for part in items[1:]:
        if isinstance(part, Prop) and part.category in ("label", "print"):
            x, y = in_world(part.mesh, part.world_T_object).points.mean(0)[:2]
            return float(LABEL_AZIMUTH - np.arctan2(y, x))
    return TURN


def row_scene(groups: list[tuple[tuple[SceneObject, ...], Mesh]], width: int, spp: int, environment: str) -> Scene:
    """Return a scene of vessels side by side, seen from the front."""
    objects: list[SceneObject] = []
    left, depth, tallest = 0.0, 0.0, 0.0
    for number, (items, mesh) in enumerate(groups):
        pose = lowered(turn_about_z(turn(items)), mesh)
        bounds = np.stack([extreme(mesh.vertices @ pose[:3, :3].T, axis=0) for extreme in (np.min, np.max)])
        pose[0, 3] = left - bounds[0, 0]
        pose[2, 3] += CONTACT_GAP
        left += float(np.ptp(bounds[:, 0])) + GAP
        depth, tallest = max(depth, float(-bounds[0, 1])), max(tallest, float(np.ptp(bounds[:, 2])))
        objects += named(items, f"{number}-", pose, FIRST_OBJECT_ID + len(objects))
    span = left - GAP
    scale = width / (span + 2.0 * BORDER)  # [px/m] at the row
    rise, fall = tallest * np.cos(ELEVATION), depth * np.sin(ELEVATION)
    middle = np.array([0.5 * span, 0.0, 0.5 * (rise - fall) / np.cos(ELEVATION)])
    eye = middle + DISTANCE * np.array([0.0, -np.cos(ELEVATION), np.sin(ELEVATION)])
    high = round(scale * (rise + 2.0 * fall + 2.0 * BORDER))
    path = next(path for path in shipped_maps() if path.stem == environment)
    return metered(
        scene(
            [item for item in objects if isinstance(item, GlassBody)],
            [camera(tuple(eye), tuple(middle), width=width, height=high, focal=scale * DISTANCE)],
            props=[item for item in objects if isinstance(item, Prop)],
            table=board((8.0, 8.0, 0.03), matte((GREY, GREY, GREY))),
            environment=PictureEnvironment(asset=asset(path)),
            picture=Picture(spp=spp, light="path", layers=0, refraction=False),
        )
    )


def named(items: tuple[SceneObject, ...], prefix: str, pose: np.ndarray, first: int) -> list[SceneObject]:
    """Return a vessel and its parts at a pose, with ids and names that no other has."""
    body, *parts = items
    changes = {"id": first, "name": prefix + body.name, "world_T_object": pose}
    return [
        body.model_copy(update=changes),
        *[
            part.model_copy(
                update={
                    "id": first + number,
                    "name": prefix + part.name,
                    "part_of": prefix + body.name,
                    "world_T_object": pose @ part.world_T_object,
                }
            )
            for number, part in enumerate(parts, 1)
        ],
    ]


if __name__ == "__main__":
    main()
