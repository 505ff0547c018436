"""Props of several materials, and colours of vertices, as the renderer has them."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.mesh import Mesh
from glassware.procedural.description.material import OpaqueMaterial, UniformTexture, VertexColours
from glassware.procedural.description.scene import Prop, PropPart
from glassware.procedural.primitives.bodies import box_mesh
from glassware.procedural.primitives.scenes import camera, scene
from glassware.render.labels.layers import _materials_by_row
from glassware.render.scene.bodies import scene_bodies
from glassware.render.scene.loaded_scene import load
from glassware.render.scene.vertex_colours import coloured


def _prop(mesh: Mesh, parts: tuple[PropPart, ...] = (), material: OpaqueMaterial | None = None) -> Prop:
    pose = np.eye(4)
    pose[2, 3] = 0.06
    return Prop(
        id=2,
        name="prop",
        category="box",
        mesh=mesh,
        material=material or parts[0].material,
        parts=parts,
        size=(0.1, 0.1, 0.1),
        world_T_object=pose,
    )


def test_the_parts_of_a_prop_are_shapes_of_one_instance_with_materials_of_their_own(backend: str) -> None:
    mesh = box_mesh((0.1, 0.1, 0.1), "prop")
    look = [OpaqueMaterial(name=name, base_colour=UniformTexture(colour=(1, 0, 0)), roughness=0.5) for name in "ab"]
    counts = (4, len(mesh.faces) - 4)
    parts = tuple(PropPart(faces=count, material=one) for count, one in zip(counts, look, strict=True))
    described = scene([], [camera((0.3, -0.3, 0.3))], props=[_prop(mesh, parts)])
    bodies = scene_bodies(described, False)[1:]
    assert [(body.surface.instance, body.surface.object, body.surface.piece) for body in bodies] == [
        (2, 0, 0),
        (2, 0, 1),
    ]
    corners = np.concatenate([body.mesh.vertices[body.mesh.faces] for body in bodies])
    assert np.array_equal(corners, mesh.vertices[mesh.faces])
    loaded = load(described)
    rows = [row for row, piece in enumerate(np.array(loaded.surfaces.instance)) if piece == 2]
    behind = np.array(_materials_by_row(loaded)[1])[rows]
    assert sorted(behind.tolist()) == [2, 3]  # after air and the table's


@pytest.mark.parametrize("seed", range(3))
def test_the_texture_of_coloured_vertices_is_linear_between_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mesh = box_mesh((0.1, 0.1, 0.1), "prop")
    # One hue: then no texel leaves the range of the corners' colours.
    colours = rng.random((len(mesh.vertices), 1)) * [[0.9, 0.5, 0.2]]
    mesh = Mesh("prop", mesh.vertices, mesh.faces, mesh.normals, None, colours)
    found, pixels = coloured(mesh)
    assert found.uv is not None
    assert mesh.colours is not None
    height, width = pixels.shape[:2]
    for face in range(len(mesh.faces)):
        weights = rng.dirichlet(np.ones(3))
        place = weights @ found.vertices[found.faces[face]].astype(float)
        u, v = weights @ found.uv[found.faces[face]].astype(float) * [width, height] - 0.5
        column, row = int(np.clip(u, 0, width - 2)), int(np.clip(v, 0, height - 2))
        a, b = u - column, v - row
        cell = pixels[row : row + 2, column : column + 2].astype(float)
        shown = np.einsum("i,j,ijk->k", [1 - b, b], [1 - a, a], cell)
        corners = mesh.vertices[mesh.faces[face]].astype(float)
        expected = np.linalg.lstsq(np.concatenate([corners.T, np.ones((1, 3))]), np.append(place, 1.0), rcond=None)[0]
        assert np.allclose(shown, expected @ mesh.colours[mesh.faces[face]].astype(float), atol=1e-4)


def test_a_prop_of_coloured_vertices_loads(backend: str) -> None:
    mesh = box_mesh((0.1, 0.1, 0.1), "prop")
    mesh = Mesh(
        "prop", mesh.vertices, mesh.faces, mesh.normals, None, np.tile([[0.2, 0.4, 0.6]], (len(mesh.vertices), 1))
    )
    material = OpaqueMaterial(name="colours", base_colour=VertexColours(), roughness=0.5)
    described = scene([], [camera((0.3, -0.3, 0.3))], props=[_prop(mesh, material=material)])
    assert scene_bodies(described, False)[1].mesh.uv is not None
