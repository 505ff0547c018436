"""Whatever is wrong with a data set is found and named, and nothing else is."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from glassware.annotate.masks import decode_mask, encode_mask
from glassware.dataset.format.exr import exr_attributes, read_exr, write_exr
from glassware.dataset.format.pictures import read_png, write_png
from glassware.dataset.reader import Dataset
from glassware.dataset.verification.scene import WrongLabelError, check_written, scene_label_faults

#: Change of a file: what it holds in, nothing out.
Change = Callable[[Any], object]
#: A view's folder, and that of its scene.
VIEW, SCENE = "scenes/000000/000", "scenes/000000"


def _json(path: Path, change: Change) -> None:
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))


def _exr(path: Path, change: Change) -> None:
    channels = read_exr(path)
    named = {key: text for key, text in exr_attributes(path).items() if key.startswith("cryptomatte/")}
    change(channels)
    write_exr(path, channels, named)


def _png(path: Path, change: Change) -> None:
    picture = read_png(path)
    change(picture)
    write_png(path, picture)


def damage(root: Path, file: str, change: Change) -> None:
    """Change the content of a file."""
    {".json": _json, ".exr": _exr, ".png": _png}[Path(file).suffix](root / file, change)


def first(change: Change, where: Callable[[Any], bool] = lambda _: True) -> Change:
    """Return a change of the first object of which something is true."""
    return lambda content: change(next(item for item in content["objects"] if where(item)))


def seen(item: Any) -> bool:
    """Return whether an object has pixels of all that can be damaged."""
    return item["pixels"]["visible"] > 20


def _add(field: str, *index: int, by: float) -> Change:
    def change(item: Any) -> None:
        for key in (field, *index[:-1]):
            item = item[key]
        item[index[-1]] += by

    return change


def _mask(field: str) -> Change:
    """Move a mask down by two pixels."""

    def change(item: Any) -> None:
        mask = decode_mask(item[field]["counts"], tuple(item[field]["size"]))
        item[field]["counts"] = encode_mask(np.roll(mask, 2, axis=0))

    return change


def _counted(item: Any) -> None:
    item["pixels"]["visible"] -= 1
    item["pixels"]["seen_through"] += 1


def _fraction(item: Any) -> None:
    item["fractions"]["visible"] -= 0.25
    item["fractions"]["occluded"] += 0.25


def _state(item: Any) -> None:
    point = next(point for point in item["keypoints"] if point["state"] != "outside")
    point["state"] = "visible" if point["state"] == "occluded" else "occluded"


def _symmetry(item: Any) -> None:
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_euler("xyz", [0.7, 0.3, 0.2]).as_matrix()
    item["symmetries_discrete"].append(turn.tolist())


def _at(channel: str, change: Callable[[np.ndarray, np.ndarray], object], where: str = "Z") -> Change:
    """Return a change of some pixels of a channel, where another one is finite."""

    def damaged(channels: dict[str, np.ndarray]) -> None:
        rows, columns = np.nonzero(np.isfinite(channels[where].astype(np.float64)) & (channels[where] != 0))
        some = np.zeros(channels[where].shape, bool)
        some[rows[::7], columns[::7]] = True
        change(channels[channel], some)

    return damaged


def _plus(amount: float) -> Callable[[np.ndarray, np.ndarray], None]:
    def change(values: np.ndarray, some: np.ndarray) -> None:
        values[some] += values.dtype.type(amount)

    return change


def _negated(values: np.ndarray, some: np.ndarray) -> None:
    values[some] *= -1


def _set(value: float) -> Callable[[np.ndarray, np.ndarray], None]:
    def change(values: np.ndarray, some: np.ndarray) -> None:
        values[some] = value

    return change


def _complement(channels: dict[str, np.ndarray], prefix: str) -> None:
    """Change the fractions of the object that covers the most."""
    number = max(2, 3, key=lambda one: channels[f"coverage.{one}"].sum())
    for name, values in channels.items():
        if name.startswith(f"{prefix}{number}"):
            np.subtract(1.0, values, out=values)


def _swapped_ids(ids: np.ndarray) -> None:
    numbers = np.unique(ids[ids > 1])
    ids[ids == numbers[0]] = numbers[1]


def _half_of_it(values: np.ndarray) -> None:
    values[: len(values) // 2] = values[len(values) // 2 :][: len(values) // 2]


def _entering(channels: dict[str, np.ndarray]) -> None:
    there = np.isfinite(channels["layer00.Z"])
    channels["layer00.entering"][there] = 1 - channels["layer00.entering"][there]


def _box(kind: str) -> Change:
    return lambda item: _add(kind, 2, by=1.0)(item["box2d"])


def _moved_keypoint(item: Any) -> None:
    item["keypoints"][0]["pixel"][0] += 2.0


def _order(content: Any) -> None:
    numbers = [item["id"] for item in content["objects"]]
    content["occlusion"].append({"front": numbers[0], "behind": numbers[-1], "pixels": 7})


def _density(item: Any) -> None:
    item["material"]["medium"]["density"] = 90_000.0


def _liquid(item: Any) -> None:
    item["liquid"]["volume"] *= 1.1


def _index(content: Any) -> None:
    content["views"][0]["visible_pixels"][0] += 1


#: What is damaged, how, in which file, and the check that names it.
FAULTS: list[tuple[str, str, Change, str]] = [
    ("focal length", f"{VIEW}/camera.json", _add("K", 0, 0, by=1.0), "camera"),
    ("place of the camera", f"{VIEW}/camera.json", _add("world_T_camera", 0, 3, by=0.001), "camera"),
    ("turn of the camera", f"{VIEW}/camera.json", _add("world_T_camera", 0, 0, by=0.01), "camera"),
    ("right camera", f"{VIEW}/camera.json", _add("world_T_right", 2, 3, by=0.001), "camera"),
    ("place of an object", f"{SCENE}/objects.json", first(_add("world_T_object", 0, 3, by=0.001)), "objects"),
    ("size of an object", f"{SCENE}/objects.json", first(_add("size", 2, by=0.001)), "objects"),
    ("keypoint off the surface", f"{SCENE}/objects.json", first(_add("keypoints", 3, 1, by=0.001)), "objects"),
    ("volume", f"{SCENE}/objects.json", first(_liquid, lambda item: bool(item["liquid"])), "objects"),
    ("symmetry", f"{SCENE}/objects.json", first(_symmetry, lambda item: item["liquid"] is None), "objects"),
    ("density of glass", f"{SCENE}/objects.json", first(_density, lambda i: i["parts"][0]["name"] == "glass"), "media"),
    ("name of an object", f"{VIEW}/labels.json", first(lambda item: item.update(name="another")), "objects"),
    ("pose", f"{VIEW}/labels.json", first(_add("camera_T_object", 1, 3, by=0.001)), "poses"),
    ("corner of a box", f"{VIEW}/labels.json", first(_add("box3d", 5, 0, by=0.001)), "box3d"),
    ("centroid", f"{VIEW}/labels.json", first(lambda item: item["centroid"]["point"].__setitem__(2, 0.1)), "centroid"),
    (
        "box of visible pixels",
        f"{VIEW}/labels.json",
        first(lambda item: _add("modal", 2, by=1.0)(item["box2d"]), seen),
        "boxes",
    ),
    (
        "box of the whole",
        f"{VIEW}/labels.json",
        first(lambda item: _add("amodal", 0, by=-0.5)(item["box2d"]), seen),
        "boxes",
    ),
    ("silhouette", f"{VIEW}/labels.json", first(_mask("mask_amodal"), seen), "masks"),
    ("seen part", f"{VIEW}/labels.json", first(_mask("mask_seen"), seen), "masks"),
    ("count of pixels", f"{VIEW}/labels.json", first(_counted, seen), "counts"),
    ("fraction", f"{VIEW}/labels.json", first(_fraction, seen), "fractions"),
    (
        "pixel of a keypoint",
        f"{VIEW}/labels.json",
        first(lambda item: item["keypoints"][0]["pixel"].__setitem__(0, 3.0)),
        "keypoints",
    ),
    ("state of a keypoint", f"{VIEW}/labels.json", first(_state, seen), "keypoint states"),
    ("order of objects", f"{VIEW}/labels.json", _order, "occlusion"),
    ("ids", f"{VIEW}/instances.png", _swapped_ids, "ids"),
    ("depth", f"{VIEW}/geometry.exr", _at("Z", _plus(0.001)), "depth"),
    ("normals", f"{VIEW}/geometry.exr", _at("N.X", _plus(0.1)), "normals"),
    ("depth of the background", f"{VIEW}/geometry.exr", _at("background.Z", _plus(0.01)), "background"),
    ("id of the background", f"{VIEW}/geometry.exr", _at("background.id", _set(0.0), "background.id"), "background"),
    ("transmittance", f"{VIEW}/geometry.exr", _at("transmittance.G", _set(1.5)), "transmittance"),
    ("depth of a layer", f"{VIEW}/layers.exr", _at("layer01.Z", _plus(0.01), "layer01.Z"), "layers 1 Z"),
    ("side of a layer", f"{VIEW}/layers.exr", _entering, "layers 0 entering"),
    ("part of a layer", f"{VIEW}/layers.exr", _at("layer01.part", _set(3.0), "layer01.part"), "layers 1 part"),
    ("number of layers", f"{VIEW}/layers.exr", _at("count", _plus(1.0), "count"), "layers count"),
    ("end of refracted rays", f"{VIEW}/refraction.exr", lambda c: c["hit.X"].__iadd__(np.float32(0.01)), "refraction"),
    ("refractive flow", f"{VIEW}/refraction.exr", _at("flow.U", _plus(1.0)), "refraction flow"),
    ("disparity", f"{VIEW}/disparity.exr", _at("left", _plus(0.5), "left"), "disparity left"),
    ("what the other eye sees", f"{VIEW}/pair.png", lambda bits: np.bitwise_xor(bits, 1, out=bits), "pair left.first"),
    ("heatmap", f"{VIEW}/heatmap.png", _half_of_it, "heatmap"),
    ("object coordinates", f"{VIEW}/coordinates.exr", _at("Y", _plus(0.05), "Y"), "coordinates front.XYZ"),
    ("parts of vessels", f"{VIEW}/vessel_parts.png", lambda bits: np.bitwise_xor(bits, 4, out=bits), "vessel parts"),
    ("coverage", f"{VIEW}/mattes.exr", lambda c: _complement(c, "coverage."), "mattes coverage"),
    ("what a vessel passes on", f"{VIEW}/mattes.exr", lambda c: _complement(c, "transmittance."), "mattes trans"),
    ("first surfaces of pixels", f"{VIEW}/cryptomatte.exr", lambda c: c["CryptoObject00.G"].fill(0.5), "mattes first"),
    ("black picture", f"{VIEW}/left.png", lambda picture: picture.fill(0), "pictures"),
    ("white picture", f"{VIEW}/right.png", lambda picture: picture.fill(255), "pictures"),
    ("radiance", f"{VIEW}/left.exr", _at("G", _plus(5.0), "G"), "radiance"),
    ("right depth", f"{VIEW}/right_geometry.exr", _at("Z", _plus(0.001)), "depth"),
    ("right ids", f"{VIEW}/right_instances.png", _swapped_ids, "ids"),
    ("right pose", f"{VIEW}/right_labels.json", first(_add("camera_T_object", 1, 3, by=0.001)), "poses"),
    ("index", f"{SCENE}/views.json", _index, "index"),
]


def faults_of(root: Path) -> list[tuple[str, str]]:
    """Return file and check of each fault."""
    lines = [line.removeprefix(f"{root}/").split(": ") for line in scene_label_faults(root, 0)]
    return [(words[0], words[1]) for words in lines]


def test_a_data_set_as_it_was_built_has_no_faults(proven):
    assert faults_of(proven) == []


@pytest.mark.slow
@pytest.mark.parametrize(("what", "file", "change", "check"), FAULTS, ids=[what for what, *_ in FAULTS])
def test_each_damage_is_found_and_named_and_nothing_else_is(copy, what, file, change, check):
    damage(copy, file, change)
    found = faults_of(copy)
    assert found, what
    assert {(name, text.startswith(check)) for name, text in found} == {(file, True)}


@pytest.mark.slow
def test_the_same_picture_for_both_eyes_is_named(copy):
    view = copy / VIEW
    (view / "right.png").write_bytes((view / "left.png").read_bytes())
    assert faults_of(copy) == [(f"{VIEW}/right.png", "pictures")]


@pytest.mark.parametrize(
    "what", ["depth", "ids", "count of pixels", "box of visible pixels", "pose", "disparity", "black picture"]
)
def test_what_contradicts_itself_is_refused_before_a_scene_appears(copy, what):
    (stored,) = Dataset.open(copy).scenes
    scene, records = stored.scene(), stored.objects()
    check_written(stored.views[0], scene, records)
    _, file, change, _ = next(fault for fault in FAULTS if fault[0] == what)
    damage(copy, file, change)
    with pytest.raises(WrongLabelError, match=r"view 0 has \d+ wrong label"):
        check_written(stored.views[0], scene, records)
