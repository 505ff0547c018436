from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from glassware.core.errors import InputError
from glassware.dataset.format.light_file import read_light, write_light
from glassware.render.frame import SurfaceLight


def _light(count: int) -> SurfaceLight:
    rng = np.random.default_rng(5)
    position, normal, irradiance = rng.standard_normal((3, count, 3)).astype(np.float32)
    ids, paths = rng.integers(0, 65536, count), rng.integers(1, 1 << 32, count)
    return SurfaceLight(ids.astype(np.uint16), position, normal, irradiance, paths.astype(np.uint32))


def test_light_comes_back_as_it_was_written(tmp_path: Path) -> None:
    light = _light(1000)
    write_light(tmp_path / "light.parquet", light)
    read = read_light(tmp_path / "light.parquet")
    for name in ("id", "position", "normal", "irradiance", "paths"):
        ours, theirs = getattr(read, name), getattr(light, name)
        assert ours.dtype == theirs.dtype
        np.testing.assert_array_equal(ours, theirs)


def test_what_is_no_light_is_refused_by_its_name(tmp_path: Path) -> None:
    path = tmp_path / "light.parquet"
    with pytest.raises(InputError, match=r"light\.parquet: expected a readable light\.parquet"):
        read_light(path)
    path.write_bytes(b"PAR1")
    with pytest.raises(InputError, match=r"light\.parquet: expected a readable light\.parquet"):
        read_light(path)
    pq.write_table(pa.table({"id": [1], "x": [0.0]}), path)
    with pytest.raises(InputError, match=r"expected the columns id, x, y, z, .*, found id, x"):
        read_light(path)
