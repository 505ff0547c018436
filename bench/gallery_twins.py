"""Render a scene and its counterfactual twins side by side: the picture in `docs/world.md`.

``python bench/gallery_twins.py out.jpg --seed 7``: the scene, then one twin of each kind, in the order of reading.
"""

from __future__ import annotations

import argparse

import imageio.v3 as iio
from gallery_seeds import rendered, sheet

from glassware.procedural.description.twin import TWIN_KINDS


def main() -> None:
    """Render the seed that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--width", type=int, default=280, help="of each picture [px]; its height is 3/4 of it")
    parser.add_argument("--spp", type=int, default=24, help="samples per pixel")
    request = parser.parse_args()
    kinds = ("none", *TWIN_KINDS)
    iio.imwrite(request.path, sheet([rendered(request.seed, request.width, request.spp, twin=k) for k in kinds]))


if __name__ == "__main__":
    main()
