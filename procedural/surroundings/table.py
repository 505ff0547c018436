"""The table, drawn at random: a board with rounded edges."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from ...core.mesh import Mesh
from ...core.model import Model
from ...core.units import LENGTH, Length
from ...core.user_text import UserPath
from ..description.surroundings import Table
from ..materials.draw import draw_table_material
from ..materials.surface_files import SurfaceFiles
from ..props.blocks import rounded_box
from ..props.revolution import revolve, rounded

#: Thickness of table tops [m]: boards from the joiner are 20-50 mm.
THICKNESS = (0.02, 0.05)
#: Radius of the edge [m]: from an edge broken with sandpaper to a half circle on the thinnest board.
EDGE_RADIUS = (0.002, 0.010)


class TableSettings(Model):
    """Sizes and shape of the table."""

    smallest: Length = Field(default=0.9, ge=0.3, le=5.0, description="Least side or diameter of the table [m]")
    largest: Length = Field(default=1.8, ge=0.3, le=5.0, description="Greatest side or diameter of the table [m]")
    texture_dir: UserPath | None = Field(
        default=None, description="Folder of pictures for the table's top alone, apart from those of the props"
    )
    texture_size: Annotated[float, Field(ge=0.01, le=10.0), LENGTH] | None = Field(
        default=None,
        description="Width of one repeat of the picture on the table, 0.01 to 10 [m], its height in the "
        "picture's shape; by default a square of 0.3 to 1 m",
    )
    round_share: float = Field(default=0.25, ge=0.0, le=1.0, description="Probability that the table is round")

    @model_validator(mode="after")
    def _in_order(self) -> TableSettings:
        if self.smallest > self.largest:
            raise ValueError(f"smallest: expected at most largest ({self.largest} m), found {self.smallest} m")
        return self


def draw_table(
    rng: np.random.Generator,
    settings: TableSettings,
    texture_files: Sequence[SurfaceFiles] = (),
) -> Table:
    """Draw the table: its top is flat and exactly at z = 0, its middle on the z axis.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of all draws.
    settings : TableSettings
        Sizes and the probability of a round table.
    texture_files : sequence of SurfaceFiles
        Pictures for the top, with their maps; without them the material is procedural.

    Returns
    -------
    Table
        Texture coordinates are in metres; on the top they are (x, y).
    """
    long_side = rng.uniform(settings.smallest, settings.largest)
    short_side = rng.uniform(settings.smallest, long_side)
    thickness, radius = rng.uniform(*THICKNESS), rng.uniform(*EDGE_RADIUS)
    round_table = rng.random() < settings.round_share
    size = (long_side, long_side if round_table else short_side, thickness)
    mesh = _round_board(long_side, thickness, radius) if round_table else _board(size, radius)
    return Table(mesh=mesh, material=draw_table_material(rng, texture_files, settings.texture_size), size=size)


def outline(table: Table) -> np.ndarray:
    """Return the convex outline of the flat part of the top, (k, 2) float64, counter-clockwise [m]."""
    from scipy.spatial import ConvexHull  # here, as it takes a third of a second to load

    flat = table.mesh.vertices[table.mesh.vertices[:, 2] == 0.0, :2].astype(np.float64)
    return flat[ConvexHull(flat).vertices]


def _board(size: tuple[float, float, float], radius: float) -> Mesh:
    """Return a rectangular board, long side along x."""
    mesh, unit = rounded_box("table", size, radius)
    assert mesh.uv is not None
    return _top_at_zero(mesh, mesh.uv * unit)


def _round_board(diameter: float, thickness: float, radius: float) -> Mesh:
    """Return a round board; texture coordinates continue radially over the edge."""
    corners = [(0.0, 0.0), (diameter / 2, 0.0), (diameter / 2, thickness), (0.0, thickness)]
    mesh, unit = revolve("table", rounded(corners, [radius, radius]))
    assert mesh.uv is not None
    angle = 2 * np.pi * mesh.uv[:, 0]
    from_middle = (mesh.uv[:, 1].max() - mesh.uv[:, 1]) * unit
    return _top_at_zero(mesh, np.stack([np.cos(angle), np.sin(angle)], 1) * from_middle[:, None])


def _top_at_zero(mesh: Mesh, uv: np.ndarray) -> Mesh:
    vertices = mesh.vertices.astype(np.float64)
    # Subtracting the exact value of the top's vertices gives exactly 0.
    vertices[:, 2] -= vertices[:, 2].max()
    return Mesh(mesh.name, vertices, mesh.faces, mesh.normals, uv)
