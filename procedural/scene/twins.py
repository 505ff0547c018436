"""Counterfactual twins: a drawn scene again, with one thing changed and everything else as it was.

Objects, poses, ids and cameras are those of the scene that a twin is made of, so its pictures and labels can be
compared pixel by pixel. What differs is named in `Scene.twin`, with the digest of the other scene.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ...core.errors import InputError
from ...core.randomness import stream
from ..description.bodies import Interface
from ..description.material import OpaqueMaterial
from ..description.pouring import poured
from ..description.scene import GlassBody, MeshVessel, Scene, SceneObject, Vessel
from ..description.twin import Twin, TwinKind
from ..materials.draw import draw_plain_material
from ..optics.medium import AIR
from ..vessels.families import FAMILIES
from ..vessels.media import draw_media
from ..vessels.settings import Category
from .asset_files import AssetFiles
from .draw_surroundings import draw_surroundings
from .scene_file import scene_digest
from .settings import SceneSettings

#: Liquids that are drawn for a vessel before it keeps its own: a strong meniscus may not fit under a brim.
_TRIES = 8
#: Family whose glasses are those of a body that is no vessel of a family: all of them.
_ANY: Category = "freeform"


def twin_of(scene: Scene, kind: TwinKind, settings: SceneSettings, files: AssetFiles) -> Scene:
    """Return the twin of a drawn scene.

    Parameters
    ----------
    scene : Scene
        As it was drawn.
    kind : str
        ``"opaque"``: all glass is painted, each vessel in a colour of its own, and so are the surfaces of liquids.
        ``"empty"``: no vessel holds liquid, ice or bubbles; beads and what stands in it stay. ``"clean-plate"``: no
        vessel, nor what belongs to one; all else stays where it is, also what leaned on one. ``"light"``: other
        surroundings and lamps of the same settings, with the exposure that they need. ``"media"``: other glasses and
        liquids of the same settings; a liquid keeps its volume.
    settings, files : SceneSettings, AssetFiles
        What the scene was drawn from.
    """
    twins: Mapping[TwinKind, Callable[[], tuple[Scene, tuple[str, ...]]]] = {
        "opaque": lambda: (painted(scene), ()),
        "empty": lambda: (emptied(scene), ()),
        "clean-plate": lambda: (scene.without(*[body.name for body in scene.vessels if _is_host(body)]), ()),
        "light": lambda: (_relit(scene, settings, files), ()),
        "media": lambda: _of_other_media(scene, settings, files),
    }
    changed, unchanged = twins[kind]()
    return changed.model_copy(update={"twin": Twin(kind=kind, of=scene_digest(scene), unchanged=unchanged)})


def painted(scene: Scene) -> Scene:
    """Return a scene whose glass bodies are painted: each keeps its shape, and no light enters it.

    Surfaces of liquids that meet the air are opaque as well. A straw that stands in a liquid is seen above it alone.
    """

    def coat(body: GlassBody) -> GlassBody:
        rng = stream(scene.seed, scene.scene_id, f"twin/paint/{body.id}")
        paint, fluid = draw_plain_material(rng), draw_plain_material(rng)
        parts = tuple(_coated(part, paint if part.back == body.glass else fluid) for part in body.interfaces)
        return body.model_copy(update={"interfaces": parts})

    return scene.model_copy(update={"vessels": tuple(coat(body) for body in scene.vessels)})


def _coated(part: Interface, paint: OpaqueMaterial) -> Interface:
    # What meets no air cannot be seen in a painted vessel; a turbid liquid is opaque as it is.
    if part.front != AIR or part.opaque is not None:
        return part
    return part.model_copy(update={"opaque": paint})


def emptied(scene: Scene) -> Scene:
    """Return a scene whose vessels hold no liquid, nor ice and bubbles; beads and what stands in them stay."""
    changed: dict[str, SceneObject] = {}
    for body in scene.vessels:
        melts = any(content.kind == "ice cube" for content in body.contents)
        if isinstance(body, Vessel | MeshVessel) and (body.liquids or melts):
            empty, standing = poured(body, (), scene.objects, melted=True)
            changed |= {item.name: item for item in (empty, *standing)}
    vessels = tuple(changed.get(body.name, body) for body in scene.vessels)
    return scene.model_copy(
        update={"vessels": vessels, "props": tuple(changed.get(prop.name, prop) for prop in scene.props)}
    )


def _is_host(body: GlassBody) -> bool:
    """Return whether a glass body is a thing of its own, not part of another one or standing in it."""
    return body.part_of is None and body.within is None


def _relit(scene: Scene, settings: SceneSettings, files: AssetFiles) -> Scene:
    around = draw_surroundings(
        settings, scene.seed, scene.scene_id, files, scene.table, scene.objects, scene.cameras, "twin/"
    )
    return scene.model_copy(
        update={"environment": around.environment, "lights": around.lights, "cameras": around.cameras}
    )


def _of_other_media(scene: Scene, settings: SceneSettings, files: AssetFiles) -> tuple[Scene, tuple[str, ...]]:
    """Return a scene with other glasses and liquids, and the names of vessels whose liquid stayed."""
    kept = []
    for body in scene.vessels:
        if not isinstance(body, Vessel | MeshVessel) or not _is_host(body):
            continue
        category = body.category if body.category in FAMILIES else _ANY
        rng = stream(scene.seed, scene.scene_id, f"twin/media/{body.id}")
        glass, _ = draw_media(rng, settings.vessels, category, files.media)  # pyright: ignore[reportArgumentType]
        scene = scene.with_glass(body.name, glass)
        if body.liquid is None or body.layers:
            kept += [body.name] if body.layers else []
            continue
        for _ in range(_TRIES):
            _, liquid = draw_media(rng, settings.vessels, category, files.media)  # pyright: ignore[reportArgumentType]
            try:
                scene = scene.with_liquid(body.name, liquid)
                break
            except InputError:
                continue
        else:
            kept.append(body.name)
    return scene, tuple(kept)
