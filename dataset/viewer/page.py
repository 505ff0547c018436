"""The page: one HTML file that holds pictures, labels, meshes and its own script, and loads nothing."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Iterator, Sequence
from html import escape
from importlib.resources import files
from typing import Any

import cv2
import numpy as np

from ...core.images import id_colour
from ...core.user_text import counted
from ...procedural.description.camera import Camera
from ...procedural.description.scene import TABLE_ID
from ...procedural.description.surroundings import ROOM_IDS
from ...render.frame import EYES, Eye
from ..format import layout
from ..format.conversion import Conversion
from ..format.dataset_file import DatasetFile
from ..format.objects_file import ObjectRecord
from ..format.scene_outline import picture_notes
from ..format.views_table import scene_views
from ..reader import StoredView
from .bodies import scene_bodies, view_cloud
from .choice import Choice
from .converted import converted_cloud, converted_scene, converted_shapes, lacking
from .label_maps import converted_maps, view_maps
from .map_numbers import LabelMap, reduced
from .object_numbers import object_numbers
from .packing import packed
from .rig import rig
from .sensor_maps import infrared_pictures
from .shapes import view_lines, view_shapes

#: JPEG quality of the pictures [1, 0 to 100]: some 60 kB of 640x480 px, with errors below the pictures' noise.
QUALITY = 92
#: Scripts in the order in which they need each other.
_SCRIPTS = ("decode.js", "maps.js", "space.js", "page.js")
#: Columns of the table of objects between their id and how far they can be seen.
_COLUMNS = (
    "name",
    "kind",
    "goes with",
    "size [mm]",
    "mass [g]",
    "with liquid [g]",
    "glass [ml]",
    "brimful [ml]",
    "liquid [ml]",
)


def page_parts(head: DatasetFile, choices: Sequence[Choice], width: int) -> Iterator[str]:
    """Yield the text of the page piece by piece, so that one view is in memory at a time.

    Parameters
    ----------
    head : DatasetFile
        ``dataset.json``.
    choices : sequence of Choice
        What is on it.
    width : int
        Most columns of pictures and maps [px]; larger ones are reduced.

    Raises
    ------
    InputError
        For a missing or damaged file.
    """
    resources = files(__package__ or "")
    script = "\n".join((resources / name).read_text("utf-8") for name in _SCRIPTS)
    # Only this script runs: text of a user's files can do nothing, and nothing is loaded.
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    policy = f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{digest}'"
    views = sum(len(choice.views) for choice in choices)
    title = escape(head.name)
    yield (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}: labels</title><style>{(resources / 'page.css').read_text('utf-8')}</style></head><body>"
        f"{_header(title, head, views, _notes(head, choices))}{_BODY}"
    )
    ramp = cv2.applyColorMap(np.arange(256, dtype=np.uint8), cv2.COLORMAP_VIRIDIS).reshape(-1, 3)[:, ::-1]
    listed = [{"id": one.scene.scene_id, "views": [view.number for view in one.views]} for one in choices]
    yield _block("head", {"ramp": ramp.ravel().tolist(), "scenes": listed, "columns": _COLUMNS})
    for number, choice in enumerate(choices):
        made = head.converted
        yield _block(f"scene-{number}", _scene(choice) if made is None else converted_scene(choice))
        for place, one in enumerate(choice.views):
            record = _view(choice, place, width) if made is None else _converted_view(one, made, width)
            yield _block(f"view-{number}-{place}", record)
    yield f"<script>{script}</script></body></html>\n"


_BODY = """
<main id="picture">
<div><h4>picture of</h4><div id="eyes"></div><h4>labels</h4><div id="map-list"></div>
<h4>opacity</h4><input id="opacity" type="range" min="0" max="1" step="0.05" aria-label="opacity"></div>
<div><div id="stage"><img id="photo" alt="picture"><canvas id="map" hidden></canvas><canvas id="shapes"></canvas></div>
<div id="legend"></div></div>
<div><h4>on top</h4><div id="shape-list"></div><h4>object</h4><div id="object-list"></div>
<h4>at the pixel</h4><div id="numbers"></div><div id="absent"></div></div>
</main>
<main id="maps" hidden></main>
<main id="space" hidden><div id="bar"><div id="solids"></div>
<label>point size <input id="size" type="range" min="1" max="8" value="2"></label>
<label>seen from <select id="camera-list"></select></label>
<span class="soft">drag: turn, shift: move, wheel: nearer</span></div>
<div id="room"><canvas id="world"></canvas><div id="labels"></div></div></main>
<main id="objects" hidden><table id="object-table"></table></main>
"""


def _notes(head: DatasetFile, choices: Sequence[Choice]) -> list[str]:
    """Return what of the pictures is not as usual: the camera that developed them, simplified light, a sensor."""
    developed = [] if head.developed is None else [f"developed by the camera {head.developed.camera.name}"]
    outlines = () if head.converted is not None else (choice.scene.outline() for choice in choices)
    return [*developed, *picture_notes(outlines)]


def _header(title: str, head: DatasetFile, views: int, notes: Sequence[str]) -> str:
    tabs = (("picture", "Picture"), ("maps", "All maps"), ("space", "3D"), ("objects", "Objects"))
    buttons = "".join(f'<button id="to-{name}" role="tab">{text}</button>' for name, text in tabs)
    lists = "".join(f'<select id="{name}" aria-label="{name}"></select>' for name in ("scene", "view"))
    made = f"seed {head.seed}, {counted(views, 'stereo view')}"
    if head.converted is not None:
        made = f"{head.converted.title} (licence: {head.converted.licence}), {counted(views, 'view')}"
    facts = escape("; ".join([f"{made} of scenes {head.scenes}", *notes]))
    return (
        f'<header><h1>{title}</h1>{lists}<nav role="tablist">{buttons}</nav><span class="soft">{facts}</span></header>'
    )


def _block(name: str, data: dict[str, Any]) -> str:
    """Return data as an element that a browser neither runs nor shows; nothing in it can end the element."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return f'<script type="application/json" id="{name}">{text}</script>\n'


def _scene(choice: Choice) -> dict[str, Any]:
    scene, records = choice.scene.scene(), choice.scene.objects().objects
    # A part of a room has up to 32 ids.
    names = {TABLE_ID: "table"} | {first + i: part for part, first in ROOM_IDS.items() for i in range(32)}
    names |= {record.id: record.name for record in records}
    return {
        "bodies": scene_bodies(scene, records),
        "cameras": [
            {eye: _pinhole(view.camera(), eye) for eye in EYES} | {"rig": rig(view, scene.depth_camera)}
            for view in choice.views
        ],
        "colours": {number: id_colour(number) for number in names},
        "names": names,
        "objects": [{"id": record.id, "cells": _cells(record)} for record in records],
    }


def _pinhole(camera: Camera, eye: Eye) -> dict[str, Any]:
    pose = camera.world_T_camera if eye == "left" else camera.world_T_right
    return {
        "K": camera.K.tolist(),
        "pose": np.asarray(pose).ravel().tolist(),
        "width": camera.width,
        "height": camera.height,
    }


def _view(choice: Choice, place: int, width: int) -> dict[str, Any]:
    view = choice.views[place]
    camera, (maps, absent) = view.camera(), view_maps(view, choice.following(place))
    shown = min(width, camera.width)
    height = max(1, round(camera.height * shown / camera.width))
    shapes = {"left": view_shapes(view.labels(), camera)}
    if (view.folder / layout.RIGHT_LABELS).is_file():
        shapes["right"] = view_shapes(view.labels("right"), camera)
    rows = scene_views(choice.scene.folder.parent.parent, choice.scene.scene_id).views
    row = next(row for row in rows if row.view == view.number)
    pictures = {eye: _picture(view.picture(eye), shown, height) for eye in EYES}
    infrared = {eye: _fitted(one, width) for eye, one in infrared_pictures(view).items()}
    return {
        "width": shown,
        "height": height,
        "size": [camera.width, camera.height],
        "pictures": pictures | {eye: _picture(one, *size) for eye, (one, size) in infrared.items()},
        "sizes": {eye: size for eye, (_, size) in infrared.items()},
        "maps": [_map(one, shown, height) for one in maps],
        "absent": absent,
        "numbers": object_numbers(row),
        "shapes": shapes,
        "lines": view_lines(view),
        "cloud": view_cloud(view, camera),
    }


def _fitted(picture: np.ndarray, width: int) -> tuple[np.ndarray, tuple[int, int]]:
    """Return a grey picture with three channels, and its columns and rows on the page."""
    rows, columns = picture.shape
    shown = min(width, columns)
    return np.repeat(picture[..., None], 3, axis=-1), (shown, max(1, round(rows * shown / columns)))


def _converted_view(view: StoredView, made: Conversion, width: int) -> dict[str, Any]:
    record = view.camera_record()
    shown = min(width, record.width)
    height = max(1, round(record.height * shown / record.width))
    eyes: tuple[Eye, ...] = EYES if (view.folder / "right.png").is_file() else ("left",)
    return {
        "width": shown,
        "height": height,
        "size": [record.width, record.height],
        "pictures": {eye: _picture(view.picture(eye), shown, height) for eye in eyes},
        "maps": [_map(one, shown, height) for one in converted_maps(view, made.classes)],
        "absent": {},
        "lacks": lacking(made),
        "shapes": {"left": converted_shapes(view)},
        "lines": {"openings": [], "fill lines": []},
        "cloud": converted_cloud(view),
    }


def _map(one: LabelMap, width: int, height: int) -> dict[str, Any]:
    fields = ("name", "title", "group", "kind", "step", "unit", "low", "high", "none", "names")
    return {field: getattr(one, field) for field in fields} | {"data": packed(reduced(one, width, height))}


def _picture(picture: np.ndarray, width: int, height: int) -> str:
    """Return a picture as the address of its own JPEG data."""
    if picture.shape[:2] != (height, width):
        picture = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
    # Full chroma: thin coloured edges of glass are what one looks for.
    options = [
        cv2.IMWRITE_JPEG_QUALITY,
        QUALITY,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    ]
    done, data = cv2.imencode(".jpg", np.ascontiguousarray(picture[..., ::-1]), options)
    if not done:
        raise ValueError(f"a picture of shape {picture.shape} could not be encoded")
    return "data:image/jpeg;base64," + base64.b64encode(data.tobytes()).decode("ascii")


def _cells(record: ObjectRecord) -> list[str]:
    """Return what the table of objects says of one, in the order of `_COLUMNS`."""
    mechanics, volumes = record.mechanics, record.volumes
    whole = None if mechanics is None else mechanics.whole.mass
    empty = whole if mechanics is None or mechanics.empty is None else mechanics.empty.mass
    filled = whole if mechanics is not None and mechanics.empty is not None else None
    glass, brimful, liquid = (None, None, None) if volumes is None else (volumes.glass, volumes.brimful, volumes.liquid)
    numbers = [(empty, 1e3), (filled, 1e3), (glass, 1e6), (brimful, 1e6), (liquid, 1e6)]
    return [
        record.name,
        record.category,
        record.part_of or record.within or "",
        " x ".join(f"{1e3 * side:.0f}" for side in record.size),
        *("-" if value is None else f"{factor * value:.1f}" for value, factor in numbers),
    ]
