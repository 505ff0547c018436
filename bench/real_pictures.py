"""What weights find in real stereo pairs of KeyPose (Liu et al., CVPR 2020), against their masks and known poses.

    python bench/real_pictures.py WEIGHTS KEYPOSE --out out-real [--focal-scales 1.0 0.8]

KEYPOSE is a folder of frames as KeyPose has them, with `objects/` beside them. Each row is one way to show a picture to
the network: `whole` (scaled down, with a border), and windows at the focal length of the training times a factor.
OUT gets `report.json`, and per way and frame the picture with what was found; the true mask and box are white. The
object that counts for a frame is the one whose mask overlaps most with the true one; the others are counted.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import cv2
import numpy as np
import tyro
from rich.console import Console
from rich.table import Table

from glassware.annotate.boxes import CORNER_SIGNS, EDGES
from glassware.annotate.projection import project_camera
from glassware.annotate.symmetries import ASYMMETRIC
from glassware.core.json_file import json_text
from glassware.dataset.cameras.model import Distortion
from glassware.dataset.format.pictures import write_png
from glassware.dataset.readers.recognition import open_source
from glassware.dataset.readers.source_view import SourceObject, SourceView
from glassware.learn.metrics.box_iou import object_iou
from glassware.learn.prediction.drawing import drawn
from glassware.learn.prediction.own_pictures import OwnPicture
from glassware.learn.prediction.predictor import Prediction, Predictor, load

#: Side of the cells in which the nearest vertex of a model hides those behind it [px], and the depth up to which others
#: in the cell are seen as well [m].
CELL, BEHIND = 6, 0.005
WHITE = (255, 255, 255)


@dataclass(frozen=True)
class Request:
    """Weights, frames, and ways to show them."""

    weights: tyro.conf.Positional[Path]
    keypose: tyro.conf.Positional[Path]
    out: Path = Path("out-real")
    focal_scales: Annotated[tuple[float, ...], tyro.conf.arg(help="Factors on the focal length of the training")] = (
        1.0,
    )
    threads: int = 1


def main() -> None:
    """Print a table of all ways, and write report and pictures."""
    import torch

    request = tyro.cli(Request, description=__doc__)
    torch.set_num_threads(request.threads)
    predictor = load(request.weights)
    ways = {"whole": replace(predictor, focal=None)}
    if predictor.focal is not None:
        ways |= {
            f"windows x {scale:g}": replace(predictor, focal=scale * predictor.focal) for scale in request.focal_scales
        }
    _, collection = open_source(request.keypose)
    frames = {entry.name: entry.read() for entry in collection.entries}
    request.out.mkdir(parents=True, exist_ok=True)
    report = {
        way: {name: scored(one, view, request, f"{way}-{name}") for name, view in frames.items()}
        for way, one in ways.items()
    }
    (request.out / "report.json").write_text(json_text({"weights": str(request.weights), "ways": report}))
    show(report)


def scored(predictor: Predictor, view: SourceView, request: Request, name: str) -> dict[str, Any]:
    """Return what a frame scores, and draw it."""
    found = predictor.predict(own(view), ["left", "right"])
    assert view.objects is not None
    assert view.instances is not None
    item, mask = view.objects[0], view.instances == view.objects[0].id
    picture = with_truth(view.picture, mask, item, found.K)
    write_png(request.out / f"{name.replace('/', '-').replace(' ', '')}.png", drawn(picture, found))
    glass = np.zeros_like(mask)
    for one in found.mask[found.transparent]:
        glass |= one
    scores: dict[str, Any] = {
        "found": len(found),
        "glass_iou": iou(glass, mask),
        "depth_mae": depth_error(found, item, request),
    }
    overlaps = [iou(one, mask) for one in found.mask]
    if not overlaps or max(overlaps) == 0.0:
        return scores | {"mask_iou": 0.0}
    best = int(np.argmax(overlaps))
    scores |= {"mask_iou": overlaps[best], "score": float(found.score[best])}
    if item.camera_T_object is not None and item.size is not None:
        pose = found.camera_T_object[best]
        scores |= {
            "centre_error": float(np.linalg.norm(pose[:3, 3] - item.camera_T_object[:3, 3])),
            "z_error": float(pose[2, 3] - item.camera_T_object[2, 3]),
            "box_iou": object_iou(pose, found.size[best], item.camera_T_object, item.size, item.symmetry or ASYMMETRIC),
            "sides": found.size[best].tolist(),
            "true_sides": item.size.tolist(),
        }
    return scores


def own(view: SourceView) -> list[OwnPicture]:
    """Return the pair of a frame with its cameras."""
    camera, right = view.camera, np.eye(4)
    assert camera.K is not None
    assert camera.baseline is not None
    assert view.right is not None
    right[0, 3] = camera.baseline
    return [
        OwnPicture(one, pose, camera.K, Distortion()) for one, pose in ((view.picture, np.eye(4)), (view.right, right))
    ]


def iou(one: np.ndarray, other: np.ndarray) -> float:
    """Return intersection over union of two masks."""
    return float((one & other).sum() / max(1, (one | other).sum()))


def depth_error(found: Prediction, item: SourceObject, request: Request) -> float | None:
    """Return the mean error of the depth at the vertices of the object's model that the camera sees [m]."""
    path = request.keypose / "objects" / f"{item.name}.obj"
    if item.camera_T_object is None or not path.is_file():
        return None
    points = vertices(path)
    points = points - (points.min(axis=0) + points.max(axis=0)) / 2.0
    pixels, Z = project_camera(points @ item.camera_T_object[:3, :3].T + item.camera_T_object[:3, 3], found.K)
    height, width = found.depth.shape
    inside = (pixels >= 0).all(1) & (pixels[:, 0] < width - 1) & (pixels[:, 1] < height - 1)
    cells = (pixels // CELL).astype(int)
    nearest: dict[tuple[int, int], float] = {}
    for (x, y), z in zip(cells[inside].tolist(), Z[inside].tolist(), strict=True):
        nearest[x, y] = min(z, nearest.get((x, y), np.inf))
    seen = inside & np.array(
        [z < nearest.get((x, y), -np.inf) + BEHIND for (x, y), z in zip(cells.tolist(), Z, strict=True)]
    )
    x, y = np.rint(pixels[seen]).astype(int).T
    return float(np.abs(found.depth[y, x] - Z[seen]).mean())


def vertices(path: Path) -> np.ndarray:
    """Return the vertices of the group ``mesh`` of an OBJ file, (n, 3) [m]."""
    rows, group = [], ""
    for line in path.read_text().splitlines():
        kind, *words = line.split() or [""]
        if kind in ("o", "g"):
            group = words[0]
        elif kind == "v" and group == "mesh":
            rows.append([float(word) for word in words[:3]])
    return np.array(rows)


def with_truth(picture: np.ndarray, mask: np.ndarray, item: SourceObject, K: np.ndarray) -> np.ndarray:
    """Return a picture with the outline of the true mask and the true box in white."""
    shown = picture.copy()
    outlines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(shown, outlines, -1, WHITE, 2, cv2.LINE_AA)
    if item.camera_T_object is not None and item.size is not None:
        corners = CORNER_SIGNS * item.size / 2.0 @ item.camera_T_object[:3, :3].T + item.camera_T_object[:3, 3]
        ends = np.rint(project_camera(corners, K)[0]).astype(int).tolist()
        for a, b in EDGES:
            cv2.line(shown, ends[a], ends[b], WHITE, 1, cv2.LINE_AA)
    return shown


def show(report: dict[str, dict[str, dict[str, Any]]]) -> None:
    """Print a row for each way and frame."""
    columns = ("found", "score", "mask_iou", "glass_iou", "centre_error", "z_error", "box_iou", "depth_mae")
    table = Table("way", "frame", *columns)
    for way, frames in report.items():
        for name, scores in frames.items():
            cells = [scores.get(column) for column in columns]
            table.add_row(way, name, *(f"{one:.3f}" if isinstance(one, float) else str(one or 0) for one in cells))
    console = Console()
    (console if console.is_terminal else Console(width=160)).print(table)


if __name__ == "__main__":
    sys.exit(main())
