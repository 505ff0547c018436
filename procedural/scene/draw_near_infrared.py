"""Draws how the materials of a scene reflect the light of its depth camera."""

from __future__ import annotations

from ...core.randomness import stream
from ..description.material import OpaqueMaterial
from ..description.scene import Prop, PropPart, Scene
from ..materials.near_infrared import near_infrared


def with_near_infrared(scene: Scene, carbon: float | None = None) -> Scene:
    """Return a scene whose table and props have reflectances in the near infrared, drawn by what they are made of.

    Each has a random stream of its own, so nothing else in a scene changes. Parts of one object that have the same
    name are of the same stuff. Opaque surfaces of vessels, such as those of turbid drinks, keep the middle.

    Parameters
    ----------
    scene : Scene
        The scene; materials that state their reflectance keep it.
    carbon : float, optional
        Probability that what is grey or black is so by carbon black, in place of that of each kind.
    """

    def drawn(material: OpaqueMaterial, owner: str) -> OpaqueMaterial:
        rng = stream(scene.seed, scene.scene_id, f"sensors/infrared/{owner}/{material.name}")
        return material.model_copy(update={"near_infrared": near_infrared(material, rng, carbon)})

    def of_part(part: PropPart, owner: str) -> PropPart:
        return part.model_copy(update={"material": drawn(part.material, owner)})

    def of_prop(prop: Prop) -> Prop:
        owner = str(prop.id)
        parts = tuple(of_part(part, owner) for part in prop.parts)
        return prop.model_copy(update={"material": drawn(prop.material, owner), "parts": parts})

    table = scene.table.model_copy(update={"material": drawn(scene.table.material, "table")})
    props = tuple(of_prop(prop) for prop in scene.props)
    return scene.model_copy(update={"table": table, "props": props})
