"""The maps of a view, in the order in which a page lists them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from ...annotate.vessel_parts import PART_BITS
from ...core.images import id_colour
from ...render.frame import EYES, PARTS, Eye, Geometry, Layers, Refraction
from ..format import layout
from ..format.exr import read_exr, stacked
from ..format.map_files import read_ids
from ..reader import StoredView
from .map_numbers import (
    LabelMap,
    colour_map,
    coordinates_map,
    depth_map,
    disparity_map,
    flow_map,
    ids_map,
    unit_map,
)
from .sensor_maps import absent_sensor_files, difference_map, sensor_maps

#: Names and colours of classes by their code: the states of `annotate.stereo`, and how refracted rays end.
_PAIR = (
    ("both cameras see it", "#46c864"),
    ("behind a surface", "#e65046"),
    ("outside", "#fabe32"),
    ("none", "#2d2d30"),
)
_ENDS = (("surroundings", "#4696eb"), ("surface", "#46c864"), ("lost", "#e65046"))
_PART_COLOURS = ("#7896b4", "#46c8c8", "#4696eb", "#f5822d", "#fabe32")
_LAYER_COLOURS = ("#8c8c8c", "#46c8c8", "#4696eb", "#b969e1", "#fabe32", "#f5822d")


def view_maps(view: StoredView, following: StoredView | None) -> tuple[list[LabelMap], dict[str, str]]:
    """Return the maps of a view, and what its data set was made without.

    Parameters
    ----------
    view : StoredView
        The view.
    following : StoredView, optional
        Another view of the scene, for optical flow.

    Returns
    -------
    maps : list of LabelMap
        In the order in which a page lists them.
    absent : dict of str to str
        Kinds of files that the view lacks, with what they hold.

    Raises
    ------
    InputError
        For a missing or damaged file that every view has.
    """
    found, absent = [], {}
    for eye in EYES:
        if eye == "right" and not (view.folder / layout.RIGHT_GEOMETRY).is_file():
            absent["right-labels"] = "the right camera's depth, normals, ids and boxes"
            continue
        found += _surfaces(view.geometry(eye), eye)
    found += _numbers_of_view(view)
    for path, kind, purpose, maps in _REQUESTED:
        if (view.folder / path).is_file():
            found += maps(view)
        else:
            absent[kind] = purpose
    found += sensor_maps(view)
    absent |= absent_sensor_files(view)
    if following is not None:
        found.append(flow_map("left/flow", "optical flow to the next view", "motion", view.flow(following)))
    return found, absent


def converted_maps(view: StoredView, classes: Sequence[str]) -> list[LabelMap]:
    """Return the maps that a view of a converted data set has.

    Parameters
    ----------
    view : StoredView
        The view.
    classes : sequence of str
        Names of the values of ``classes.png``.

    Raises
    ------
    InputError
        For a damaged file.
    """
    return [*_converted_surfaces(view), *_converted_depths(view), *_pixel_classes(view, classes)]


def _converted_surfaces(view: StoredView) -> Iterator[LabelMap]:
    if (view.folder / layout.INSTANCES).is_file():
        yield ids_map("left/ids", "instance ids", "surfaces", view.instances())
    path = view.folder / layout.GEOMETRY
    channels = read_exr(path) if path.is_file() else {}
    if "N.X" in channels:
        normals = np.rint(127.0 * np.nan_to_num(stacked(channels, "N.XYZ", path).astype(np.float32))).astype(np.int8)
        yield LabelMap("left/normals", "normals", "surfaces", "vector", normals, step=1.0 / 127.0)


def _converted_depths(view: StoredView) -> Iterator[LabelMap]:
    record = view.camera_record()
    nothing = np.zeros((record.height, record.width), np.uint16)
    ids = view.instances() if (view.folder / layout.INSTANCES).is_file() else nothing
    if view.has_depth():
        yield depth_map("left/depth", "depth", "surfaces", view.depth(), ids)
        if record.K is not None and record.baseline is not None:
            yield disparity_map("left/disparity", "disparity", np.nan_to_num(view.disparity()))
    if (view.folder / layout.MEASURED_DEPTH).is_file():
        yield depth_map("left/sensor-depth", "depth of the sensor", "depth camera", view.sensor_depth(), ids)
        if view.has_depth():
            yield difference_map(view.sensor_depth(), view.depth())


def _pixel_classes(view: StoredView, classes: Sequence[str]) -> Iterator[LabelMap]:
    if not (view.folder / layout.CLASSES).is_file():
        return
    codes = view.classes()
    names = []
    for number in range(int(codes.max(initial=0)) + 1):
        name = classes[number] if number < len(classes) else f"class {number}"
        names.append((name, "#{:02x}{:02x}{:02x}".format(*id_colour(number)) if number else "#2d2d30"))
    yield LabelMap("left/classes", "classes", "surfaces", "class", codes, none=None, names=tuple(names))


def _surfaces(geometry: Geometry, eye: Eye) -> Iterator[LabelMap]:
    group = "surfaces" if eye == "left" else "right camera"
    yield ids_map(f"{eye}/ids", "instance ids", group, geometry.id)
    yield depth_map(f"{eye}/depth", "depth", group, geometry.Z, geometry.id)
    normals = np.rint(127.0 * geometry.normal).astype(np.int8)
    yield LabelMap(f"{eye}/normals", "normals", group, "vector", normals, step=1.0 / 127.0)
    yield ids_map(f"{eye}/background-ids", "ids behind glass", group, geometry.background_id)
    yield depth_map(
        f"{eye}/background-depth", "depth behind glass", group, geometry.background_Z, geometry.background_id
    )
    yield colour_map(f"{eye}/transmittance", "transmittance", group, geometry.transmittance)


def _numbers_of_view(view: StoredView) -> Iterator[LabelMap]:
    yield disparity_map("left/disparity", "disparity", view.disparity())
    yield disparity_map("left/background-disparity", "disparity behind glass", view.disparity(background=True))
    yield unit_map("left/heatmap", "heatmap", "objects", view.heatmap())
    yield coordinates_map("left/coordinates", "object coordinates", view.object_coordinates())


def _pair_maps(view: StoredView) -> Iterator[LabelMap]:
    yield disparity_map("right/disparity", "disparity", view.disparity("right"))
    yield disparity_map(
        "right/background-disparity", "disparity behind glass", view.disparity("right", background=True)
    )
    for eye in EYES:
        seen = view.pair_visibility(eye)
        for name, title, codes in (
            ("pair", "seen by both", seen.first),
            ("background-pair", "... behind glass", seen.background),
        ):
            yield LabelMap(f"{eye}/{name}", title, "pair", "class", codes, none=None, names=_PAIR)


def _layer_maps(view: StoredView) -> Iterator[LabelMap]:
    layers = view.layers()
    count = np.minimum(layers.count, 255).astype(np.uint8)
    most = max(int(count.max()), 1)
    yield LabelMap("left/layer-count", "surfaces on the ray", "layers", "number", count, high=most)
    for number in range(int((layers.id > 0).any(axis=(1, 2)).sum())):
        yield from _layer(layers, number)
    yield coordinates_map("left/back-coordinates", "coordinates, back wall", view.object_coordinates(back=True))


def _layer(layers: Layers, number: int) -> Iterator[LabelMap]:
    title = f"surface {number + 1}"
    yield ids_map(f"left/layer-{number}-ids", f"{title}: ids", "layers", layers.id[number])
    yield depth_map(f"left/layer-{number}-depth", f"{title}: depth", "layers", layers.Z[number], layers.id[number])
    codes = np.where(layers.id[number] > 0, layers.part[number] + 1, 0).astype(np.uint8)
    names = (("none", "#2d2d30"), *zip((part.replace("_", " ") for part in PARTS), _LAYER_COLOURS, strict=True))
    yield LabelMap(f"left/layer-{number}-part", f"{title}: part", "layers", "class", codes, names=names)


def _part_maps(view: StoredView) -> Iterator[LabelMap]:
    bits = read_ids(view.folder / layout.VESSEL_PARTS).astype(np.uint8)
    names = zip((part.replace("_", " ") for part in PART_BITS), _PART_COLOURS, strict=True)
    yield LabelMap("left/vessel-parts", "parts of vessels", "objects", "bits", bits, names=tuple(names))


def _refraction_maps(view: StoredView) -> Iterator[LabelMap]:
    rays: Refraction = view.refraction()
    yield LabelMap("left/ends", "ends of refracted rays", "refraction", "class", rays.state, none=None, names=_ENDS)
    yield ids_map("left/refracted-ids", "ids at their ends", "refraction", rays.id)
    yield depth_map("left/refracted-depth", "depth at their ends", "refraction", rays.Z, rays.id)
    yield flow_map("left/refractive-flow", "refractive flow", "refraction", rays.flow)
    bounces = np.minimum(rays.bounces, 255).astype(np.uint8)
    yield LabelMap("left/bounces", "interfaces", "refraction", "number", bounces, high=max(int(bounces.max()), 1))
    yield colour_map("left/refracted-transmittance", "transmittance", "refraction", rays.transmittance)


def _matte_maps(view: StoredView) -> Iterator[LabelMap]:
    mattes = view.mattes()
    for number, coverage, passed in zip(mattes.ids, mattes.coverage, mattes.transmittance, strict=True):
        if coverage.any():
            yield unit_map(f"left/coverage-{number}", f"coverage of {number}", "mattes", coverage)
            if (passed[coverage > 0.0] > 0.0).any():
                yield colour_map(f"left/passes-{number}", "... what it passes on", "mattes", passed)


#: Files on request: the file, the kind of `--write`, what it holds, and its maps.
_REQUESTED: tuple[tuple[str, str, str, Callable[[StoredView], Iterator[LabelMap]]], ...] = (
    (layout.DISPARITY, "disparity", "the right camera's disparity, and what both cameras see", _pair_maps),
    (layout.VESSEL_PARTS, "vessel-parts", "glass, wet wall, liquid surface, content and opening", _part_maps),
    (layout.LAYERS, "layers", "every surface along the rays", _layer_maps),
    (layout.REFRACTION, "refraction", "where refracted rays end", _refraction_maps),
    (layout.MATTES, "mattes", "soft edges, and what each object lets through", _matte_maps),
)
