"""Draw a vessel of the user: which file, what it is made of, and how full it is."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...core.errors import InputError
from ...core.mesh import Mesh
from ...core.units import volume_text
from ..cavities.interior import interior_of, most_volume
from ..description.bodies import MeshVessel
from ..description.mesh_vessel import mesh_vessel, refilled_mesh
from ..optics.draw import NO_MEDIA
from ..optics.medium import Medium
from ..vessels.amounts import fill_fractions, fill_volumes
from ..vessels.media import draw_media
from ..vessels.settings import VesselSettings
from .files import VesselFile
from .shape import own_shape

#: Family whose glasses a vessel from a file is drawn from, where neither settings nor file say it: all of them.
_FAMILY = "freeform"


def draw_own_vessel(
    rng: np.random.Generator,
    media_rng: np.random.Generator,
    settings: VesselSettings,
    file: VesselFile,
    *,
    id: int,
    name: str,
    own: Mapping[str, Medium] = NO_MEDIA,
) -> MeshVessel:
    """Draw a vessel from a file at the origin of its own frame.

    Parameters
    ----------
    rng, media_rng : numpy.random.Generator
        The streams of the vessel and of its media.
    settings : VesselSettings
        Glasses, liquids, filling and roughness; `vessels.glasses` takes precedence over the file's glass.
    file : VesselFile
        The file.
    id, name : int, str
        Instance id and name in the scene.
    own : mapping of str to Medium
        Own media by name.

    Raises
    ------
    InputError
        Where the file cannot be used, or the vessel cannot hold the volume of the settings.
    """
    shape = own_shape(file, settings)
    glass, liquid = draw_media(media_rng, settings, _FAMILY, own)
    if settings.glasses is None and shape.glass is not None:
        glass = shape.glass
    filled, fill = rng.random() < settings.fill_probability, rng.uniform(*fill_fractions(settings.fill))
    rough, alpha = rng.random() < settings.rough_probability, rng.uniform(*settings.roughness)
    inside = interior_of(shape.solid)
    solid = Mesh(f"{name}-solid", shape.solid.vertices, shape.solid.faces, shape.solid.normals)
    vessel = mesh_vessel(
        solid,
        glass,
        id=id,
        name=name,
        category=file.category,
        roughness=alpha if rough else 0.0,
        symmetric=shape.symmetric,
        origin=shape.origin,
        inside=inside,
    )
    if not filled or not inside.hollows:
        return vessel
    volumes, most = fill_volumes(settings.fill), most_volume(inside)
    if volumes is None:
        return refilled_mesh(vessel, liquid, min(fill * inside.volume, most) / inside.volume, inside)
    volume = float(rng.uniform(*volumes))
    if volume > most:
        limit = f"at most {volume_text(most)} in {file.name}, which holds {volume_text(inside.volume)} up to its brim"
        raise InputError("vessels.fill", limit, volume_text(volume))
    return refilled_mesh(vessel, liquid, volume / inside.volume, inside)
