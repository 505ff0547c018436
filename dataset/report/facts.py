"""What a page needs to know of one scene, from its files."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

import numpy as np

from ...annotate.projection import inverse_pose
from ...core.assets import Asset
from ...core.errors import InputError
from ...procedural.description.rest import Rest
from ...procedural.optics.dyes import DYES
from ...procedural.optics.medium import Medium
from ..depth_cameras.errors import DepthErrors
from ..format import layout
from ..format.checksums import read_checksums
from ..format.objects_file import ObjectRecord, ObjectsFile
from ..format.scene_outline import SceneOutline
from ..format.views_table import SceneViews, ViewRow, scene_views
from ..reader import StoredScene

#: How the catalogue begins the names of solutions.
_AMOUNT = re.compile(r"^[0-9]+ % ")


@dataclass(frozen=True)
class SceneFacts:
    """The numbers and names of one scene."""

    numbers: Mapping[str, Sequence[float]]  #: by the keys of `QUANTITIES`, SI units
    names: Mapping[str, list[str]]  #: by the keys of `TOPICS`
    sizes: Mapping[str, int]  #: bytes by kind of file, such as ``left.png`` or ``meshes``
    assets: tuple[Asset, ...]
    meshes: tuple[str, ...]  #: file of each object that comes from a mesh file
    rest: Rest | None
    redrawn: int  #: contents of vessels that did not fit and were drawn again
    placed_again: int  #: how often objects did not fit on the table and were placed again
    turbid: int  #: vessels whose liquid is turbid
    layered: int  #: vessels with more than one liquid


def scene_facts(scene: StoredScene) -> SceneFacts:
    """Return what a page shows of a scene; InputError where a file of it is missing or damaged."""
    objects, outline = scene.objects(), scene.outline()
    views = scene_views(scene.folder.parent.parent, scene.scene_id)
    bodies = [item for item in objects.objects if _is_vessel(item)]
    sizes = _sizes(scene)
    return SceneFacts(
        numbers=_gathered(_numbers(scene, objects, outline, views)) | {"bytes": [sum(sizes.values())]},
        names=_gathered(_names(objects, outline)),
        sizes=sizes,
        assets=views.assets,
        meshes=tuple(item.origin.file for item in objects.objects if item.origin is not None),
        rest=views.rest,
        redrawn=outline.redrawn,
        placed_again=outline.placed_again,
        turbid=sum(any(liquid.turbid for liquid in _liquids(item)) for item in bodies),
        layered=sum(bool(item.layers) for item in bodies),
    )


def _gathered(pairs: Iterable[tuple[str, object]]) -> dict[str, list]:
    found = defaultdict(list)
    for key, value in pairs:
        found[key].append(value)
    return dict(found)


def _is_part(item: ObjectRecord) -> bool:
    return item.part_of is not None or item.within is not None


def _is_vessel(item: ObjectRecord) -> bool:
    return item.material.kind == "glass" and not _is_part(item)


def _liquids(item: ObjectRecord) -> tuple:
    return () if item.liquid is None else (item.liquid, *item.layers)


def liquid_kind(medium: Medium) -> str:
    """Return what a liquid is without amounts, such as ``sugar solution, dyed``: each vessel has amounts of its own."""
    solvent, _, dyes = medium.name.rpartition(" with ")
    dyed = solvent and any(absorber.spectrum in DYES and absorber.spectrum in dyes for absorber in medium.absorbers)
    return _AMOUNT.sub("", f"{solvent}, dyed" if dyed else medium.name)


def _numbers(
    scene: StoredScene, objects: ObjectsFile, outline: SceneOutline, views: SceneViews
) -> Iterator[tuple[str, float]]:
    """Yield key and value of each number of a scene."""
    every = objects.objects
    vessels, parts = [item for item in every if _is_vessel(item)], [item for item in every if _is_part(item)]
    props = [item for item in every if not _is_vessel(item) and not _is_part(item)]
    yield "objects", len(vessels) + len(props)
    yield "vessels", len(vessels)
    yield "props", len(props)
    yield "parts", len(parts)
    yield "views", len(views.views)
    for item in vessels:
        yield from _vessel_numbers(item)
    for item in props:
        yield "longest", max(item.size)
        if item.mechanics is not None:
            yield "prop_mass", item.mechanics.whole.mass
    yield from _light_numbers(outline, views)
    yield from _view_numbers(scene, objects, outline, views)


def _vessel_numbers(item: ObjectRecord) -> Iterator[tuple[str, float]]:
    yield "height", item.size[2]
    yield "width", max(item.size[:2])
    if item.material.kind == "glass":
        yield "glass_index", item.material.medium.eta
        yield "roughness", item.material.roughness
    if item.volumes is not None and item.volumes.brimful is not None:
        yield "brimful", item.volumes.brimful
    liquids = _liquids(item)
    for liquid in liquids:
        if not liquid.turbid:  # no light travels in it
            yield "liquid_index", liquid.medium.eta
    if liquids:
        yield "fill", sum(liquid.fill for liquid in liquids)
        yield "liquid_volume", sum(liquid.volume for liquid in liquids)
    if item.mechanics is not None:
        yield "vessel_mass", item.mechanics.whole.mass


def _light_numbers(outline: SceneOutline, views: SceneViews) -> Iterator[tuple[str, float]]:
    yield "exposure", outline.cameras[0].exposure
    if views.photometry is not None:
        yield "illuminance", views.photometry.illuminance
        for lamp in views.photometry.lamps:
            yield "lamp_flux", lamp.flux


def _view_numbers(
    scene: StoredScene, objects: ObjectsFile, outline: SceneOutline, views: SceneViews
) -> Iterator[tuple[str, float]]:
    """Yield the numbers of views. Depths follow from poses, so that the masks in ``labels.json`` need not be read."""
    centres = np.array([item.world_T_object[:, 3] for item in objects.objects]).reshape(-1, 4)
    ids = tuple(item.id for item in objects.objects)
    for row in views.views:
        if row.view >= len(outline.cameras) or row.object_ids != ids:
            found = f"view {row.view} of the objects {row.object_ids}"
            raise InputError(scene.folder / layout.SCENE_VIEWS, f"views of the scene's objects {ids}", found)
        depths = centres @ inverse_pose(outline.cameras[row.view].world_T_camera)[2]
        yield "in_view", row.objects_in_view
        for depth, visible, through in zip(depths, row.visible_fractions, row.seen_through_fractions, strict=True):
            if visible is not None and through is not None:  # null where the object is out of the frame
                yield from (("depth", float(depth)), ("visible", visible), ("seen_through", through))
        yield from (("spp", spp) for spp in (row.spp_left, row.spp_right) if spp is not None)
        yield from (("noise", noise) for noise in (row.noise_left, row.noise_right) if noise is not None)
        bodies = {item.id for item in objects.objects if _is_vessel(item)}
        yield from _sensor_numbers(row, bodies)
        for number, degree in zip(row.object_ids, row.polarisation_degree or (), strict=False):
            if number in bodies and degree is not None:
                yield "polarisation_degree", degree


def _sensor_numbers(row: ViewRow, vessels: set[int]) -> Iterator[tuple[str, float]]:
    """Yield what a depth camera reported of a view: of all pixels, and of each vessel."""
    if row.sensor_measured is None:
        return
    yield "sensor_measured", row.sensor_measured
    for name in DepthErrors._fields:
        values = getattr(row, f"sensor_{name}") or ()
        for number, value in zip(row.object_ids, values, strict=True):
            if number in vessels and value is not None:
                yield f"sensor_{name}", value


def _names(objects: ObjectsFile, outline: SceneOutline) -> Iterator[tuple[str, str]]:
    """Yield topic and name of each thing that is counted by its name."""
    for item in objects.objects:
        if _is_part(item):
            yield "parts_by_kind", item.category
        elif item.material.kind == "glass":
            yield "families", item.category
            yield "walls", item.material.medium.name
            yield from (("liquids", name) for name in {liquid_kind(liquid.medium) for liquid in _liquids(item)})
            yield from (("contents", kind) for kind in {content.kind for content in item.contents})
        else:
            yield "kinds", item.category
            yield "surfaces", item.material.name
    environment = outline.environment
    picture = f": {environment.asset.source}" if environment.kind == "picture" else ""
    yield "surroundings", f"{environment.kind}{picture}"
    yield from (("lamps", light.kind) for light in outline.lights)
    yield "tables", outline.table
    for topic, device in (
        ("depth_cameras", outline.depth_camera),
        ("polarisation_cameras", outline.polarisation_camera),
    ):
        if device is not None:
            yield topic, device
    yield from (("optics", choice) for choice in outline.simplified)
    if outline.sensitivities is not None:
        yield "colour_sensors", outline.sensitivities
    yield from (("prints", kind) for kind in outline.prints or ("none",))


def _sizes(scene: StoredScene) -> dict[str, int]:
    """Return the bytes of a scene's files by kind: their names in a view, their folder, or their name."""
    sizes: dict[str, int] = defaultdict(int)
    for name, file in read_checksums(scene.folder).files.items():
        first, *rest = PurePosixPath(name).parts
        sizes[rest[0] if rest and first.isdigit() else first] += file.size
    return dict(sizes)
