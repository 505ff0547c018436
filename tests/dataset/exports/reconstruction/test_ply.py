"""Point clouds that trimesh reads."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh

from glassware.annotate.projection import project
from glassware.core.errors import InputError
from glassware.dataset.exports.reconstruction.points import VERTEX
from glassware.dataset.exports.run import export
from glassware.dataset.format.ray_files import write_layers
from glassware.dataset.reader import Dataset
from glassware.render.frame import Layers


def _rows(path):
    data = path.read_bytes()
    return np.frombuffer(data[data.index(b"end_header\n") + 11 :], VERTEX)


def test_a_view_comes_back_as_points_with_normals_colours_and_ids(stored, tmp_path):
    export(stored, "ply", tmp_path / "out")
    total = 0
    for view in Dataset.open(stored).views():
        path = tmp_path / "out" / "000000" / f"{view.number:03d}.ply"
        cloud: Any = trimesh.load(path)
        rows = _rows(path)
        camera, geometry = view.camera(), view.geometry()
        pose, hit = np.array(camera.world_T_camera), np.isfinite(geometry.Z)
        pixels, Z = project(np.asarray(cloud.vertices, np.float64), camera.K, pose)
        np.testing.assert_allclose(Z, geometry.Z[hit], atol=1e-6)
        np.testing.assert_allclose(pixels, np.argwhere(hit)[:, ::-1], atol=1e-2)  # coordinates are float32
        normals = np.stack([rows["nx"], rows["ny"], rows["nz"]], axis=1) @ pose[:3, :3]
        np.testing.assert_allclose(normals, geometry.normal[hit], atol=1e-6)
        np.testing.assert_array_equal(np.asarray(cloud.colors)[:, :3], view.picture()[hit])
        np.testing.assert_array_equal(rows["id"], geometry.id[hit])
        total += len(rows)
    assert len(_rows(tmp_path / "out" / "000000" / "scene.ply")) == total


def test_vessels_alone_leave_out_table_and_props(stored, tmp_path):
    export(stored, "ply", tmp_path / "out", vessels_only=True)
    assert set(_rows(tmp_path / "out" / "000000" / "scene.ply")["id"]) == {2}


def test_all_layers_are_points_where_the_data_set_has_them(stored, tmp_path):
    with pytest.raises(InputError, match=r"layers\.exr: expected a data set with layers, made with --write layers"):
        export(stored, "ply", tmp_path / "out", layers=True)
    assert not (tmp_path / "out").exists()
    for view in Dataset.open(stored).views():
        geometry = view.geometry()
        Z, ids = (np.stack([first, second]) for first, second in _two_layers(geometry))
        shape = Z.shape
        layers = Layers(
            Z=Z,
            normal=np.zeros((*shape, 3), np.float16),
            id=ids,
            part=np.zeros(shape, np.uint8),
            material=np.zeros(shape, np.uint16),
            entering=np.zeros(shape, bool),
            count=np.isfinite(Z).sum(axis=0).astype(np.uint16),
        )
        write_layers(view.folder / "layers.exr", layers)
    export(stored, "ply", tmp_path / "out", layers=True)
    for view in Dataset.open(stored).views():
        rows, geometry = _rows(tmp_path / "out" / "000000" / f"{view.number:03d}.ply"), view.geometry()
        behind = np.isfinite(geometry.background_Z) & (geometry.id == 2)
        assert (rows["layer"] == 0).sum() == np.isfinite(geometry.Z).sum()
        np.testing.assert_array_equal(rows["id"][rows["layer"] == 1], geometry.background_id[behind])


def _two_layers(geometry):
    """The first surface, and the background behind glass: depths and ids of both."""
    behind = geometry.id == 2
    yield geometry.Z, np.where(behind, geometry.background_Z, np.inf).astype(np.float32)
    yield geometry.id, np.where(behind, geometry.background_id, 0).astype(np.uint16)
