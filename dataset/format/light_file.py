"""``light.parquet``: the irradiance of points on a scene's opaque surfaces, one row each.

Columns: ``id`` (the object, 1 for the table, 0 for the back of a lamp), ``x, y, z`` (world [m]), ``nx, ny, nz`` (the
normal of the side that the light arrives at), ``r, g, b`` (irradiance: linear Rec.709 radiance times steradians) and
``paths`` (number of paths in the mean).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ...core.errors import InputError
from ...render.frame import SurfaceLight

_FLOATS = {"position": ("x", "y", "z"), "normal": ("nx", "ny", "nz"), "irradiance": ("r", "g", "b")}
SCHEMA = pa.schema(
    [
        ("id", pa.uint16()),
        *((name, pa.float32()) for names in _FLOATS.values() for name in names),
        ("paths", pa.uint32()),
    ],
    metadata={"schema_version": "glassware/light/1"},
)


def write_light(path: Path, light: SurfaceLight) -> None:
    """Write ``light.parquet``."""
    columns = {"id": light.id, "paths": light.paths}
    for field, names in _FLOATS.items():
        columns |= {name: getattr(light, field)[:, k] for k, name in enumerate(names)}
    table = pa.table({name: columns[name] for name in SCHEMA.names}, schema=SCHEMA)
    pq.write_table(table, path, compression="zstd")


def read_light(path: Path) -> SurfaceLight:
    """Read ``light.parquet``; InputError where it is missing or has other columns."""
    try:
        table = pq.read_table(path)
    except (OSError, pa.ArrowException) as error:
        raise InputError(path, "a readable light.parquet", error) from error
    if not table.schema.equals(SCHEMA, check_metadata=True):
        raise InputError(path, f"the columns {', '.join(SCHEMA.names)}", ", ".join(table.schema.names))
    whole = {name: table[name].to_numpy() for name in SCHEMA.names}
    stacked = {field: np.stack([whole[name] for name in names], axis=1) for field, names in _FLOATS.items()}
    return SurfaceLight(id=whole["id"], paths=whole["paths"], **stacked)
