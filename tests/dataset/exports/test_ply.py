"""Point clouds that trimesh reads."""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh

from glassware.annotate.projection import project
from glassware.dataset.exports.points import VERTEX
from glassware.dataset.exports.run import export
from glassware.dataset.reader import Dataset


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
