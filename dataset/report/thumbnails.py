"""Small pictures of scenes, as JPEG data that a page holds itself."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ...core.errors import InputError
from ..reader import StoredScene

#: Width of a thumbnail [px]: twice that of the gallery's narrowest cell, for screens of two pixels a point.
WIDTH = 320
#: JPEG quality of thumbnails [1, 0 to 100]: about 10 kB each, with no blocks that one sees at this size.
QUALITY = 82


@dataclass(frozen=True)
class Thumbnail:
    """The first left picture of a scene."""

    scene_id: int
    width: int  #: [px]
    height: int  #: [px]
    jpeg: bytes


def thumbnail(scene: StoredScene) -> Thumbnail:
    """Return a scene's first left picture, reduced; InputError where the scene has no view or a damaged picture."""
    views = scene.views
    if not views:
        raise InputError(scene.folder, "views", "none")
    picture = views[0].picture()
    if picture.shape[1] > WIDTH:
        height = max(1, round(picture.shape[0] * WIDTH / picture.shape[1]))
        picture = cv2.resize(picture, (WIDTH, height), interpolation=cv2.INTER_AREA)
    stored = np.ascontiguousarray(picture[..., ::-1])
    done, data = cv2.imencode(".jpg", stored, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    if not done:
        raise ValueError(f"{scene.folder}: a picture of shape {picture.shape} could not be encoded")
    return Thumbnail(scene.scene_id, picture.shape[1], picture.shape[0], data.tobytes())
