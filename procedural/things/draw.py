"""A prop of a drawn kind: a mesh file, a plain shape, or an everyday thing."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...core.weighted import weights_of
from ..description.scene import GlassBody, Prop
from ..materials.surface_files import SurfaceFiles
from ..placement.resting import lowered, resting_pose, turn_about_z
from ..props.draw import PropSettings, draw_prop
from ..props.kinds import PROP_KINDS
from ..props.mesh_files import MeshFile
from .kinds import KINDS
from .parts import as_prop


def draw_prop_of_kind(
    rng: np.random.Generator,
    kind_rng: np.random.Generator,
    settings: PropSettings,
    *,
    id: int,
    name: str,
    mesh_files: Sequence[MeshFile] = (),
    texture_files: Sequence[SurfaceFiles] = (),
) -> Prop | GlassBody:
    """Draw a prop at the world's origin; placement sets its pose.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of files and plain shapes (`props.draw.draw_prop`), the same whatever the kinds.
    kind_rng : numpy.random.Generator
        Source of the kind, its wear, and everyday things.
    settings, id, name, mesh_files, texture_files
        As in `props.draw.draw_prop`.

    Raises
    ------
    InputError
        If the drawn file is unusable.
    """
    weights = weights_of(settings.kinds)
    names = [kind for kind in PROP_KINDS if kind in weights]
    probability = np.array([weights[kind] for kind in names])
    kind = names[kind_rng.choice(len(names), p=probability / probability.sum())]
    wear = float(kind_rng.uniform(*settings.wear))

    def thing() -> Prop:
        return as_prop(KINDS[kind].draw(kind_rng, wear), kind, id=id, name=name)

    made: Callable[[], Prop] | None = None if kind == "shape" else thing
    files = {"mesh_files": mesh_files, "texture_files": texture_files}
    return draw_prop(rng, settings, id=id, name=name, thing=made, **files)


def prop_pose(prop: Prop, rng: np.random.Generator) -> np.ndarray:
    """Return a pose on z = 0, ``world_T_object`` (4, 4): as the prop is used, or as it comes to rest when dropped.

    Parameters
    ----------
    prop : Prop
        Any; everyday things stand as they are used with the probability of their kind.
    rng : numpy.random.Generator
        Draws which, and the turn about z.
    """
    kind = None if prop.origin is not None else KINDS.get(prop.category)
    if kind is None or rng.random() >= kind.upright:
        return resting_pose(prop.mesh, rng)
    return lowered(turn_about_z(rng.uniform(0.0, 2.0 * np.pi)), prop.mesh)
