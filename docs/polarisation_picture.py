"""Draw the picture of docs/polarisation.md from a data set with a polarisation camera.

.venv/bin/render-scene --seed 7 --width 400 --height 300 --views 1 --out polarised --sensors.polarisation imx250mzr
.venv/bin/python docs/polarisation_picture.py polarised
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np

from glassware.core.images import polarisation_colours
from glassware.dataset.reader import Dataset
from glassware.procedural.surroundings.colour import luminance

#: Size of a panel [px].
WIDTH, HEIGHT = 400, 300


def panel(picture: np.ndarray, text: str) -> np.ndarray:
    """Return a picture at the size of a panel, with a line of text on it."""
    small = cv2.resize(np.ascontiguousarray(picture), (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    cv2.rectangle(small, (0, HEIGHT - 20), (WIDTH, HEIGHT), (20, 20, 22), -1)
    cv2.putText(small, text, (6, HEIGHT - 6), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (240, 240, 240), 1, cv2.LINE_AA)
    return small


def main() -> None:
    """Write docs/images/polarisation.jpg."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    view = Dataset.open(parser.parse_args().data).views()[0]
    degree, angle = polarisation_colours(luminance(view.stokes().vector)[..., None])
    measured = polarisation_colours(view.measured_stokes())[0]
    mosaic = np.rint(255.0 * np.clip(view.polarisation_mosaic() / 4095.0, 0.0, 1.0) ** (1.0 / 2.2)).astype(np.uint8)
    rows = [
        [panel(view.picture(), "left.png"), panel(degree, "degree of linear polarisation")],
        [panel(angle, "angle as hue, degree as brightness"), panel(measured, "degree, from the camera's mosaic")],
    ]
    sheet = np.vstack([np.hstack(row) for row in rows])
    centre = np.array(mosaic.shape) // 2
    cut = mosaic[centre[0] - 12 : centre[0] + 12, centre[1] - 16 : centre[1] + 16]
    large = cv2.resize(cut, (160, 120), interpolation=cv2.INTER_NEAREST)
    sheet[2 * HEIGHT - 20 - 124 : 2 * HEIGHT - 24, 2 * WIDTH - 164 : 2 * WIDTH - 4] = large[..., None]
    path = Path(__file__).parent / "images" / "polarisation.jpg"
    cv2.imwrite(str(path), sheet[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 85])


if __name__ == "__main__":
    main()
