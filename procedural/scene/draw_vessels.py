"""Draw the vessels of a scene, each with its parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...core.mesh import Mesh, joined
from ...core.randomness import stream
from ..description.edits import in_world
from ..description.scene import FIRST_OBJECT_ID, GlassBody, SceneObject
from ..own_vessels.draw import draw_own_vessel
from ..shaped_vessels.draw import SHAPERS, draw_shaped_vessel
from ..vessel_parts.draw import LYING, draw_parts
from ..vessel_parts.host import host_of_revolution, host_of_shape
from ..vessels.draw import draw_vessel
from ..vessels.media import draw_media
from ..vessels.settings import VesselSettings
from ..vessels.sizes import draw_size
from .asset_files import AssetFiles
from .solids import body_mesh

#: Parts by the name of the vessel that they go with; their poses are in its frame.
Parts = Mapping[str, tuple[SceneObject, ...]]
#: How often an empty vessel that does not stand by itself is held by something [1]; filled ones always are.
HELD = 0.5


def draw_vessels(
    settings: VesselSettings, seed: int, scene_id: int, count: int, files: AssetFiles
) -> tuple[list[GlassBody], Parts]:
    """Return the vessels of a scene at the origin, and their parts.

    Raises
    ------
    InputError
        As `draw_vessel` and `draw_own_vessel`.
    """
    drawn = [_vessel(settings, seed, scene_id, number, files) for number in range(count)]
    return [body for body, _ in drawn], {body.name: parts for body, parts in drawn}


def _vessel(
    settings: VesselSettings, seed: int, scene_id: int, number: int, files: AssetFiles
) -> tuple[GlassBody, tuple[SceneObject, ...]]:
    place, media = f"vessels/{number}", stream(seed, scene_id, f"media/{number}")
    id, name = FIRST_OBJECT_ID + number, f"vessel-{number:02d}"
    if files.vessels:
        choice = stream(seed, scene_id, f"vessel-file/{number}")
        file = files.vessels[int(choice.integers(len(files.vessels)))]
        if choice.random() < settings.file_probability:
            rng = stream(seed, scene_id, place)
            return draw_own_vessel(rng, media, settings, file, id=id, name=name, own=files.media), ()
    # The family is the first that a vessel's stream gives; the wall's material follows it.
    category, *_ = draw_size(stream(seed, scene_id, place), settings)
    glass, liquid = draw_media(media, settings, category, files.media)
    rng = stream(seed, scene_id, place)
    if category in SHAPERS:
        body, made = draw_shaped_vessel(rng, settings, id=id, name=name, glass=glass, liquid_medium=liquid)
        host = host_of_shape(body, made)
    else:
        body = draw_vessel(rng, settings, id=id, name=name, glass=glass, liquid_medium=liquid)
        host = host_of_revolution(body)
    choice = stream(seed, scene_id, f"parts/{number}")
    held = choice.random() < HELD or body.liquid is not None
    return body, draw_parts(choice, settings, host, stands=held)


def lies(body: SceneObject, parts: Sequence[SceneObject]) -> bool:
    """Return whether a vessel does not stand: its bottom is round, and nothing holds it."""
    return body.category in LYING and not any(part.category in ("rack", "ring") for part in parts)


def group_mesh(body: SceneObject, parts: Sequence[SceneObject]) -> Mesh:
    """Return the surfaces of an object and its parts, in the object's frame."""
    own = body_mesh(body)
    if not parts:
        return own
    solids = [in_world(body_mesh(part), part.world_T_object) for part in parts]
    return joined(
        [own, *[Mesh(body.name, solid.points.astype(np.float32), solid.faces) for solid in solids]], body.name
    )
