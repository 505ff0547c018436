"""The table, drawn at random: a board with rounded edges, a board under a cloth, or a counter with a sink."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from pydantic import Field, field_validator, model_validator

from ...core.mesh import Mesh
from ...core.model import Model, Ordered, Unit
from ...core.units import LENGTH, Length
from ...core.user_text import UserPath
from ...core.weighted import Weighted, check_names, weights_of
from ..description.surroundings import Table
from ..materials.draw import draw_table_material
from ..materials.surface_files import SurfaceFiles
from ..props.blocks import rounded_box
from ..props.revolution import revolve, rounded
from ..tables.forms import hanging_cloth, over_edges, steel_counter
from ..tables.kinds import DEFAULT_TABLES, TABLE_KINDS, TableKind, draw_top
from ..tables.prints import DEFAULT_PRINTS, PRINT_KINDS, PRINTED_TABLES, draw_prints

#: Thickness of table tops [m]: boards from the joiner are 20-50 mm.
THICKNESS = (0.02, 0.05)
#: Radius of the edge [m]: from an edge broken with sandpaper to a half circle on the thinnest board.
EDGE_RADIUS = (0.002, 0.010)


#: Depth of shelves, and the sizes of tables from which on one is a shelf's length [m]: of bookcases and wall shelves
#: that bear glasses, 0.4-0.6 m; narrower ones do not hold a scene's objects.
SHELF_DEPTH = (0.42, 0.6)
#: Kinds that may be round: boards.
ROUND_KINDS = ("wood", "stone", "laminate", "plain")

_Prints = Annotated[int, Field(ge=1, le=16)]


class TableSettings(Model):
    """Kind, sizes and shape of the table."""

    kinds: Weighted = Field(
        default=DEFAULT_TABLES,
        min_length=1,
        description="Kinds to draw from, equally likely or by weights (wood=5); `plain` is a board with a pattern "
        "without relief, and the only one with pictures of `texture_dir`",
        json_schema_extra={"range": f"one or more of {', '.join(TABLE_KINDS)}"},
    )
    wear: Annotated[tuple[Unit, Unit], Ordered] = Field(
        default=(0.1, 0.8), description="Traces of use, scratches, dust and smears: 0 new, 1 worn, within 0 and 1"
    )

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
    print_probability: float = Field(
        default=0.0,
        ge=0.0,
        le=1.0,
        description="Probability of prints on the table, which are no objects; cloths, steel counters and tables with "
        "pictures of a folder have none",
    )
    prints: Annotated[tuple[_Prints, _Prints], Ordered] = Field(
        default=(1, 5),
        description="Fewest and most prints on a table that has some, within 1 and 16; a group of up "
        "to 8 markers counts as one",
    )
    print_kinds: Weighted = Field(
        default=DEFAULT_PRINTS,
        min_length=1,
        description="Kinds of prints to draw from, equally likely or by weights (mat=3); those that do not fit on a "
        "table are not drawn on it",
        json_schema_extra={"range": f"one or more of {', '.join(PRINT_KINDS)}"},
    )

    @field_validator("print_kinds")
    @classmethod
    def _known_prints(cls, kinds: tuple[str, ...]) -> tuple[str, ...]:
        check_names(weights_of(kinds), PRINT_KINDS)
        return kinds

    @field_validator("kinds")
    @classmethod
    def _known_kinds(cls, kinds: tuple[str, ...]) -> tuple[str, ...]:
        check_names(weights_of(kinds), TABLE_KINDS)
        return kinds

    @model_validator(mode="after")
    def _in_order(self) -> TableSettings:
        if self.smallest > self.largest:
            raise ValueError(f"smallest: expected at most largest ({self.largest} m), found {self.smallest} m")
        return self


def draw_table(
    rng: np.random.Generator,
    settings: TableSettings,
    texture_files: Sequence[SurfaceFiles] = (),
    kind_rng: np.random.Generator | None = None,
    print_rng: np.random.Generator | None = None,
) -> Table:
    """Draw the table: its top is flat and exactly at z = 0, its middle on the z axis.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of all draws.
    settings : TableSettings
        Sizes and the probability of a round table.
    texture_files : sequence of SurfaceFiles
        Pictures for the top, with their maps; with them the table is a plain board.
    kind_rng : numpy.random.Generator, optional
        Source of the kind and of all that is its own; without it the table is a plain board.
    print_rng : numpy.random.Generator, optional
        Source of the prints on it; without it there are none.

    Returns
    -------
    Table
        Texture coordinates are in metres; on the top they are (x, y).

    Raises
    ------
    InputError
        Where a print of the settings' kinds finds no place on the table.
    """
    table = _without_prints(rng, settings, texture_files, kind_rng)
    if print_rng is None or texture_files or table.kind not in PRINTED_TABLES:
        return table
    return _with_prints(print_rng, settings, table)


def _with_prints(rng: np.random.Generator, settings: TableSettings, table: Table) -> Table:
    if rng.random() >= settings.print_probability:
        return table
    count = int(rng.integers(settings.prints[0], settings.prints[1] + 1))
    wear, top = float(rng.uniform(*settings.wear)), outline(table)
    prints = draw_prints(rng, weights_of(settings.print_kinds), count, top, wear)
    # The sides of a plain rectangular board have coordinates from their own middles: prints would show there, too.
    mesh = over_edges(table.mesh, table.size) if table.kind == "plain" and len(top) == 4 else table.mesh
    return table.model_copy(update={"mesh": mesh, "prints": prints})


def _without_prints(
    rng: np.random.Generator,
    settings: TableSettings,
    texture_files: Sequence[SurfaceFiles],
    kind_rng: np.random.Generator | None,
) -> Table:
    long_side = rng.uniform(settings.smallest, settings.largest)
    short_side = rng.uniform(settings.smallest, long_side)
    thickness, radius = rng.uniform(*THICKNESS), rng.uniform(*EDGE_RADIUS)
    round_table = rng.random() < settings.round_share
    kind = "plain" if kind_rng is None or texture_files else _kind(kind_rng, settings)
    if kind_rng is not None and kind != "plain":
        round_table = round_table and kind in ROUND_KINDS
        if kind == "shelf":
            short_side = min(short_side, kind_rng.uniform(*SHELF_DEPTH))
        size = (long_side, long_side if round_table else short_side, thickness)
        return _of_kind(kind_rng, settings, kind, size, radius, round_table)
    size = (long_side, long_side if round_table else short_side, thickness)
    mesh = _round_board(long_side, thickness, radius) if round_table else _board(size, radius)
    return Table(mesh=mesh, material=draw_table_material(rng, texture_files, settings.texture_size), size=size)


def _kind(rng: np.random.Generator, settings: TableSettings) -> TableKind:
    weights = weights_of(settings.kinds)
    names: list[TableKind] = [kind for kind in TABLE_KINDS if kind in weights]
    probability = np.array([weights[name] for name in names])
    return names[int(rng.choice(len(names), p=probability / probability.sum()))]


def _of_kind(
    rng: np.random.Generator,
    settings: TableSettings,
    kind: TableKind,
    size: tuple[float, float, float],
    radius: float,
    round_table: bool,
) -> Table:
    """Return a table with a surface at a scale in metres, and a shape of its own where its kind has one."""
    if kind == "cloth":
        mesh, size = hanging_cloth(rng, size[:2])
    elif kind == "steel":
        mesh, size = steel_counter(rng, size[:2])
    else:
        board = _round_board(size[0], size[2], radius) if round_table else _board(size, radius)
        mesh = board if round_table else over_edges(board, size)
    material = draw_top(rng, kind, size[:2], rng.uniform(*settings.wear))
    return Table(mesh=mesh, material=material, size=size, kind=kind)


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
