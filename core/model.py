"""The base class of all models, and their common field types."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    InstanceOf,
    PlainSerializer,
    SerializationInfo,
    ValidationInfo,
    WithJsonSchema,
)

from .errors import InputError
from .mesh import Mesh


class Model(BaseModel):
    """Frozen data; unknown fields are refused, and so are numbers that are not finite."""

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True, allow_inf_nan=False)

    if not TYPE_CHECKING:  # type checkers know the frozen fields without it

        def __setattr__(self, name: str, value: object) -> None:
            """Refuse assignment to a field, with what does it instead."""
            if name in type(self).model_fields:
                expected = f"a changed copy, model_copy(update={{{name!r}: ...}}), as fields are frozen"
                raise InputError(f"{type(self).__name__}.{name}", expected, "an assignment")
            super().__setattr__(name, value)


def differences(expected: Any, found: Any, name: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield the dotted name and both values of each field that differs between two dumped models."""
    if isinstance(expected, dict) and isinstance(found, dict):
        for key in sorted({*expected, *found}):
            yield from differences(expected.get(key), found.get(key), f"{name}.{key}" if name else key)
    elif expected != found:
        yield name, expected, found


def _matrix4(value: object) -> np.ndarray:
    try:
        matrix = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:  # pydantic takes neither for a wrong value
        raise ValueError("expected a 4x4 matrix of numbers, found something else") from error
    if matrix.shape != (4, 4):
        raise ValueError(f"expected a 4x4 matrix, found shape {matrix.shape}")
    if not np.isfinite(matrix).all():
        raise ValueError("expected a 4x4 matrix of finite numbers, found nan or inf")
    matrix.setflags(write=False)
    return matrix


def _mesh(value: object, info: ValidationInfo) -> Mesh:
    if isinstance(value, Mesh):
        return value
    read = (info.context or {}).get("read_mesh")
    if read is None:
        raise ValueError(f"expected a Mesh (names only in scene files), found {type(value).__name__}")
    return read(value)


def _mesh_name(mesh: Mesh, info: SerializationInfo) -> str:
    write = (info.context or {}).get("write_mesh")
    return mesh.name if write is None else write(mesh)


def _ordered(limits: tuple[float, float]) -> tuple[float, float]:
    if limits[0] > limits[1]:
        raise ValueError(f"expected the smaller number first, found {limits}")
    return limits


#: For (smallest, largest) ranges.
Ordered = AfterValidator(_ordered)
#: ``a_T_b``, (4, 4) float64, read-only.
Matrix4 = Annotated[
    InstanceOf[np.ndarray],
    BeforeValidator(_matrix4),
    PlainSerializer(lambda m: m.tolist(), return_type=list),
    WithJsonSchema({"type": "array", "description": "4x4, row-major"}),
]
#: A mesh; its name in JSON, its data in a file beside it (`procedural.scene.scene_file`).
MeshField = Annotated[
    InstanceOf[Mesh],
    BeforeValidator(_mesh),
    PlainSerializer(_mesh_name, return_type=str),
    WithJsonSchema({"type": "string", "description": "file stem of a mesh"}),
]
Vector3 = tuple[float, float, float]
#: Linear Rec.709.
Rgb = tuple[float, float, float]
#: Reflectance in [0, 1], linear Rec.709.
Unit = Annotated[float, Field(ge=0.0, le=1.0)]
Reflectance = tuple[Unit, Unit, Unit]
#: A curve in the half plane of revolution, rows (r, z) [m].
Profile = tuple[tuple[float, float], ...]
