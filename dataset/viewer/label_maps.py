"""The maps of a view as arrays of few bytes, each with what a page has to know to colour and to read it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from ...annotate.vessel_parts import PART_BITS
from ...core.images import depth_colours, id_colour
from ...render.frame import EYES, PARTS, Eye, Geometry, Layers, Refraction
from ..format import layout
from ..format.exr import read_exr, stacked
from ..format.map_files import read_ids
from ..reader import StoredView

#: Steps of a number that is stored in 16 bits [1]: 0 is none.
_STEPS = 65534
#: Finest step of depths [m], of disparities [px] and of flow [px]: far below what a screen shows.
_DEPTH_STEP, _DISPARITY_STEP, _FLOW_STEP = 1e-4, 1.0 / 64.0, 1.0 / 16.0
#: Names and colours of classes by their code: the states of `annotate.stereo`, and how refracted rays end.
_PAIR = (
    ("both cameras see it", "#46c864"),
    ("behind a surface", "#e65046"),
    ("outside", "#fabe32"),
    ("none", "#2d2d30"),
)
_ENDS = (("surroundings", "#4696eb"), ("surface", "#46c864"), ("lost", "#e65046"))
_PART_COLOURS = ("#7896b4", "#46c8c8", "#4696eb", "#f5822d", "#fabe32")
_REASON_COLOURS = ("#46c864", "#e65046", "#fabe32", "#4696eb", "#b969e1", "#f5822d", "#46c8c8", "#c8c8c8")
_LAYER_COLOURS = ("#8c8c8c", "#46c8c8", "#4696eb", "#b969e1", "#fabe32", "#f5822d")


@dataclass(frozen=True, eq=False)
class LabelMap:
    """One map of one eye."""

    name: str  #: unique in a view, such as ``left/depth``
    title: str
    group: str  #: of the list that it stands in
    kind: str  #: ``ids``, ``number``, ``vector``, ``colour``, ``class``, ``bits`` or ``flow``
    values: np.ndarray  #: (H, W) or (H, W, n), of 8 or 16 bits
    step: float = 1.0  #: a stored number times it is the label's
    unit: str = ""
    low: float = 0.0  #: ends of the colours, in the unit
    high: float = 1.0
    none: int | None = 0  #: stored number that means that there is no value
    names: tuple[tuple[str, str], ...] = field(default=())  #: of classes or bits, each with its colour

    @property
    def eye(self) -> str:
        """The camera whose picture it lies on."""
        return self.name.split("/")[0]


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
    if view.depth_camera() is not None:
        found += _sensor_maps(view)
    if following is not None:
        found.append(_flow("left/flow", "optical flow to the next view", "motion", view.flow(following)))
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
        yield _ids("left/ids", "instance ids", "surfaces", view.instances())
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
        yield _depth("left/depth", "depth", "surfaces", view.depth(), ids)
        if record.K is not None and record.baseline is not None:
            yield _disparity("left/disparity", "disparity", np.nan_to_num(view.disparity()))
    if (view.folder / layout.MEASURED_DEPTH).is_file():
        yield _depth("left/sensor-depth", "depth of the sensor", "depth camera", view.sensor_depth(), ids)


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
    yield _ids(f"{eye}/ids", "instance ids", group, geometry.id)
    yield _depth(f"{eye}/depth", "depth", group, geometry.Z, geometry.id)
    normals = np.rint(127.0 * geometry.normal).astype(np.int8)
    yield LabelMap(f"{eye}/normals", "normals", group, "vector", normals, step=1.0 / 127.0)
    yield _ids(f"{eye}/background-ids", "ids behind glass", group, geometry.background_id)
    yield _depth(f"{eye}/background-depth", "depth behind glass", group, geometry.background_Z, geometry.background_id)
    yield _colour(f"{eye}/transmittance", "transmittance", group, geometry.transmittance)


def _numbers_of_view(view: StoredView) -> Iterator[LabelMap]:
    yield _disparity("left/disparity", "disparity", view.disparity())
    yield _disparity("left/background-disparity", "disparity behind glass", view.disparity(background=True))
    yield _unit_number("left/heatmap", "heatmap", "objects", view.heatmap())
    yield _coordinates("left/coordinates", "object coordinates", view.object_coordinates())


def _pair_maps(view: StoredView) -> Iterator[LabelMap]:
    yield _disparity("right/disparity", "disparity", view.disparity("right"))
    yield _disparity("right/background-disparity", "disparity behind glass", view.disparity("right", background=True))
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
    yield _coordinates("left/back-coordinates", "coordinates, back wall", view.object_coordinates(back=True))


def _layer(layers: Layers, number: int) -> Iterator[LabelMap]:
    title = f"surface {number + 1}"
    yield _ids(f"left/layer-{number}-ids", f"{title}: ids", "layers", layers.id[number])
    yield _depth(f"left/layer-{number}-depth", f"{title}: depth", "layers", layers.Z[number], layers.id[number])
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
    yield _ids("left/refracted-ids", "ids at their ends", "refraction", rays.id)
    yield _depth("left/refracted-depth", "depth at their ends", "refraction", rays.Z, rays.id)
    yield _flow("left/refractive-flow", "refractive flow", "refraction", rays.flow)
    bounces = np.minimum(rays.bounces, 255).astype(np.uint8)
    yield LabelMap("left/bounces", "interfaces", "refraction", "number", bounces, high=max(int(bounces.max()), 1))
    yield _colour("left/refracted-transmittance", "transmittance", "refraction", rays.transmittance)


def _sensor_maps(view: StoredView) -> Iterator[LabelMap]:
    """Yield what a depth camera reports in the left picture's pixels, and why it reports nothing."""
    device, Z = view.depth_camera(), np.nan_to_num(view.sensor_depth())
    assert device is not None
    yield _depth(
        "left/sensor-depth", "depth of the sensor", "depth camera", np.where(Z > 0.0, Z, np.inf), view.geometry().id
    )
    codes = view.sensor_valid().astype(np.uint8)
    names = tuple((name, _REASON_COLOURS[i % len(_REASON_COLOURS)]) for i, name in enumerate(device.reasons))
    yield LabelMap("left/sensor-valid", "why it has none", "depth camera", "class", codes, none=None, names=names)


def _matte_maps(view: StoredView) -> Iterator[LabelMap]:
    mattes = view.mattes()
    for number, coverage, passed in zip(mattes.ids, mattes.coverage, mattes.transmittance, strict=True):
        if coverage.any():
            yield _unit_number(f"left/coverage-{number}", f"coverage of {number}", "mattes", coverage)
            if (passed[coverage > 0.0] > 0.0).any():
                yield _colour(f"left/passes-{number}", "... what it passes on", "mattes", passed)


#: Files on request: the file, the kind of `--write`, what it holds, and its maps.
_REQUESTED: tuple[tuple[str, str, str, Callable[[StoredView], Iterator[LabelMap]]], ...] = (
    (layout.DISPARITY, "disparity", "the right camera's disparity, and what both cameras see", _pair_maps),
    (layout.VESSEL_PARTS, "vessel-parts", "glass, wet wall, liquid surface, content and opening", _part_maps),
    (layout.LAYERS, "layers", "every surface along the rays", _layer_maps),
    (layout.REFRACTION, "refraction", "where refracted rays end", _refraction_maps),
    (layout.MATTES, "mattes", "soft edges, and what each object lets through", _matte_maps),
)


def _ids(name: str, title: str, group: str, ids: np.ndarray) -> LabelMap:
    return LabelMap(name, title, group, "ids", ids.astype(np.uint16))


def _depth(name: str, title: str, group: str, Z: np.ndarray, ids: np.ndarray) -> LabelMap:
    """Return depths in steps of 0.1 mm, or larger ones where a far wall needs them; near is bright."""
    near, far = depth_colours(Z, ids)[1]
    values, step = _stepped(np.where(np.isfinite(Z), Z, 0.0), _DEPTH_STEP)
    return LabelMap(name, title, group, "number", values, step, "m", low=far, high=near)


def _disparity(name: str, title: str, disparity: np.ndarray) -> LabelMap:
    values, step = _stepped(disparity, _DISPARITY_STEP)
    shown = disparity[disparity > 0.0]
    low, high = (float(shown.min()), float(shown.max())) if shown.size else (0.0, 1.0)
    return LabelMap(name, title, "pair", "number", values, step, "px", low, high)


def _unit_number(name: str, title: str, group: str, values: np.ndarray) -> LabelMap:
    """Return numbers from 0 to 1."""
    return LabelMap(name, title, group, "number", np.rint(255.0 * values).astype(np.uint8), 1.0 / 255.0, none=None)


def _colour(name: str, title: str, group: str, values: np.ndarray) -> LabelMap:
    """Return three numbers from 0 to 1 a pixel, which a page shows as a colour."""
    stored = np.rint(255.0 * np.clip(values.astype(np.float32), 0.0, 1.0)).astype(np.uint8)
    return LabelMap(name, title, group, "colour", stored, 1.0 / 255.0, none=None)


def _coordinates(name: str, title: str, values: np.ndarray) -> LabelMap:
    """Return object coordinates: 0 where there is no object, else 1 to 255."""
    there = np.isfinite(values)
    stored = np.where(there, 1.0 + 254.0 * np.clip(np.nan_to_num(values), 0.0, 1.0), 0.0)
    return LabelMap(name, title, "objects", "colour", np.rint(stored).astype(np.uint8), 1.0 / 254.0)


def _flow(name: str, title: str, group: str, flow: np.ndarray) -> LabelMap:
    """Return flow in 16ths of a pixel; -32768 where there is none."""
    steps = np.clip(np.nan_to_num(flow) / _FLOW_STEP, -32767, 32767)
    stored = np.where(np.isfinite(flow), np.rint(steps), -32768).astype(np.int16)
    lengths = np.linalg.norm(flow, axis=-1)
    lengths = lengths[np.isfinite(lengths)]
    high = float(np.percentile(lengths, 95)) if lengths.size else 1.0
    return LabelMap(name, title, group, "flow", stored, _FLOW_STEP, "px", high=max(high, 1.0), none=-32768)


def _stepped(values: np.ndarray, finest: float) -> tuple[np.ndarray, float]:
    """Return positive numbers as multiples of a step, (H, W) uint16, and the step: the finest one that fits."""
    step = max(finest, float(values.max(initial=0.0)) / _STEPS)
    return np.rint(values / step).astype(np.uint16), step


def reduced(one: LabelMap, width: int, height: int) -> np.ndarray:
    """Return a map's numbers at another size: each pixel is one of the stored ones."""
    if one.values.shape[:2] == (height, width):
        return one.values
    return cv2.resize(one.values, (width, height), interpolation=cv2.INTER_NEAREST)
