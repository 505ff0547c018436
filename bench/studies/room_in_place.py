"""What a room in its place costs beside its map: time and noise of pictures. Study of 29 November 2026.

    python bench/studies/room_in_place.py --seeds 1 3 4

Backs the table in docs/design.md, "A room in its place".

- map: the room as it is seen from the table's centre, as an environment map at infinity.
- room: walls, windows and furniture in their places, with stored light at which paths end (the product).

All pictures of a scene have the same samples per pixel; each method is compared with a reference of its own. Printed
are the processor time of loading and of a picture (all cores) and the relative mean squared error of the exposed values
of table and objects, before and after the denoiser. (In the room the only noise is that of edges and textures.)
"""

from __future__ import annotations

import argparse
from time import process_time

import numpy as np
from rich.console import Console

from glassware.procedural.description.scene import Scene
from glassware.procedural.description.surroundings import FIRST_ROOM_ID
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.surroundings.camera_settings import CameraSettings
from glassware.procedural.surroundings.settings import EnvironmentSettings
from glassware.render.backend.variant import activate
from glassware.render.labels.geometry import trace_geometry
from glassware.render.pictures.picture import denoise_image, trace_picture
from glassware.render.scene.loaded_scene import load

#: Keeps the relative error finite in dark pixels, in exposed values squared.
_EPSILON = 1e-2


def at_infinity(scene: Scene) -> Scene:
    """Return the scene with its room as a map."""
    return scene.model_copy(update={"environment": scene.environment.model_copy(update={"at_infinity": True})})


def _row(scene: Scene, spp: int, reference_spp: int) -> tuple[float, float, float, float]:
    """Return the times of loading and of a picture [s], and its relative squared error before and after denoising."""
    few = scene.picture.model_copy(update={"spp": spp, "light": "path"})
    many = few.model_copy(update={"spp": reference_spp})
    camera = scene.cameras[0]
    load(scene.model_copy(update={"picture": few}))  # compiles
    start = process_time()
    loaded = load(scene.model_copy(update={"picture": few}))
    loading = process_time() - start
    trace_picture(loaded, camera, "left", 1)  # compiles
    start = process_time()
    noisy = trace_picture(loaded, camera, "left", 2)
    seconds = process_time() - start
    reference = trace_picture(load(scene.model_copy(update={"picture": many})), camera, "left", 3).radiance
    ids = trace_geometry(loaded, camera).id
    here = (ids > 0) & (ids < FIRST_ROOM_ID)
    before = _relative(noisy.radiance[here], reference[here], camera.exposure)
    return loading, seconds, before, _relative(denoise_image(noisy)[here], reference[here], camera.exposure)


def _relative(found: np.ndarray, reference: np.ndarray, exposure: float) -> float:
    """Return the relative mean squared error, of values as they are shown (at most 1)."""
    a, b = (np.minimum(exposure * x.astype(float), 1.0) for x in (found, reference))
    return float(((a - b) ** 2 / (b**2 + _EPSILON)).mean())


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Compare a room in its place with its map at infinity.")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 3, 4], help="seeds of the scenes")
    parser.add_argument("--width", type=int, default=64, help="width of the pictures [px]")
    parser.add_argument("--height", type=int, default=48, help="height of the pictures [px]")
    parser.add_argument("--spp", type=int, default=32, help="samples per pixel")
    parser.add_argument("--reference-spp", type=int, default=512, help="samples per pixel of the references")
    request = parser.parse_args()
    activate("llvm_ad_rgb")
    out = Console(highlight=False, soft_wrap=True)
    out.print(f"{'seed':>4} {'room':>5} {'load [s]':>9} {'picture [s]':>12} {'relMSE noisy':>13} {'relMSE clean':>13}")
    for seed in request.seeds:
        cameras = CameraSettings(views=1, width=request.width, height=request.height)
        rooms = EnvironmentSettings(shipped_share=0.0, room_share=1.0, room_depth=True)
        settings = SceneSettings(cameras=cameras, environment=rooms)
        scene = draw_scene(settings, seed, 0)
        for name, described in {"map": at_infinity(scene), "room": scene}.items():
            loading, seconds, before, after = _row(described, request.spp, request.reference_spp)
            out.print(f"{seed:4d} {name:>5} {loading:9.2f} {seconds:12.2f} {before:13.2e} {after:13.2e}")


if __name__ == "__main__":
    main()
