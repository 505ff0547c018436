"""Render a scene with the simplified optics of other renderers side by side: the picture in `docs/world.md`.

``python bench/gallery_optics.py out.jpg``: full light, a film of air under the liquid, no shadows and caustics of
glass; below, half of the index less one, none of it, and the painted twin.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping

import imageio.v3 as iio
import numpy as np
from gallery_seeds import rendered, sheet

#: What the pictures differ in: settings of `Picture`.
PICTURES = ({}, {"air_gap": True}, {"glass_shadows": False}, {"refractivity": 0.5}, {"refractivity": 0.0})
#: Two clear vessels with drinks on a light table, near the camera.
SETTINGS = {
    "vessel_count": (2, 2),
    "prop_count": (1, 1),
    "vessels": {"categories": ["tumbler", "beaker", "stem glass"], "fill_probability": 1.0, "rough_probability": 0.0},
    "physics": {"piled_probability": 0.0},
}


def main() -> None:
    """Render the seed that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path")
    parser.add_argument("--seed", type=int, default=17)
    parser.add_argument("--width", type=int, default=320, help="of each picture [px]; its height is 3/4 of it")
    parser.add_argument("--spp", type=int, default=96, help="samples per pixel")
    given = parser.parse_args()
    pictures = [_rendered(given, changes) for changes in PICTURES]
    iio.imwrite(given.path, sheet([*pictures, _rendered(given, {}, "opaque")], 3))


def _rendered(given: argparse.Namespace, changes: Mapping[str, object], twin: str = "none") -> np.ndarray:
    picture = {"fireflies": "remove", **changes}
    camera = {"distance": (0.45, 0.5)}
    return rendered(given.seed, given.width, given.spp, cameras=camera, picture=picture, twin=twin, **SETTINGS)


if __name__ == "__main__":
    main()
