"""Render every family of vessels, side by side on one table: the picture in `docs/vessels.md`.

Run with ``python bench/gallery_families.py out.png``; four rows of seven vessels, in the order of the settings.
"""

from __future__ import annotations

import sys

import imageio.v3 as iio
import numpy as np

import glassware as gw
from glassware.core.images import srgb8
from glassware.core.pose import look_at
from glassware.procedural.description.scene import FIRST_OBJECT_ID, GlassBody, Prop
from glassware.procedural.placement.placement import CONTACT_GAP
from glassware.procedural.placement.resting import lowered, turn_about_z
from glassware.procedural.scene.asset_files import AssetFiles
from glassware.procedural.scene.draw_vessels import draw_vessels, group_mesh
from glassware.procedural.vessels.settings import CATEGORIES, VesselSettings

#: Distances of columns and rows [m], samples a pixel, seed, size of the picture [px].
ACROSS, BEHIND, SAMPLES, SEED, SIZE = 0.17, 0.2, 32, 11, (1008, 576)


def main(path: str) -> None:
    """Render the gallery."""
    scene = gw.draw(
        seed=2,
        vessel_count=[0, 0],
        prop_count=[0, 0],
        table={"smallest": 1.9, "largest": 2.0, "round_share": 0.0},
        cameras={"views": 1, "width": SIZE[0], "height": SIZE[1]},
        picture={"spp": SAMPLES},
    )
    objects = []
    for number, category in enumerate(CATEGORIES):
        settings = VesselSettings(
            categories=(category,),
            closed_probability=0.7,
            label_probability=1.0,
            fill_probability=0.7,
            rough_probability=0,
        )
        (body,), parts = draw_vessels(settings, SEED, number, 1, AssetFiles())
        row, column = divmod(number, 7)
        pose = lowered(turn_about_z(-0.6), group_mesh(body, parts[body.name]))
        pose[:3, 3] += [ACROSS * (column - 3), -BEHIND * (row - 1.5), CONTACT_GAP]
        host = f"{category.replace(' ', '-')}"
        for item in (body, *parts[body.name]):
            relative = np.eye(4) if item is body else item.world_T_object
            name = item.name.replace(body.name, host)
            part_of = None if item is body else host
            changes = {"id": FIRST_OBJECT_ID + len(objects), "name": name, "part_of": part_of}
            objects.append(item.model_copy(update=changes | {"world_T_object": pose @ relative}))
    eye, target = np.array([0.0, -1.55, 0.95]), np.array([0.0, -0.06, 0.05])
    camera = scene.cameras[0].model_copy(update={"world_T_camera": look_at(eye, target), "focal": 1.35 * SIZE[0]})
    scene = scene.model_copy(
        update={
            "vessels": tuple(item for item in objects if isinstance(item, GlassBody)),
            "props": tuple(item for item in objects if isinstance(item, Prop)),
            "cameras": (camera,),
        }
    )
    frame = gw.Renderer(scene).frame(0)
    iio.imwrite(path, srgb8(np.asarray(frame.left, np.float32), camera.exposure))


if __name__ == "__main__":
    main(sys.argv[1])
