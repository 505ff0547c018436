"""Draw the picture of docs/cameras.md of one view by the eye and by two sensors, from two data sets.

SETTINGS="--seed 7 --width 320 --height 240 --views 1 --spp 64 --picture.spectral --write radiance"
.venv/bin/render-scene $SETTINGS --sensors.sensitivities nikon-d5100 --out nikon
.venv/bin/render-scene $SETTINGS --sensors.sensitivities sigma-sd-merrill --out sigma
.venv/bin/python docs/sensor_picture.py nikon sigma
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np

from glassware.core.images import srgb8
from glassware.dataset.reader import Dataset

#: Factor by which pictures are enlarged, and height of a line of text [px].
SCALE, LINE = 2, 20
#: Factor on the differences of sRGB values.
GAIN = 4


def panel(picture: np.ndarray, text: str) -> np.ndarray:
    """Return an enlarged picture with a line of text on it."""
    large = cv2.resize(np.ascontiguousarray(picture), None, fx=SCALE, fy=SCALE, interpolation=cv2.INTER_CUBIC)
    height, width = large.shape[:2]
    cv2.rectangle(large, (0, height - LINE), (width, height), (20, 20, 22), -1)
    cv2.putText(large, text, (6, height - 6), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (240, 240, 240), 1, cv2.LINE_AA)
    return large


def difference(picture: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """Return how much more red, green and blue a picture has, on grey."""
    return np.clip(np.rint(128.0 + GAIN * (picture.astype(float) - eye)), 0, 255).astype(np.uint8)


def main() -> None:
    """Write docs/images/sensors_colour.jpg."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("nikon", type=Path)
    parser.add_argument("sigma", type=Path)
    given = parser.parse_args()
    nikon, sigma = (Dataset.open(root).views()[0] for root in (given.nikon, given.sigma))
    eye = srgb8(nikon.radiance(), nikon.camera().exposure, nikon.camera().tone)
    raw = srgb8(nikon.raw(), nikon.camera().exposure)
    rows = [
        [panel(eye, "the eye"), panel(nikon.picture(), "nikon-d5100"), panel(sigma.picture(), "sigma-sd-merrill")],
        [
            panel(raw, "nikon-d5100, raw"),
            panel(difference(nikon.picture(), eye), f"nikon-d5100 less the eye, x {GAIN}"),
            panel(difference(sigma.picture(), eye), f"sigma-sd-merrill less the eye, x {GAIN}"),
        ],
    ]
    sheet = np.vstack([np.hstack(row) for row in rows])
    path = Path(__file__).parent / "images" / "sensors_colour.jpg"
    cv2.imwrite(str(path), sheet[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 85])


if __name__ == "__main__":
    main()
