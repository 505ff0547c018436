"""The index is gathered piece by piece, and the same scenes give the same bytes."""

from __future__ import annotations

import pyarrow.parquet as pq
import pytest

from glassware.core.errors import InputError
from glassware.dataset.format.views_table import SCENES_A_GROUP, read_scene_views, write_views_table
from glassware.dataset.reader import Dataset


@pytest.fixture
def records(stored):
    """Records of many scenes, as a generator, and how many of them were asked for."""
    (record,) = read_scene_views(stored)
    asked = []

    def go(count):
        for scene in range(count):
            asked.append(scene)
            yield record.model_copy(
                update={"views": tuple(row.model_copy(update={"scene_id": scene}) for row in record.views)}
            )

    return go, asked


def test_a_group_is_on_the_disk_before_the_next_is_read(records, tmp_path, monkeypatch):
    go, asked = records
    held = []
    write = pq.ParquetWriter.write_table
    monkeypatch.setattr(
        pq.ParquetWriter, "write_table", lambda self, table: held.append(len(asked)) or write(self, table)
    )
    count = 2 * SCENES_A_GROUP + 1
    assert write_views_table(tmp_path, go(count)) == 2 * count
    assert held == [SCENES_A_GROUP, 2 * SCENES_A_GROUP, count]
    with pq.ParquetFile(tmp_path / "views.parquet") as file:
        assert file.num_row_groups == 3
        assert [row["scene_id"] for row in file.read().to_pylist()] == [i for i in range(count) for _ in range(2)]


def test_the_same_scenes_give_the_same_bytes(records, tmp_path):
    go, _ = records
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write_views_table(tmp_path / name, go(70))
    assert (tmp_path / "a" / "views.parquet").read_bytes() == (tmp_path / "b" / "views.parquet").read_bytes()


def test_the_index_is_read_without_the_scenes(stored):
    assert Dataset.open(stored).index(["view", "path"]).to_pylist() == [
        {"view": 0, "path": "scenes/000000/000"},
        {"view": 1, "path": "scenes/000000/001"},
    ]
    (stored / "views.parquet").unlink()
    with pytest.raises(InputError, match=r"views\.parquet: expected an index of views"):
        Dataset.open(stored).index()
