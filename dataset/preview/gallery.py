"""The gallery of a data set: the first views of evenly spaced scenes."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from ..format import layout
from ..format.pictures import read_png
from .contact_sheet import chosen_views

#: Largest number of columns and rows; width of a picture, gap, and height of the captions [px].
_COLUMNS, _ROWS = 8, 6
_CELL, _GAP, _CAPTION = 240, 6, 22
_BACKGROUND, _INK = (24, 24, 27), (225, 225, 228)


def gallery(root: Path) -> np.ndarray | None:
    """Return the gallery of a data set, (H, W, 3) uint8; None where it has no scene.

    It shows the stored left pictures of at most 48 scenes, so it does not depend on how the scenes were rendered.
    """
    scenes = layout.scene_ids(root)
    if not scenes:
        return None
    shown = [scenes[i] for i in chosen_views(len(scenes), _COLUMNS * _ROWS)]
    cells = [_cell(root, scene) for scene in shown]
    height = max(cell.shape[0] for cell in cells) + _GAP
    columns = min(_COLUMNS, len(cells))
    rows = -(-len(cells) // columns)
    sheet = np.full((rows * height + _GAP, columns * (_CELL + _GAP) + _GAP, 3), _BACKGROUND, np.uint8)
    for i, cell in enumerate(cells):
        top, left = _GAP + (i // columns) * height, _GAP + (i % columns) * (_CELL + _GAP)
        sheet[top : top + cell.shape[0], left : left + _CELL] = cell
    return sheet


def _cell(root: Path, scene: int) -> np.ndarray:
    """Return a scene's first left picture, with the scene's number as caption."""
    folder = layout.scene_folder(root, scene)
    picture = read_png(folder / layout.view_name(layout.view_numbers(folder)[0]) / "left.png")
    height = max(1, round(picture.shape[0] * _CELL / picture.shape[1]))
    blend = cv2.INTER_AREA if picture.shape[1] > _CELL else cv2.INTER_CUBIC
    caption = np.full((_CAPTION, _CELL, 3), _BACKGROUND, np.uint8)
    cv2.putText(caption, layout.scene_name(scene), (4, 15), cv2.FONT_HERSHEY_SIMPLEX, 0.42, _INK, 1, cv2.LINE_AA)
    return np.concatenate([cv2.resize(picture, (_CELL, height), interpolation=blend), caption])
