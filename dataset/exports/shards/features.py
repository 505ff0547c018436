"""The types of the columns of a data set on the Hugging Face Hub.

Without them the first five samples decide: a column of numbers that are whole there becomes one of integers, and later
fractions are cut off.
"""

from __future__ import annotations

from typing import Any

#: A type: its name, a list of one type, or a structure by the names of its fields.
Kind = str | list | dict

_MATRIX: Kind = [["float64"]]
CAMERA: Kind = {
    "scene": "int64",
    "view": "int64",
    "width": "int64",
    "height": "int64",
    "K": _MATRIX,
    "world_T_camera": _MATRIX,
    "world_T_right": _MATRIX,
    "baseline": "float64",
    "exposure": "float64",
    "grid_index": "int64",
}
OBJECT: Kind = {
    "id": "int64",
    "name": "string",
    "category": "string",
    "vessel": "bool",
    "size": ["float64"],
    "camera_T_object": _MATRIX,
    "box_modal": ["float64"],
    "box_amodal": ["float64"],
    "mask_size": ["int64"],
    "mask_amodal": "string",
    "mask_seen": "string",
    "visible_pixels": "int64",
    "visible_fraction": "float64",
    "seen_through_fraction": "float64",
    "occluded_fraction": "float64",
    "keypoints": [{"u": "float64", "v": "float64", "Z": "float64", "state": "string"}],
}
GEOMETRY: Kind = {"depth_step_mm": "float64"}
#: Of `camera.json`, as docs/format.md describes them.
DEPTH_CAMERA: dict[str, Kind] = {
    "name": "string",
    "kind": "string",
    "unit": "float64",
    "range": ["float64"],
    "K": _MATRIX,
    "width": "int64",
    "height": "int64",
    "baseline": "float64",
    "camera_T_left": _MATRIX,
    "camera_T_right": _MATRIX,
    "camera_T_projector": _MATRIX,
    "exposure": "float64",
    "gain": "float64",
    "reasons": ["string"],
}
POLARISATION_CAMERA: dict[str, Kind] = {
    "name": "string",
    "angles": _MATRIX,
    "colour": "bool",
    "extinction_ratio": "float64",
    "bits": "int64",
    "black_level": "float64",
    "gain": "float64",
}


def features_yaml(columns: dict[str, Kind]) -> list[dict[str, Any]]:
    """Return columns as ``dataset_info.features`` of a dataset card has them (datasets 4 and later)."""
    return [{"name": name} | _typed(kind) for name, kind in columns.items()]


def _typed(kind: Kind) -> dict[str, Any]:
    if isinstance(kind, str):
        return {"dtype": kind}
    if isinstance(kind, dict):
        return {"struct": features_yaml(kind)}
    (inner,) = kind
    return {"list": _inner(inner)}


def _inner(kind: Kind) -> Any:
    if isinstance(kind, str):
        return kind
    return features_yaml(kind) if isinstance(kind, dict) else _typed(kind)
