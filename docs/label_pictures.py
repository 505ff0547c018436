"""Draw the pictures of docs/labels.md from a data set that has all files.

.venv/bin/render-scene --seed 7 --width 640 --height 480 --views 3 --out labels-data --write all
.venv/bin/python docs/label_pictures.py labels-data
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np

from glassware.annotate.masks import decode_mask
from glassware.core.images import depth_colours, id_colour, id_colours, normal_colours
from glassware.dataset.reader import Dataset
from glassware.dataset.stored_view import StoredView
from glassware.procedural.vessels.families import FAMILIES

#: Size of a panel [px].
WIDTH, HEIGHT = 320, 240
IMAGES = Path(__file__).parent / "images"
#: Colours of the four states of a keypoint, and of pixels in the pair: red, green, blue.
STATES = {"visible": (60, 200, 80), "through_glass": (70, 150, 255), "occluded": (235, 70, 60), "outside": (0, 0, 0)}
PAIR = np.array([(60, 160, 80), (235, 70, 60), (250, 190, 50), (45, 45, 48)], np.uint8)
#: Colours of the parts of vessels, drawn one over the other.
PARTS = {
    "glass": (120, 150, 175),
    "content": (225, 150, 60),
    "wet_wall": (200, 120, 40),
    "liquid_surface": (80, 220, 230),
}


def panel(picture: np.ndarray, text: str) -> np.ndarray:
    """Return a picture at the size of a panel, with a line of text on it."""
    small = cv2.resize(np.ascontiguousarray(picture), (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    cv2.rectangle(small, (0, HEIGHT - 18), (WIDTH, HEIGHT), (20, 20, 22), -1)
    cv2.putText(small, text, (6, HEIGHT - 5), cv2.FONT_HERSHEY_SIMPLEX, 0.42, (240, 240, 240), 1, cv2.LINE_AA)
    return small


def sheet(name: str, panels: list[np.ndarray], columns: int = 3) -> None:
    """Write panels in rows as a JPEG."""
    rows = [np.hstack(panels[at : at + columns]) for at in range(0, len(panels), columns)]
    cv2.imwrite(str(IMAGES / f"{name}.jpg"), np.vstack(rows)[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 80])


def scaled(values: np.ndarray, colours: int = cv2.COLORMAP_VIRIDIS) -> np.ndarray:
    """Return a map as colours, from its smallest finite value to its largest; dark where there is none."""
    there = np.isfinite(values) & (values != 0.0)
    low, high = values[there].min(), values[there].max()
    level = np.clip((np.where(there, values, low) - low) / (high - low), 0.0, 1.0)
    picture = cv2.applyColorMap(np.rint(255 * level).astype(np.uint8), colours)[..., ::-1].copy()
    picture[~there] = (45, 45, 48)
    return picture


def shown_flow(flow: np.ndarray) -> np.ndarray:
    """Return flow as colours: direction is hue, length is brightness."""
    angle = np.arctan2(np.nan_to_num(flow[..., 1]), np.nan_to_num(flow[..., 0]))
    length = np.nan_to_num(np.linalg.norm(flow, axis=-1))
    # The longest tenth is as bright as the rest's longest: rims bend rays by hundreds of pixels.
    bright = np.sqrt(np.clip(length / np.quantile(length[length > 0.0], 0.9), 0.0, 1.0))
    hue = (angle + np.pi) / (2.0 * np.pi) * 179.0
    hsv = np.stack([hue, np.full_like(hue, 200.0), 255.0 * bright], axis=-1)
    picture = cv2.cvtColor(hsv.astype(np.uint8), cv2.COLOR_HSV2RGB)
    picture[np.isnan(flow[..., 0])] = (45, 45, 48)
    return picture


def depth_and_ids(view: StoredView) -> None:
    """Draw pictures, depth, background, normals and ids."""
    left, right = view.geometry(), view.geometry("right")
    sheet(
        "labels-surfaces",
        [
            panel(view.picture(), "left picture"),
            panel(depth_colours(left.Z, left.id)[0], "depth of the first surface"),
            panel(depth_colours(left.background_Z, left.background_id)[0], "depth of the background"),
            panel(normal_colours(left.normal), "normals of the first surface"),
            panel(id_colours(left.id), "ids, left camera"),
            panel(id_colours(right.id), "ids, right camera"),
        ],
    )


def stereo(view: StoredView) -> None:
    """Draw disparity, and what the other camera sees."""
    pair = {eye: view.pair_visibility(eye) for eye in ("left", "right")}
    sheet(
        "labels-stereo",
        [
            panel(scaled(view.disparity()), "disparity, left"),
            panel(PAIR[pair["left"].first], "first surface: seen by the right camera"),
            panel(PAIR[pair["left"].background], "background: seen by the right camera"),
            panel(scaled(view.disparity("right")), "disparity, right"),
            panel(PAIR[pair["right"].first], "first surface: seen by the left camera"),
            panel(PAIR[pair["right"].background], "background: seen by the left camera"),
        ],
    )


def objects(view: StoredView, other: StoredView) -> None:
    """Draw masks, keypoints, heatmap, coordinates, flow."""
    picture, labels = view.picture(), view.labels()
    classes, points = picture // 3, picture.copy()
    ids = view.geometry().id
    for item in labels.objects:
        whole, seen = (decode_mask(mask.counts, mask.size) for mask in (item.mask_amodal, item.mask_seen))
        if item.category not in FAMILIES:
            classes[whole & ~seen] = STATES["occluded"]
            classes[seen & (ids != item.id)] = STATES["through_glass"]
            classes[ids == item.id] = STATES["visible"]
        for point in item.keypoints:
            if point.pixel is not None and point.state != "outside":
                at = (round(point.pixel[0]), round(point.pixel[1]))
                cv2.circle(points, at, 5, STATES[point.state], -1, cv2.LINE_AA)
    coordinates = [np.nan_to_num(255 * view.object_coordinates(back), nan=45).clip(0, 255) for back in (False, True)]
    sheet(
        "labels-objects",
        [
            panel(classes, "opaque objects: visible, through glass, occluded"),
            panel(points, "keypoints: visible, through glass, occluded"),
            panel(scaled(view.heatmap() + 1e-9, cv2.COLORMAP_INFERNO), "heatmap"),
            panel(coordinates[0].astype(np.uint8), "object coordinates"),
            panel(coordinates[1].astype(np.uint8), "object coordinates of back walls"),
            panel(shown_flow(view.flow(other)), "flow to another view"),
        ],
    )


def vessels(view: StoredView) -> None:
    """Draw the parts of vessels, with the edges of mouths and the lines of their fillings."""
    picture = view.picture()
    parts, lines = picture.copy(), picture.copy()
    for masks in view.vessel_parts().values():
        for name, colour in PARTS.items():
            parts[getattr(masks, name)] = colour
    for outlines, colour in ((view.openings(), (255, 255, 255)), (view.fill_lines(), (255, 60, 160))):
        for polygons in outlines.values():
            for polygon in polygons:
                cv2.polylines(lines, [np.rint(4 * polygon).astype(np.int32)], True, colour, 2, cv2.LINE_AA, 2)
    layers, refraction = view.layers(), view.refraction()
    sheet(
        "labels-vessels",
        [
            panel(parts, "glass, wet wall, liquid surface, content"),
            panel(lines, "mouths and fill lines"),
            panel(scaled(layers.count.astype(float)), "surfaces along the straight ray"),
            panel(scaled(layers.Z[1]), "depth of the second surface"),
            panel(scaled(np.where(refraction.bounces > 0, refraction.Z, np.nan)), "depth behind refraction"),
            panel(shown_flow(np.where(refraction.bounces[..., None] > 0, refraction.flow, np.nan)), "refractive flow"),
        ],
    )


def mattes(view: StoredView) -> None:
    """Draw the edge of the largest vessel, and what all objects cover and pass on."""
    found, labels = view.mattes(), view.labels()
    glass = [place for place, passed in enumerate(found.transmittance) if (passed[found.coverage[place] > 0] > 0).any()]
    place = max(glass, key=lambda one: found.coverage[one].sum())
    mask = decode_mask(labels.objects[place].mask_seen.counts, labels.objects[place].mask_seen.size)
    rows, columns = np.nonzero(mask)
    top, left = int(rows.min()) - 4, int(columns.min()) - 4
    part = (slice(max(top, 0), max(top, 0) + 36), slice(max(left, 0), max(left, 0) + 48))

    def enlarged(values: np.ndarray) -> np.ndarray:
        grey = np.rint(255 * values[part]).astype(np.uint8)
        return cv2.resize(np.stack([grey] * 3, axis=-1), (WIDTH, HEIGHT), interpolation=cv2.INTER_NEAREST)

    blend = sum(values[..., None] * np.array(id_colour(number)) for number, values in found.first.items())
    opacity = found.coverage[..., None] * (1.0 - found.transmittance)
    passed = np.prod(1.0 - opacity, axis=0)
    sheet(
        "labels-mattes",
        [
            panel(enlarged(mask.astype(float)), f"mask of object {found.ids[place]}, enlarged"),
            panel(enlarged(found.coverage[place]), "its coverage"),
            panel(np.rint(255 * found.transmittance[place]).astype(np.uint8), "what it passes on"),
            panel(np.rint(blend).astype(np.uint8), "first surfaces (Cryptomatte)"),
            panel(np.rint(255 * opacity[place]).astype(np.uint8), "its opacity"),
            panel(np.rint(255 * passed).astype(np.uint8), "what all objects pass on"),
        ],
    )


def main() -> None:
    """Draw all pictures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("data", type=Path, help="a data set of two views or more, with all files")
    parser.add_argument("--view", type=int, default=0)
    options = parser.parse_args()
    views = Dataset.open(options.data).scenes[0].views
    view, other = views[options.view], views[(options.view + 1) % len(views)]
    depth_and_ids(view)
    stereo(view)
    objects(view, other)
    vessels(view)
    mattes(view)


if __name__ == "__main__":
    main()
