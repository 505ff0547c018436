"""Transparent Tableware Dataset (TTD): stereo pairs of tableware with poses.

::

    cameras_params.yml                             K of the rectified pair, as OpenCV writes it
    models/glass.ply                               in millimetres
    default_benchmarks/stereo/mixed/train.json     [{"stereo_images": {"left_camera", "right_camera"},
                                                     "ground_truth": {"glass": {"masks": {...}, "poses": {...}}}}]

Paths in these files start at the folder of the data set. A pose file has ``rotation.data`` and ``translation.data`` in
metres, object to left camera; null where the object cannot be seen. (ivano-donadi/KVN, ttd_converter.py.)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import trimesh

from ...core.errors import InputError
from ...core.json_file import read_json
from ...core.silence import quiet
from ...core.yaml_file import yaml_settings
from .axes import rigid
from .layout import Layout, names_in
from .picture_files import read_colour, read_levels
from .source_view import FIRST_OBJECT, Collection, Entry, LeftOut, SourceCamera, SourceObject, SourceView, check_view

#: Distance of the two cameras [m], which the files do not state: that of its authors' converter.
BASELINE = 0.117341
#: The benchmark that is read: the one of the paper's experiments; else the first.
_BENCHMARK = "mixed"
#: Millimetres of a metre: models are in millimetres, poses in metres.
_MM = 1000.0
_CAMERAS = "cameras_params.yml"


def _is_unit(names: frozenset[str]) -> bool:
    return "default_benchmarks" in names and bool(names & {_CAMERAS, "models"})


def _open(root: Path, units: Sequence[Path]) -> Collection:
    entries: list[Entry] = []
    left_out: list[LeftOut] = []
    notes = ["symmetries are not stated", f"the baseline, {BASELINE} m, is that of its authors' converter"]
    for unit in units:
        if _CAMERAS not in names_in(unit):
            raise InputError(unit, f"calibration of its cameras, {_CAMERAS}", "none")
        K, models = _intrinsics(unit / _CAMERAS), _models(unit / "models")
        folder = unit / "default_benchmarks" / "stereo"
        known = sorted(names_in(folder))
        if not known:
            raise InputError(folder, "a folder for each benchmark", "none")
        benchmark = _BENCHMARK if _BENCHMARK in known else known[0]
        notes.append(f"splits are those of the benchmark {benchmark}")
        seen: set[str] = set()
        for path in sorted((folder / benchmark).glob("*.json")):
            more, less = _listed(unit, path, K, models, seen)
            entries += more
            left_out += less
    return Collection(tuple(entries), tuple(left_out), notes=tuple(notes))


LAYOUT = Layout(
    name="ttd",
    title="Transparent Tableware Dataset (TTD)",
    licence="unknown (see its archive, DOI 10.5281/zenodo.10580443)",
    is_unit=_is_unit,
    expected="default_benchmarks/stereo/mixed/train.json with cameras_params.yml and models/",
    open=_open,
)


def _intrinsics(path: Path) -> np.ndarray:
    try:
        with quiet():
            storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
            K = storage.getNode("K").mat()
            storage.release()
    except (cv2.error, SystemError) as error:
        raise InputError(path, "OpenCV's YAML with a matrix K", "something else") from error
    if K is None or K.shape != (3, 3) or not np.isfinite(K).all():
        raise InputError(f"{path}: K", "a matrix of 3 x 3 numbers", "none" if K is None else K.shape)
    return K.astype(np.float64)


def _models(folder: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return centre and size of each model's box [m], by name."""
    found = {}
    for name in sorted(names_in(folder)):
        if not name.endswith(".ply"):
            continue
        try:
            vertices = np.asarray(getattr(trimesh.load(folder / name, process=False), "vertices", np.zeros((0, 3))))
        except (ValueError, IndexError, KeyError, TypeError) as error:
            raise InputError(folder / name, "a whole PLY file", " ".join(str(error).split())[:120]) from error
        if not len(vertices):
            raise InputError(folder / name, "a PLY file with vertices", "none")
        low, high = vertices.min(axis=0) / _MM, vertices.max(axis=0) / _MM
        found[name.removesuffix(".ply")] = ((low + high) / 2.0, high - low)
    return found


def _listed(
    unit: Path, path: Path, K: np.ndarray, models: Mapping[str, tuple[np.ndarray, np.ndarray]], seen: set[str]
) -> tuple[list[Entry], list[LeftOut]]:
    data = read_json(path)
    if not isinstance(data, list):
        raise InputError(path, "a list of stereo pairs", type(data).__name__)
    split = "train" if path.stem == "train" else "test" if "test" in path.stem else None
    entries, left_out = [], []
    for index, record in enumerate(data):
        where = f"{path}: {index}"
        try:
            left, right = (record["stereo_images"][f"{side}_camera"] for side in ("left", "right"))
            truth = dict(record["ground_truth"])
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(where, "stereo_images and ground_truth", f"none ({error})") from error
        if left in seen:
            continue
        seen.add(left)
        missing = [name for name in (left, right) if not _inside(unit, name, where).is_file()]
        if missing:
            left_out.append(LeftOut(str(left), f"expected {' and '.join(missing)}, found none"))
        else:
            entries.append(Entry(str(left), str(left), _reader(unit, left, right, truth, K, models, where), split))
    return entries, left_out


def _inside(unit: Path, name: Any, where: str) -> Path:
    """Return a file that a record names; InputError where it is not below the data set."""
    if not isinstance(name, str) or not name:
        raise InputError(where, "the path of a file", name)
    # Some releases name their own folder in paths, and some do not.
    for base in (unit, unit.parent):
        path = (base / name).resolve()
        if path.is_relative_to(unit.resolve()) and path.is_file():
            return path
    path = (unit / name).resolve()
    if not path.is_relative_to(unit.resolve()):
        raise InputError(where, "paths below the data set", name)
    return path


def _reader(
    unit: Path,
    left: str,
    right: str,
    truth: Mapping[str, Any],
    K: np.ndarray,
    models: Mapping[str, tuple[np.ndarray, np.ndarray]],
    where: str,
) -> Callable[[], SourceView]:
    def read() -> SourceView:
        picture = read_colour(_inside(unit, left, where))
        instances = np.zeros(picture.shape[:2], np.uint16)
        objects = []
        for name in sorted(truth):
            pose = _field(truth[name], "poses")
            if pose is None:
                continue
            number = len(objects) + FIRST_OBJECT
            objects.append(_object(number, name, _inside(unit, pose, where), models))
            mask = read_levels(_inside(unit, _field(truth[name], "masks"), where))
            if mask.shape != instances.shape:
                raise InputError(f"{where}: {name}", f"a mask of {instances.shape} px", mask.shape)
            instances[mask > 0] = number
        view = SourceView(
            picture=picture,
            right=read_colour(_inside(unit, right, where)),
            camera=SourceCamera(K, None, BASELINE),
            instances=instances,
            objects=tuple(objects),
        )
        return check_view(view, where)

    return read


def _field(record: Any, name: str) -> Any:
    return record.get(name, {}).get("left_camera") if isinstance(record, dict) else None


def _object(number: int, name: str, path: Path, models: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> SourceObject:
    values = yaml_settings(path, "a pose")
    try:
        turn = np.array(values["rotation"]["data"], np.float64).reshape(3, 3)
        shift = np.array(values["translation"]["data"], np.float64).reshape(3)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(path, "rotation.data with 9 and translation.data with 3 numbers", "others") from error
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, shift
    pose = rigid(pose, path)
    if name not in models:
        return SourceObject(number, name, name, True, pose, "stated")
    centre, size = models[name]
    pose[:3, 3] += pose[:3, :3] @ centre
    return SourceObject(number, name, name, True, pose, "stated", size)
