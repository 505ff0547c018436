"""Weights to use a network with, without the state of a run: one safetensors file, and those that come with glassware.

Tensors have the network's own names. Kernels are stored in half precision (float16), which halves the file and moves
outputs by about a thousandth; all else is float32. The metadata entry ``weights`` is a `WeightsHeader` as JSON.
"""

from __future__ import annotations

import importlib.metadata
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import torch
from pydantic import Field, ValidationError
from pydantic_core import from_json
from torch import Tensor

from ...core.errors import InputError
from ...core.json_file import json_text
from ...core.model import Model
from ...core.setting_errors import setting_error, suggest
from ..data.dataset_digest import DatasetRecord
from ..data.settings import ViewSettings
from ..networks.settings import NetworkSettings
from ..networks.weights_file import read_safetensors, write_safetensors

WEIGHTS_SCHEMA = "glassware/weights/1"
#: Metadata entry of the header.
ENTRY = "weights"
#: Folder of the weights that come with glassware, NAME.safetensors with the model card's record NAME.json.
SHIPPED = Path(__file__).resolve().parents[1] / "weights"
_SUFFIX = ".safetensors"
#: Tensors of fewer dimensions stay in float32: biases, scales and the statistics of batch norms, which can exceed the
#: range of half precision.
_KERNEL_DIMENSIONS = 2


class WeightsHeader(Model):
    """What a network was trained for, beside its weights."""

    schema_version: Literal["glassware/weights/1"] = WEIGHTS_SCHEMA
    name: str = Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}$")
    glassware: str = Field(description="Version of glassware that wrote the file")
    network: NetworkSettings
    views: ViewSettings
    focal: float | None = Field(
        default=None, gt=0.0, description="Median focal length of the training pictures at the network's size [px]"
    )
    baseline: float | None = Field(default=None, gt=0.0, description="Median baseline of the training views [m]")
    step: int = Field(ge=0, description="Optimiser steps")
    data: DatasetRecord | None = Field(description="The data set that it was trained on")


def glassware_version() -> str:
    """Return the installed version of glassware."""
    return importlib.metadata.version("glassware")


def write_weights(path: Path, header: WeightsHeader, weights: Mapping[str, Tensor]) -> None:
    """Write weights, kernels in half precision; the file appears complete or not at all."""
    stored = {name: value.half() if _is_kernel(value) else value for name, value in weights.items()}
    write_safetensors(path, stored, {ENTRY: json_text(header.model_dump(mode="json"))})


def read_header(path: Path, metadata: Mapping[str, str]) -> WeightsHeader:
    """Return the header of a weights file; InputError where it is of another version, or damaged."""
    try:
        data = from_json(metadata[ENTRY], allow_inf_nan=False)
    except ValueError as error:
        raise InputError(path, "weights of glassware", "a header that is no JSON") from error
    schema = data.get("schema_version") if isinstance(data, dict) else None
    if schema != WEIGHTS_SCHEMA:
        version = f" of glassware {data['glassware']}" if isinstance(data, dict) and "glassware" in data else ""
        expected = f"weights of the version {WEIGHTS_SCHEMA}, which glassware {glassware_version()} reads"
        raise InputError(path, expected, f"{schema}{version}")
    try:
        return WeightsHeader.model_validate(data, strict=False)
    except ValidationError as error:
        raise setting_error(path, error, WeightsHeader) from error


def read_shipped(path: Path) -> tuple[WeightsHeader, dict[str, Tensor]]:
    """Return header and weights, in float32, of a file of `write_weights`; InputError where it is no such file."""
    tensors, metadata = read_safetensors(path)
    if ENTRY not in metadata:
        raise InputError(path, "weights of glassware export-weights", "a safetensors file without their header")
    header = read_header(path, metadata)
    return header, {name: value.float() if value.dtype == torch.float16 else value for name, value in tensors.items()}


def shipped_weights() -> dict[str, Path]:
    """Return the files of the weights that come with glassware, by their names."""
    return {path.stem: path for path in sorted(SHIPPED.glob(f"*{_SUFFIX}"))}


def weights_path(given: Path) -> Path:
    """Return the file of weights that a user names: by a path, or by the name of weights that come with glassware.

    Raises
    ------
    InputError
        For a bare name that is neither, with the nearest one.
    """
    known = shipped_weights()
    if given.is_file() or given.suffix or given.parent != Path():
        return given
    if given.name in known:
        return known[given.name]
    if given.is_dir():
        return given
    names = f"the name of weights that come with glassware ({', '.join(known) or 'none yet'})"
    raise InputError(given, f"{names}{suggest(given.name.lower(), list(known))}, or a checkpoint file", "neither")


def _is_kernel(value: Tensor) -> bool:
    return value.dtype == torch.float32 and value.ndim >= _KERNEL_DIMENSIONS
