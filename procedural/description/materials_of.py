"""All materials of a scene in one list, so that labels can name them by number."""

from __future__ import annotations

from ..optics.medium import AIR, Medium
from .material import OpaqueMaterial
from .scene import Prop, Scene, SceneObject


def materials_of(scene: Scene) -> tuple[Medium | OpaqueMaterial, ...]:
    """Return what a scene is made of, each once: air, the table's material, then those of the objects by their ids.

    A glass body brings its glass and then its liquid. The order depends on the description alone.
    """
    found: list[Medium | OpaqueMaterial] = [AIR]
    for material in [scene.table.material, *(part for item in scene.objects for part in _materials(item))]:
        if material not in found:
            found.append(material)
    return tuple(found)


def _materials(item: SceneObject) -> list[Medium | OpaqueMaterial]:
    if isinstance(item, Prop):
        return [item.material]
    media = [medium for interface in item.interfaces for medium in (interface.back, interface.front)]
    return [item.glass, *([item.liquid.medium] if item.liquid else []), *media]
