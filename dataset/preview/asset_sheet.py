"""A contact sheet of pictures with captions, for what is in a folder of assets."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

#: Gap between pictures, height of a line of captions [px], and the sizes of their letters [1].
_GAP, _LINE, _FONT = 6, 16, 0.4
_BACKGROUND, _TEXT = (24, 24, 27), (225, 225, 228)
#: Width of a letter of the captions [px].
_LETTER = 7


def asset_sheet(pictures: Sequence[np.ndarray], captions: Sequence[Sequence[str]]) -> np.ndarray:
    """Return pictures of one size in a square of cells with lines of text below each, (H, W, 3) uint8.

    Parameters
    ----------
    pictures : sequence of (h, w, 3) uint8
        At least one.
    captions : sequence of sequences of str
        The lines of each; long ones are cut.
    """
    height, width = pictures[0].shape[:2]
    lines = max(len(caption) for caption in captions)
    across = max(1, math.ceil(math.sqrt(len(pictures))))
    rows = math.ceil(len(pictures) / across)
    cell = (height + lines * _LINE + _GAP, width + _GAP)
    sheet = np.full((rows * cell[0] + _GAP, across * cell[1] + _GAP, 3), _BACKGROUND, np.uint8)
    for number, (picture, caption) in enumerate(zip(pictures, captions, strict=True)):
        top, left = (number // across) * cell[0] + _GAP, (number % across) * cell[1] + _GAP
        sheet[top : top + height, left : left + width] = picture
        for place, text in enumerate(caption):
            shown = text.encode("ascii", "replace").decode()[: width // _LETTER]
            origin = (left + 2, top + height + (place + 1) * _LINE - 4)
            cv2.putText(sheet, shown, origin, cv2.FONT_HERSHEY_SIMPLEX, _FONT, _TEXT, 1, cv2.LINE_AA)
    return sheet
