"""``glassware predict``: what a network finds in pictures of a user's own, written and drawn."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...annotate.heatmap import HEAT_THRESHOLD
from ...annotate.masks import encode_mask
from ...core.atomic_io import write_atomically
from ...core.errors import InputError
from ...core.json_file import json_text
from ...dataset.format.exr import write_exr
from ...dataset.format.pictures import write_png
from ..training.out_folder import make_out_folder
from .drawing import drawn
from .own_pictures import read_own_picture, read_picture
from .predictor import Prediction, load
from .rigs import RigOptions, with_rig

#: A stereo pair of ours to try weights on, with its camera.
SAMPLE = Path(__file__).resolve().parents[1] / "sample"


def sample_pair() -> tuple[Path, Path]:
    """Return the pictures of the stereo pair that comes with glassware, left and right."""
    return SAMPLE / "left.jpg", SAMPLE / "right.jpg"


def predict(
    weights: Path,
    images: Sequence[Path],
    out: Path,
    device: str = "cpu",
    *,
    trust_cameras: bool = False,
    rig: RigOptions | None = None,
    least_score: float = HEAT_THRESHOLD,
) -> Prediction:
    """Find objects and depth in the first of several pictures of one scene, and write them.

    ``prediction.png`` is the picture with masks, boxes and labels, beside its depth; ``prediction.json`` has the
    objects, with masks as run lengths, and ``depth.exr`` the depth as channel Z [m]. All are in the pixels and the
    frame of the picture that was given.

    Parameters
    ----------
    weights : Path
        Weights by name or file, or a checkpoint.
    images : sequence of Path
        Two pictures or more; the first is labelled. Their cameras stand beside them (`own_pictures`), unless `rig` says
        what the camera of a pair is.
    out : Path
        Output folder.
    device : str
        Torch's name of a device.
    trust_cameras : bool
        Whether to take suspicious cameras too (`camera_checks`, `picture_checks`).
    rig : RigOptions, optional
        The stereo camera of the pair.
    least_score : float
        Objects with a lower score are left out; heat maps are read from `annotate.heatmap.HEAT_THRESHOLD` upwards.

    Raises
    ------
    InputError
        Where a picture is missing, or cannot be used, or has no camera, or fits its camera badly.
    """
    if len(images) < 2:
        found = "one eye" if images else "none"
        raise InputError("pictures", "two or more views of one scene, such as left.png right.png", found)
    predictor = load(weights, device)
    make_out_folder(out)
    if rig is not None and rig.given:
        own = with_rig([read_picture(path) for path in images], rig)
    else:
        own = [read_own_picture(path) for path in images]
    found = predictor.predict(own, images, trust_cameras, least_score)
    _write(found, own[0].picture, images, out)
    return found


def _write(found: Prediction, picture: np.ndarray, images: Sequence[Path], out: Path) -> None:
    write_png(out / "prediction.png", drawn(picture, found))
    write_exr(out / "depth.exr", {"Z": found.depth})
    record = {"images": [str(path) for path in images], "objects": object_records(found)}
    write_atomically(out / "prediction.json", json_text(record).encode())


def object_records(found: Prediction) -> list[dict[str, Any]]:
    """Return the objects as ``prediction.json`` has them."""
    return [
        {
            "category": "transparent" if found.transparent[row] else "opaque",
            "score": float(found.score[row]),
            "peak": found.peak[row].tolist(),
            "camera_T_object": found.camera_T_object[row].tolist(),
            "size": found.size[row].tolist(),
            "corners": found.corners[row].tolist(),
            "pixels": int(found.mask[row].sum()),
            # As in labels.json; pycocotools.mask.decode takes it as it is.
            "mask": {"size": list(found.mask[row].shape), "counts": encode_mask(found.mask[row])},
        }
        for row in range(len(found))
    ]
