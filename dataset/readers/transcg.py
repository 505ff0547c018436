"""TransCG: captures of two depth cameras, with the depth of scanned models.

::

    metadata.json                                       {"total_scenes": 130, "train": [...], "test": [...]}
    camera_intrinsics/1-camIntrinsics-D435.npy  2-camIntrinsics-L515.npy
    scene1/metadata.json                                {"split", "D435_valid_perspective_list", "L515_..."}
    scene1/0/rgb1.png  depth1.png  depth1-gt.png  depth1-gt-mask.png     1: D435; 2: L515

Depth is in whole numbers: thousandths of a metre of the D435, quarters of these of the L515 (Galaxies99/TransCG, issue
25). Frames that the lists of their scene do not name are bad.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...core.errors import InputError, cause_of
from ...core.json_file import read_json
from .layout import Layout, names_in
from .picture_files import first_of, read_colour, read_depth_png, read_levels
from .source_view import Collection, Entry, LeftOut, SourceCamera, SourceView, check_view

CLASSES = ("background", "transparent")
#: Number in the names of files, name, and steps of depth in a metre of each camera.
CAMERAS = ((1, "D435", 1000.0), (2, "L515", 4000.0))


def _is_unit(names: frozenset[str]) -> bool:
    return "metadata.json" in names and ("camera_intrinsics" in names or "scene1" in names)


def _open(root: Path, units: Sequence[Path]) -> Collection:
    entries: list[Entry] = []
    left_out: list[LeftOut] = []
    for unit in units:
        if "camera_intrinsics" not in names_in(unit):
            raise InputError(unit, "calibration of its cameras, camera_intrinsics/", "none")
        K = {name: _intrinsics(unit / "camera_intrinsics", number, name) for number, name, _ in CAMERAS}
        for scene in sorted((s for s in names_in(unit) if s.startswith("scene") and s[5:].isdigit()), key=_number):
            more, less = _scene(unit / scene, K)
            entries += more
            left_out += less
    notes = (
        "masks name no single objects, and poses are not in these files",
        "true depth is that of the scanned models where they are, and the sensor's elsewhere",
    )
    return Collection(tuple(entries), tuple(left_out), CLASSES, notes)


LAYOUT = Layout(
    name="transcg",
    title="TransCG",
    licence="CC BY-NC-SA 4.0",
    is_unit=_is_unit,
    expected="metadata.json with camera_intrinsics/ and scene1/0/rgb1.png",
    open=_open,
)


def _number(scene: str) -> int:
    return int(scene[5:])


def _intrinsics(folder: Path, number: int, name: str) -> np.ndarray | None:
    path = first_of(folder, (f"{number}-camIntrinsics-{name}.npy", f"camIntrinsics-{name}.npy"))
    if path is None:
        return None
    try:
        with path.open("rb") as file:
            K = np.lib.format.read_array(file)  # refuses pickles, which it reads on request alone
    except OSError as error:
        raise InputError(path, "a readable file", cause_of(error)) from error
    except ValueError as error:
        raise InputError(path, "an array of numbers, and no pickle", str(error)) from error
    if K.shape != (3, 3) or not np.isfinite(K).all():
        raise InputError(path, "an intrinsic matrix of 3 x 3 numbers", K.shape)
    return K.astype(np.float64)


def _scene(folder: Path, K: dict[str, np.ndarray | None]) -> tuple[list[Entry], list[LeftOut]]:
    path = folder / "metadata.json"
    if not path.is_file():
        return [], [LeftOut(folder.name, "expected metadata.json, which lists its good views, found none")]
    record = read_json(path)
    entries, left_out = [], []
    for number, name, steps in CAMERAS:
        for perspective in _valid(record, name, path):
            base = f"{folder.name}/{perspective}"
            files = [f"{kind}{number}{end}.png" for kind, end in (("rgb", ""), ("depth", ""), ("depth", "-gt"))]
            files.append(f"depth{number}-gt-mask.png")
            have = names_in(folder / str(perspective))
            missing = [file for file in files if file not in have]
            matrix = K[name]
            if missing:
                left_out.append(LeftOut(f"{base}/{name}", f"expected {' and '.join(missing)}, found none"))
            elif matrix is None:
                expected = f"expected camera_intrinsics/{number}-camIntrinsics-{name}.npy, found none"
                left_out.append(LeftOut(f"{base}/{name}", expected))
            else:
                read = _reader(folder / str(perspective), files, matrix, steps)
                split = record.get("split")
                entries.append(
                    Entry(f"{base}/{name}", f"{base}/{name}", read, split if split in ("train", "test") else None)
                )
    return entries, left_out


def _valid(record: Any, name: str, path: Path) -> list[int]:
    field = f"{name}_valid_perspective_list"
    found = record.get(field) if isinstance(record, dict) else None
    if not isinstance(found, list) or not all(type(item) is int for item in found):
        raise InputError(f"{path}: {field}", "a list of numbers", type(found).__name__)
    return found


def _reader(folder: Path, files: Sequence[str], K: np.ndarray, steps: float) -> Callable[[], SourceView]:
    def read() -> SourceView:
        picture, sensor, true, mask = (folder / file for file in files)
        return check_view(
            SourceView(
                picture=read_colour(picture),
                camera=SourceCamera(K),
                Z=read_depth_png(true, steps),
                sensor_Z=read_depth_png(sensor, steps),
                classes=(read_levels(mask) > 0).astype(np.uint16),
            ),
            folder,
        )

    return read
