"""How much of the pictures is blown out: white pixels of tables and of whole pictures over many seeds.

    python bench/highlights.py --seeds 1:41

Before: rooms as maps, an incident-light meter alone, highlights clipped, no white balance. After: the defaults. Rooms,
skies and the package's maps as they are drawn. A pixel is blown out where a channel of the 8-bit picture is 255.
"""

from __future__ import annotations

import argparse

import numpy as np
from rich.console import Console

from glassware.core.images import srgb8
from glassware.procedural.description.scene import TABLE_ID, Scene
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.surroundings.camera_settings import CameraSettings
from glassware.procedural.surroundings.environments import bake_environment
from glassware.procedural.surroundings.metering import exposure, irradiance
from glassware.procedural.surroundings.settings import EnvironmentSettings
from glassware.render.backend.variant import activate
from glassware.render.labels.geometry import trace_geometry
from glassware.render.pictures.picture import denoise_image, trace_picture
from glassware.render.scene.loaded_scene import load


def _before(seed: int, cameras: CameraSettings) -> Scene:
    plain = cameras.model_copy(update={"white_balance": "off", "highlights": "clip"})
    settings = SceneSettings(cameras=plain, environment=EnvironmentSettings(room_depth=False))
    scene = draw_scene(settings, seed, 0)
    light = irradiance(bake_environment(scene.environment), scene.environment.strength, scene.lights)
    metered = tuple(camera.model_copy(update={"exposure": exposure(light)}) for camera in scene.cameras)
    return scene.model_copy(update={"cameras": metered})


def _shares(scene: Scene, spp: int) -> tuple[float, float]:
    """Return the shares of blown-out pixels of the table and of the whole picture, over all views."""
    loaded = load(scene.model_copy(update={"picture": scene.picture.model_copy(update={"spp": spp, "light": "path"})}))
    table, whole = [], []
    for camera in scene.cameras:
        picture = srgb8(denoise_image(trace_picture(loaded, camera, "left", 1)), camera.exposure, camera.tone)
        white = (picture == 255).any(axis=-1)
        table.append(white[trace_geometry(loaded, camera).id == TABLE_ID])
        whole.append(white.ravel())
    shares = [float(np.concatenate(found).mean()) if sum(map(len, found)) else 0.0 for found in (table, whole)]
    return shares[0], shares[1]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure how much of pictures is blown out, before and after.")
    parser.add_argument("--seeds", default="1:41", help="first seed, and the one after the last")
    parser.add_argument("--views", type=int, default=2, help="views of each scene")
    parser.add_argument("--width", type=int, default=64, help="width of the pictures [px]")
    parser.add_argument("--spp", type=int, default=8, help="samples per pixel")
    request = parser.parse_args()
    activate("llvm_ad_rgb")
    out = Console(highlight=False, soft_wrap=True)
    cameras = CameraSettings(views=request.views, width=request.width, height=3 * request.width // 4)
    rows = []
    first, end = map(int, request.seeds.split(":"))
    for seed in range(first, end):
        scenes = (_before(seed, cameras), draw_scene(SceneSettings(cameras=cameras), seed, 0))
        rows.append([*_shares(scenes[0], request.spp), *_shares(scenes[1], request.spp)])
        out.print(f"{seed:4d} {scenes[1].environment.kind:>8} " + " ".join(f"{100 * x:6.1f} %" for x in rows[-1]))
    found = 100 * np.array(rows)
    for name, values in zip(("table before", "all before", "table after", "all after"), found.T, strict=True):
        worst = f"{int((values > 5.0).sum())} scenes over 5 %, worst {values.max():.1f} %"
        out.print(f"{name:>12}: mean {values.mean():.2f} %, {worst}")


if __name__ == "__main__":
    main()
