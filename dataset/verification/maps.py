"""Maps that follow from depth, ids and poses: disparity, what the other eye sees, heat, coordinates, vessels' parts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from ...annotate.labels import Labels
from ...annotate.stereo import BOTH, HIDDEN, NOTHING, OUTSIDE, PairVisibility
from ...procedural.description.camera import Camera
from ...procedural.description.material_list import opaque_media
from ...procedural.description.scene import Scene
from ...render.frame import EYES, Eye, Geometry, Layers
from ..format.exr import channel, read_exr
from ..format.map_files import HEAT_STEPS, PAIR_SHIFTS, read_ids
from .fault import Fault, at_pixels
from .objects import sight_states
from .pinhole import Pinhole, image_of, pinhole_of, pixel_centres, rays_of, seen_from
from .triangles import Triangles

#: Relative rounding of float32, with a factor for two operations.
FLOAT32 = 3e-7
#: Rounding of a half to 2^-11 of a value up to 1, with that of the depth behind it.
HALF = 6e-4
#: Step of the heat map, and the rounding of float32 in the exponent: 10 at the edge of what is not 0.
HEAT = 1.5 / HEAT_STEPS
#: Standard deviations beyond which there is no heat: exp(-_FAR^2 / 2) is a sixth of a step.
_FAR = 5.1
#: Pixels of each map of ``pair.png`` whose rays are traced again.
SAMPLED = 400
#: Bits of ``vessel_parts.png`` that follow from layers, and the kinds of surfaces that set them.
_BITS = {1: (1, 2), 2: (2,), 4: (3,), 8: (2, 3, 4, 5)}
_OPENING = 16


def disparity_faults(path: Path, camera: Camera, seen: dict[Eye, Geometry]) -> list[Fault]:
    """Compare stored disparities with f b / Z of the stored depths."""
    channels, found = read_exr(path), []
    for eye, geometry in seen.items():
        for name, depth in ((eye, geometry.Z), (f"{eye}.background", geometry.background_Z)):
            stored = channel(channels, name, path)
            expected = camera.focal * camera.baseline / depth.astype(np.float64)
            wrong = ~(np.abs(stored - expected) <= FLOAT32 * np.maximum(expected, 1e-6))
            found += at_pixels(f"disparity {name}", path.name, wrong, expected, stored)
    return found


def pair_contradictions(
    path: Path, camera: Camera, seen: dict[Eye, Geometry], read: Callable[[Eye], PairVisibility]
) -> list[Fault]:
    """Check that points are in or outside of the other picture as stated, and that there are points at all."""
    found: list[Fault] = []
    for eye, name, depth, codes in _pair_maps(seen, read):
        landing = _landing(camera, eye, depth)
        point = np.isfinite(depth)
        inside = (landing >= -0.5) & (landing < camera.width - 0.5)
        border = np.abs(landing + 0.5 - np.rint(landing + 0.5)) < 1e-4
        wrong = (codes == NOTHING) != ~point
        wrong |= point & ((codes == OUTSIDE) == inside) & ~border
        found += at_pixels(f"pair {eye}.{name}", path.name, wrong, "what the other camera sees of it", codes)
    return found


def pair_faults(
    path: Path,
    camera: Camera,
    triangles: Triangles,
    seen: dict[Eye, Geometry],
    read: Callable[[Eye], PairVisibility],
    rng: np.random.Generator,
) -> list[Fault]:
    """Trace rays from the other eye to points of random pixels again."""
    found: list[Fault] = []
    for eye, name, depth, codes in _pair_maps(seen, read):
        other = pinhole_of(camera, _other(eye))
        picked = rng.permutation(np.flatnonzero(np.isin(codes.ravel(), (BOTH, HIDDEN))))[:SAMPLED]
        here = pinhole_of(camera, eye)
        points = rays_of(here, pixel_centres(here)[picked]) * depth.ravel()[picked, None].astype(np.float64)
        local = seen_from(other, points @ here.axes + here.origin)
        states = sight_states(triangles, other, image_of(other, local), local[:, 2])
        free = states[:, 0] if name == "first" else states[:, :2].any(axis=1)
        hidden = states[:, 1:].any(axis=1) if name == "first" else states[:, 2]
        wrong = np.zeros(codes.size, bool)
        wrong[picked] = np.where(codes.ravel()[picked] == BOTH, ~free, ~hidden)
        wrong = wrong.reshape(codes.shape)
        found += at_pixels(f"pair {eye}.{name}", path.name, wrong, "the other of visible and hidden", codes)
    return found


def heatmap_faults(path: Path, ids: np.ndarray, labels: Labels) -> list[Fault]:
    """Compare the heatmap with one computed from the ids: normals with 0.8 of the covariance of objects' pixels."""
    heat = np.zeros(ids.shape)
    for label in labels.objects:
        y, x = np.nonzero(ids == label.id)
        if len(x) < 16 or min(corner[2] for corner in label.box3d) <= 0.0:
            continue
        spread = 0.8 * (np.cov(np.stack([x, y]), bias=True) + np.eye(2) / 12.0)
        # Beyond that many deviations along either axis there is less than a step of heat.
        half = _FAR * np.sqrt(np.diag(spread))
        box = tuple(
            slice(max(int(middle - reach), 0), int(middle + reach) + 2)
            for middle, reach in zip((y.mean(), x.mean()), half[::-1], strict=True)
        )
        v, u = (np.arange(size)[part] for size, part in zip(ids.shape, box, strict=True))
        u, v = u - x.mean(), (v - y.mean())[:, None]
        inverse = np.linalg.inv(spread)
        away = inverse[0, 0] * u * u + 2.0 * inverse[0, 1] * u * v + inverse[1, 1] * v * v
        heat[box] = np.maximum(heat[box], np.exp(-0.5 * away))
    stored = read_ids(path) / HEAT_STEPS
    return at_pixels("heatmap", path.name, np.abs(stored - heat) > HEAT + 1e-5, heat, stored)


def coordinate_faults(
    path: Path, scene: Scene, camera: Pinhole, geometry: Geometry, layers: Layers | None
) -> list[Fault]:
    """Compare object coordinates with the description's poses and sizes."""
    channels = read_exr(path)
    places = np.flatnonzero(np.isin(geometry.id, [item.id for item in scene.objects]))
    ids, rays = geometry.id.ravel()[places], rays_of(camera, pixel_centres(camera)[places])
    depths = {"": geometry.Z.ravel()[places]}
    if layers is not None:
        along = layers.Z.reshape(len(layers.Z), -1)[:, places]
        own = (layers.id.reshape(len(along), -1)[:, places] == ids) & np.isfinite(along)
        depths["back."] = np.where(own, along, 0.0).max(axis=0)
    found: list[Fault] = []
    for prefix, depth in depths.items():
        stored = np.stack([channel(channels, f"{prefix}{axis}", path) for axis in "XYZ"], axis=-1)
        expected = np.full(stored.shape, np.nan)
        for item in scene.objects:
            on = np.flatnonzero((ids == item.id) & np.isfinite(depth) & (depth > 0.0))
            pose = np.asarray(item.world_T_object)
            world = (rays[on] * depth[on][:, None]) @ camera.axes + camera.origin
            unit = 0.5 + (world - pose[:3, 3]) @ pose[:3, :3] / np.sqrt(np.square(item.size).sum())
            expected.reshape(-1, 3)[places[on]] = unit
        wrong = np.asarray(~np.isnan(stored).all(axis=-1))  # where there is no object
        mine, here = stored.reshape(-1, 3)[places].astype(np.float64), expected.reshape(-1, 3)[places]
        near = (np.isnan(mine) & np.isnan(here)) | (np.abs(mine - here) < HALF)
        wrong.ravel()[places] = ~near.all(axis=-1)
        found += at_pixels(f"coordinates {prefix or 'front.'}XYZ", path.name, wrong, expected, stored)
    return found


def part_faults(path: Path, scene: Scene, geometry: Geometry, layers: Layers, mouths: np.ndarray) -> list[Fault]:
    """Compare the bits of vessels' parts with the layers, and with the mouths, (H, W) bool and where that is unsure."""
    bits = read_ids(path)
    vessels = [body.id for body in scene.vessels]
    on = np.zeros(int(layers.id.max(initial=0)) + 1, bool)
    on[[number for number in vessels if number < len(on)]] = True
    there = on[layers.id].any(axis=0)  # rays that meet a vessel, a tenth of the picture
    Z, ids, part, material = (x[:, there] for x in (layers.Z, layers.id, layers.part, layers.material))
    solid = ((part == 0) | np.isin(material, opaque_media(scene))) & np.isfinite(Z)
    behind = np.cumsum(solid, axis=0) - solid > 0
    counted = np.isfinite(Z) & ~behind & on[ids]
    expected = np.zeros(bits.shape, int)
    for bit, kinds in _BITS.items():
        expected[there] |= bit * (counted & np.isin(part, kinds)).any(axis=0)
    inside, unsure = mouths
    wrong = ((bits & ~np.uint16(_OPENING)) != expected) | (((bits & _OPENING) > 0) != inside) & ~unsure
    return at_pixels("vessel parts", path.name, wrong, expected | _OPENING * inside, bits)


def mouth_masks(scene: Scene, camera: Pinhole, mouths: list[list[np.ndarray]]) -> np.ndarray:
    """Return the pixels inside the mouths of vessels, and those within 0.01 px of their edges, (2, H, W) bool.

    By the winding number: the angles under which a pixel sees the edges add up to a full turn inside.
    """
    width, height = camera.size
    inside, unsure = np.zeros((height, width), bool), np.zeros((height, width), bool)
    for body, lines in zip(scene.vessels, mouths, strict=True):
        pose = np.asarray(body.world_T_object)
        for line in lines:
            corners = image_of(camera, seen_from(camera, line @ pose[:3, :3].T + pose[:3, 3]))
            if not np.isfinite(corners).all():
                continue
            low = np.clip(np.floor(corners.min(axis=0) - 1.0), 0, camera.size).astype(int)
            high = np.clip(np.ceil(corners.max(axis=0) + 2.0), 0, camera.size).astype(int)
            box = slice(low[1], high[1]), slice(low[0], high[0])
            rows, columns = np.mgrid[box]
            pixels = np.stack([columns, rows], axis=-1).astype(np.float64)
            winding, away = np.zeros(pixels.shape[:2]), np.full(pixels.shape[:2], np.inf)
            for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
                p, q, side = a - pixels, b - pixels, b - a
                winding += np.arctan2(p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0], (p * q).sum(axis=-1))
                t = np.clip((-p @ side) / max(side @ side, 1e-12), 0.0, 1.0)
                away = np.minimum(away, np.linalg.norm(p + t[..., None] * side, axis=-1))
            inside[box] |= np.abs(winding) > np.pi
            unsure[box] |= away < 0.01
    return np.stack([inside, unsure])


def _pair_maps(
    seen: dict[Eye, Geometry], read: Callable[[Eye], PairVisibility]
) -> Iterator[tuple[Eye, str, np.ndarray, np.ndarray]]:
    stored = {eye: read(eye) for eye in seen}
    for eye, name in PAIR_SHIFTS:
        if eye in seen:
            depth = seen[eye].Z if name == "first" else seen[eye].background_Z
            yield eye, name, depth, getattr(stored[eye], name)


def _other(eye: Eye) -> Eye:
    return EYES[1 - EYES.index(eye)]


def _landing(camera: Camera, eye: Eye, depth: np.ndarray) -> np.ndarray:
    """Return the columns in which the points of one eye appear in the other one, (H, W) [px]: rows are the same."""
    u = np.arange(depth.shape[1])
    shift = camera.focal * camera.baseline / depth.astype(np.float64)
    return u - shift if eye == "left" else u + shift
