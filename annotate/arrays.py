"""Masks and points of a rendered view as arrays, by the names of the objects."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from ..core.arguments import check_type, one_of
from ..core.errors import InputError
from ..procedural.description.scene import Scene
from ..render.frame import Frame
from .labels import Labels
from .masks import decode_mask, instance_mask
from .projection import transformed, unproject

#: Which pixels of an object: where it is the first surface, where no opaque surface hides it (it is visible or seen
#: through glass), or its whole silhouette in the frame.
Kind = Literal["visible", "seen", "silhouette"]
_Coordinates = Literal["camera", "world"]


def masks(view: Frame | Labels, kind: Kind = "visible") -> dict[str, np.ndarray]:
    """Return a mask of each object of a view's left picture.

    Parameters
    ----------
    view : Frame or Labels
        A rendered view, or its labels, which have no ``"visible"`` masks.
    kind : {"visible", "seen", "silhouette"}
        Where the object is the first surface, where no opaque surface hides it, or its whole silhouette in the frame.

    Returns
    -------
    dict of str to (H, W) bool
        By the names of the objects.

    Raises
    ------
    InputError
        For something else than a view, another kind, or a frame without its scene.
    """
    check_type("masks: view", view, (Frame, Labels), "a Frame or Labels")
    one_of("masks: kind", kind, get_args(Kind))
    if isinstance(view, Labels):
        if kind == "visible":
            raise InputError("masks: kind", "seen or silhouette, which labels hold", "visible")
        parts = {item.name: item.mask_seen if kind == "seen" else item.mask_amodal for item in view.objects}
        return {name: decode_mask(part.counts, part.size) for name, part in parts.items()}
    objects, geometry = _scene_of(view, "masks").objects, view.geometry
    if kind == "visible":
        return {item.name: instance_mask(geometry, item.id) for item in objects}
    stack = geometry.reached if kind == "seen" else geometry.crossed
    return {item.name: mask for item, mask in zip(objects, stack, strict=True)}


def points(frame: Frame, coordinates: _Coordinates = "camera") -> np.ndarray:
    """Return the point cloud of the first surfaces that the left camera of a frame sees, glass included.

    Parameters
    ----------
    frame : Frame
        A rendered view.
    coordinates : {"camera", "world"}
        Frame of the points: the left camera's (OpenCV axes), or the world's.

    Returns
    -------
    (n, 3) float64
        One point per pixel that sees a surface, row by row [m].
    """
    check_type("points: frame", frame, Frame, "a Frame")
    one_of("points: coordinates", coordinates, get_args(_Coordinates))
    camera = _scene_of(frame, "points").cameras[frame.view]
    places = unproject(frame.geometry.Z, camera.K)
    found = places[np.isfinite(places[..., 2])]
    return found if coordinates == "camera" else transformed(camera.world_T_camera, found)


def _scene_of(frame: Frame, where: str) -> Scene:
    if not isinstance(frame.scene, Scene):
        raise InputError(f"{where}: frame", "a frame that a Renderer made", "one without its scene")
    return frame.scene
