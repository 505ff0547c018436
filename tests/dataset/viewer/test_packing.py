from __future__ import annotations

import numpy as np
import pytest

from glassware.core.mesh import Mesh
from glassware.dataset.viewer.bodies import simplified
from glassware.dataset.viewer.packing import packed


@pytest.mark.parametrize("kind", ["u1", "i1", "u2", "i2", "u4", "f4"])
@pytest.mark.parametrize("shape", [(5, 7), (4, 6, 3), (1, 9), (3, 1)])
def test_arrays_come_back_bit_by_bit(unpack, kind, shape):
    bits = np.random.default_rng(1).integers(0, 256, (*shape[:-1], shape[-1] * np.dtype(kind).itemsize), np.uint8)
    values = bits.view(kind).reshape(shape)
    found = unpack(packed(values))
    assert found.dtype == values.dtype
    np.testing.assert_array_equal(found.view(f"u{values.itemsize}"), values.view(f"u{values.itemsize}"))


def test_a_smooth_map_takes_few_bytes():
    ramp = np.add.outer(np.arange(480), np.arange(640)).astype(np.uint16)
    assert len(packed(ramp)["data"]) < 0.01 * ramp.nbytes


def _sphere(segments: int) -> Mesh:
    import trimesh

    ball = trimesh.creation.uv_sphere(0.05, [segments, segments])
    return Mesh("ball", ball.vertices.astype(np.float32), ball.faces.astype(np.int32))


def test_a_mesh_is_simplified_to_a_bound_and_keeps_its_shape():
    vertices, faces = simplified(_sphere(60), 2000)
    assert 700 < len(faces) <= 2000
    # Cells are a twentieth of the diameter or less, and a vertex is the mean of those in one.
    np.testing.assert_allclose(np.linalg.norm(vertices, axis=1), 0.05, atol=0.05 / 20)
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
    assert volume == pytest.approx(4.0 / 3.0 * np.pi * 0.05**3, rel=0.06)


def test_a_small_mesh_stays_as_it_is():
    mesh = _sphere(12)
    vertices, faces = simplified(mesh, 3000)
    np.testing.assert_array_equal(vertices[faces], mesh.vertices.astype(np.float64)[mesh.faces])
