"""The materials of a scene in a list, whose places labels name."""

from __future__ import annotations

from collections.abc import Callable

from ..optics.medium import AIR, Medium
from .bodies import Interface, Prop, SceneObject
from .material import OpaqueMaterial
from .scene import Scene


def materials_of(scene: Scene) -> tuple[Medium | OpaqueMaterial, ...]:
    """Return the materials of a scene, each once: air, the table's, then those of the objects by their ids.

    Labels name them by their place in this list. Of a glass body, the glass comes before the liquid.
    """
    found: list[Medium | OpaqueMaterial] = [AIR]
    for material in [scene.table.material, *(part for item in scene.objects for part in _materials_of_object(item))]:
        if material not in found:
            found.append(material)
    return tuple(found)


def opaque_media(scene: Scene) -> tuple[int, ...]:
    """Return the places in the list of materials of media that no light enters: turbid liquids, and painted glass."""
    return _places_of(scene, lambda part: part.opaque is not None)


def turbid_media(scene: Scene) -> tuple[int, ...]:
    """Return the places in the list of materials of the turbid liquids that wet a wall: that wall faces the glass."""
    return _places_of(scene, lambda part: part.seen_from_back)


def _places_of(scene: Scene, is_opaque: Callable[[Interface], bool]) -> tuple[int, ...]:
    found = [part for body in scene.vessels for part in body.interfaces if is_opaque(part)]
    media = [part.front if part.seen_from_back else part.back for part in found]
    return tuple(number for number, material in enumerate(materials_of(scene)) if material in media)


def _materials_of_object(item: SceneObject) -> list[Medium | OpaqueMaterial]:
    if isinstance(item, Prop):
        return [piece.material for piece in item.pieces]
    media = [medium for interface in item.interfaces for medium in (interface.back, interface.front)]
    return [item.glass, *(liquid.medium for liquid in item.liquids), *media]
