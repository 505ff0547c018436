"""Whether filters change what has no noise: clean against noisy pixels that see the surroundings directly.

    python bench/surroundings.py --seeds $(seq 1 40) --views 15 --spp 6 --width 96 --height 72
    python bench/surroundings.py --seeds $(seq 1 40)

Each seed is drawn with the preset `fast`, and its views are path traced with the preset's samples, or with `--spp`, and
filtered. No reference is needed: pixels whose rays see the surroundings directly have no noise, so the filters must not
change them. Pixels in which one of 64 rays meets an object, and those next to them, are left out. Light from the
irradiance cache does not reach these pixels, so it is not stored.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import cv2
import numpy as np
from command import Output, run
from picture import srgb_levels
from table import Row, report

from glassware.core.randomness import stream_seed
from glassware.dataset.settings.draw import draw
from glassware.procedural.description.camera import Camera
from glassware.render.backend.variant import activate

# The variant is set before the modules of the renderer are imported: their types depend on it.
activate()
from glassware.render.cache.draft import resized
from glassware.render.labels.geometry import trace_geometry
from glassware.render.pictures.picture import denoise_image, trace_picture
from glassware.render.scene.loaded_scene import LoadedScene, load

#: Largest change of a pixel [sRGB levels].
MAX_CHANGE = 0.5
#: Rays along a side of each pixel that tell what it shows [1]: cables and forks are thinner than a pixel of a small
#: picture.
_RAYS = 8


@dataclass(frozen=True, kw_only=True)
class Options(Output):
    """What to measure."""

    seeds: tuple[int, ...] = tuple(range(1, 41))
    """Seeds that are drawn."""
    views: int = 1
    """Views of each."""
    spp: int | None = None
    """Samples per pixel instead of the preset's."""
    width: int = 160
    """Width of the pictures [px]."""
    height: int = 120
    """Height of the pictures [px]."""


def main(options: Options) -> int:
    """Measure and print; 1 where a pixel is beyond the bound."""
    changes = [(seed, change) for seed in options.seeds for change in changes_of(seed, options)]
    beyond = [int((change > MAX_CHANGE).sum()) for _, change in changes]
    worst, of = max((float(change.max(initial=0.0)), seed) for seed, change in changes)
    shown = sum(change.size > 0 for _, change in changes)
    rows = [
        Row("pictures", len(changes), note=f"{shown} of them show surroundings"),
        Row("pixels that see the surroundings", sum(change.size for _, change in changes)),
        Row("of these changed by more than the bound", sum(beyond), note=f"in {np.count_nonzero(beyond)} pictures"),
        Row("largest change", worst, "levels", bound=MAX_CHANGE, ok=worst <= MAX_CHANGE, note=f"seed {of}"),
    ]
    spp = "preset's" if options.spp is None else options.spp
    size = f"{options.width}x{options.height}"
    return report("Pixels of the surroundings", rows, options.json_file, seeds=_span(options.seeds), spp=spp, size=size)


def _span(seeds: tuple[int, ...]) -> str:
    return f"{min(seeds)} to {max(seeds)}"


def changes_of(seed: int, options: Options) -> list[np.ndarray]:
    """Return by how many sRGB levels the filters change each pixel of the surroundings, (n,) for each view."""
    picture: dict = {"light": "path"} | ({} if options.spp is None else {"spp": options.spp})
    cameras = {"width": options.width, "height": options.height, "views": options.views}
    scene = draw(seed, preset="fast", picture=picture, cameras=cameras)
    loaded = load(scene)
    return [_change(loaded, view) for view in range(len(scene.cameras))]


def _change(loaded: LoadedScene, view: int) -> np.ndarray:
    scene = loaded.description
    camera, seed_of = scene.cameras[view], stream_seed(scene.seed, scene.scene_id, f"render/{view}/left")
    image = trace_picture(loaded, camera, "left", seed_of)
    surroundings = _sees_surroundings(loaded, camera)
    noisy, clean = (srgb_levels(camera.exposure * x[surroundings]) for x in (image.radiance, denoise_image(image)))
    return np.abs(clean - noisy).max(axis=1, initial=0.0)


def _sees_surroundings(loaded: LoadedScene, camera: Camera) -> np.ndarray:
    """Return which pixels, and those next to them, show no object anywhere, (H, W) bool."""
    fine = resized(camera, _RAYS * camera.width, _RAYS * camera.height)
    empty = (trace_geometry(loaded, fine).id == 0).reshape(camera.height, _RAYS, camera.width, _RAYS).all((1, 3))
    return cv2.erode(empty.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=1).astype(bool)


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
