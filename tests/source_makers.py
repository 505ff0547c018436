"""Small folders in the layouts of other projects' data sets, written file by file after their specifications.

All show the same: a camera that looks at one box, 0.06 x 0.08 x 0.10 m, at 0.6 m, and a second one behind it.
"""

from __future__ import annotations

import io
import json
import struct
import tarfile
import zlib
from pathlib import Path

import cv2
import numpy as np
import OpenEXR
from scipy.io import savemat

WIDTH, HEIGHT = 64, 48
K = np.array([[60.0, 0.0, 31.5], [0.0, 60.0, 23.5], [0.0, 0.0, 1.0]])
SIZE = np.array([0.06, 0.08, 0.10])
#: camera_T_object of two objects, OpenCV's axes [m].
POSES = (
    np.array([[1.0, 0.0, 0.0, -0.1], [0.0, 0.0, -1.0, 0.02], [0.0, 1.0, 0.0, 0.6], [0.0, 0.0, 0.0, 1.0]]),
    np.array([[0.6, -0.8, 0.0, 0.12], [0.0, 0.0, -1.0, 0.0], [0.8, 0.6, 0.0, 0.7], [0.0, 0.0, 0.0, 1.0]]),
)
#: Signs of a box's corners in Blender's order.
BLENDER_CORNERS = ((-1, -1, -1), (-1, -1, 1), (-1, 1, 1), (-1, 1, -1), (1, -1, -1), (1, -1, 1), (1, 1, 1), (1, 1, -1))
#: Pixels of the two objects.
AREAS = ((slice(18, 33), slice(18, 26)), (slice(18, 30), slice(38, 46)))


def picture(seed: int = 0, width: int = WIDTH, height: int = HEIGHT) -> np.ndarray:
    """Return a picture in red, green and blue that tells its channels apart."""
    rng = np.random.Generator(np.random.PCG64(seed))
    return rng.integers(0, 256, (height, width, 3), np.uint8)


def plain(seed: int) -> np.ndarray:
    """Return a picture of the size that TODD and ClearPose have, of few colours, which is written fast."""
    found = np.zeros((480, 640, 3), np.uint8)
    found[:, :, 0], found[:200, :, 1] = 10 * seed, 50
    return found


def depth() -> np.ndarray:
    """Return the depth of the scene [m], with a hole."""
    Z = np.full((HEIGHT, WIDTH), 0.9, np.float32)
    for area, pose in zip(AREAS, POSES, strict=True):
        Z[area] = pose[2, 3] - 0.03
    Z[:3, :5] = 0.0
    return Z


def ids() -> np.ndarray:
    """Return 0, and 1 and 2 for the objects."""
    found = np.zeros((HEIGHT, WIDTH), np.uint8)
    for number, area in enumerate(AREAS, start=1):
        found[area] = number
    return found


def save(path: Path, pixels: np.ndarray) -> None:
    """Write a picture, red first."""
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), pixels[..., ::-1] if pixels.ndim == 3 else pixels)


def save_exr(path: Path, channels: dict[str, np.ndarray]) -> None:
    """Write an EXR file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    stored = {name: OpenEXR.Channel(np.ascontiguousarray(values)) for name, values in channels.items()}
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, stored).write(str(path))


def save_json(path: Path, data: object) -> None:
    """Write JSON."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(data), encoding="utf-8")


def indexed_png(indices: np.ndarray, palette: list[tuple[int, int, int]]) -> bytes:
    """Return a PNG file with palette indices (PNG specification, colour type 3, no filter)."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width = indices.shape
    rows = b"".join(b"\0" + row.astype(np.uint8).tobytes() for row in indices)
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0))
    colours = chunk(b"PLTE", bytes(value for colour in palette for value in colour))
    return b"\x89PNG\r\n\x1a\n" + head + colours + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def world_T_camera(index: int) -> np.ndarray:
    """Return the poses of cameras that see the same scene from several places."""
    angle = 0.2 * index
    turn = np.eye(4)
    turn[:3, :3] = [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    turn[:3, 3] = [0.1 * index, 0.05 * index, 0.3]
    return turn


def seen_from(index: int) -> list[np.ndarray]:
    """Return camera_T_object of the two objects, which stand still, from camera `index`; camera 0 sees `POSES`."""
    back = np.linalg.inv(world_T_camera(index)) @ world_T_camera(0)
    return [back @ pose for pose in POSES]


def keypose(root: Path, frames: int = 2, obj: str = "bottle_0", sequence: str = "texture_5_pose_0") -> Path:
    """Write a sequence of KeyPose with its model; return its folder."""
    folder = root / obj / sequence
    points = np.array([[0.0, 0.0, 0.048], [0.0, 0.0, -0.038]])  # in the frame of the model
    for number in range(frames):
        save(folder / f"{number:06d}_L.png", picture(number))
        save(folder / f"{number:06d}_R.png", picture(number + 100))
        save(folder / f"{number:06d}_mask.png", (ids() == 1).astype(np.uint8) * 255)
        save_exr(folder / f"{number:06d}_Do.exr", {"D" if number else "R": depth()})
        save_exr(folder / f"{number:06d}_Dt.exr", {"R": np.where(depth() < 0.7, np.nan, depth()).astype(np.float32)})
        left = np.linalg.inv(world_T_camera(number))
        for eye, shift in (("L", 0.0), ("R", 0.12)):
            pose = left.copy()
            pose[0, 3] -= shift
            seen = (POSES[0] @ np.column_stack([points, np.ones(2)]).T).T[:, :3] - [shift, 0.0, 0.0]
            (folder / f"{number:06d}_{eye}.pbtxt").write_text(_key_targets(pose, seen))
    _keypose_model(root / "objects" / f"{obj}.obj", points)
    return folder


def _key_targets(camera_T_world: np.ndarray, points: np.ndarray) -> str:
    elements = "\n".join(f"    element: {value:.9g}" for value in camera_T_world.reshape(-1))
    camera = (
        f"  camera {{\n    fx: {K[0, 0]}\n    fy: {K[1, 1]}\n    cx: {K[0, 2]}\n    cy: {K[1, 2]}\n"
        f"    baseline: 0.12\n    resx: {WIDTH}.0\n    resy: {HEIGHT}.0\n  }}"
    )
    lines = []
    for point in points:
        u, v, _ = K @ point / point[2]
        lines.append(f"  keypoints {{\n    u: {u:.9g}\n    v: {v:.9g}\n    z: {point[2]:.9g}\n    visible: 1.0\n  }}")
    return f"kp_target {{\n  transform {{\n{elements}\n  }}\n{camera}\n" + "\n".join(lines) + "\n}\n# an end\n"


def _keypose_model(path: Path, points: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    lines = ["o mesh", *(f"v {x} {y} {z}" for x, y, z in corners * SIZE / 2.0)]
    for number, point in enumerate(points):
        lines += [f"o kp.{number:03d}", *(f"v {x} {y} {z}" for x, y, z in point + corners * 0.001)]
    path.write_text("\n".join(lines) + "\n")


def bop_records(index: int = 0) -> tuple[dict, list, list]:
    """Return camera, ground truth and information of one image in BOP's units."""
    world = np.linalg.inv(world_T_camera(index))
    camera = {
        "cam_K": K.reshape(-1).tolist(),
        "depth_scale": 0.1,
        "cam_R_w2c": world[:3, :3].reshape(-1).tolist(),
        "cam_t_w2c": (world[:3, 3] * 1000).tolist(),
    }
    gt = [
        {"obj_id": n, "cam_R_m2c": pose[:3, :3].reshape(-1).tolist(), "cam_t_m2c": (pose[:3, 3] * 1000).tolist()}
        for n, pose in enumerate(seen_from(index), start=1)
    ]
    info = []
    for rows, columns in AREAS:
        box = [columns.start, rows.start, columns.stop - 1 - columns.start, rows.stop - 1 - rows.start]
        info.append({"bbox_visib": box, "visib_fract": 1.0})
    return camera, gt, info


def bop_models(root: Path) -> None:
    """Write ``models_info.json``: object 1 turns about y and is off its frame's origin, object 2 has a half turn."""
    half = np.diag([-1.0, -1.0, 1.0, 1.0])
    middle = {"x": 5.0, "y": 10.0, "z": -20.0}
    box = {f"size_{axis}": 1000 * side for axis, side in zip("xyz", SIZE, strict=True)}
    low = {f"min_{axis}": middle[axis] - box[f"size_{axis}"] / 2 for axis in "xyz"}
    centred = {f"min_{axis}": -box[f"size_{axis}"] / 2 for axis in "xyz"}
    turning = {"symmetries_continuous": [{"axis": [0, 1, 0], "offset": [5, 10, -20]}]}
    info = {
        "1": {"diameter": 141.0, **box, **low, **turning},
        "2": {"diameter": 141.0, **box, **centred, "symmetries_discrete": [half.reshape(-1).tolist()]},
    }
    save_json(root / "models" / "models_info.json", info)


def bop(root: Path, images: int = 2, split: str = "train_pbr") -> Path:
    """Write a scene in BOP's layout; return its folder."""
    folder = root / split / "000001"
    records = [bop_records(index) for index in range(images)]
    for place, name in enumerate(("scene_camera", "scene_gt", "scene_gt_info")):
        save_json(folder / f"{name}.json", {str(n): records[n][place] for n in range(images)})
    for number in range(images):
        save(folder / "rgb" / f"{number:06d}.png", picture(number))
        save(folder / "depth" / f"{number:06d}.png", np.rint(depth() * 10000).astype(np.uint16))
        for index in range(len(POSES)):
            mask = (ids() == index + 1).astype(np.uint8) * 255
            save(folder / "mask_visib" / f"{number:06d}_{index:06d}.png", mask)
    bop_models(root)
    return folder


def bop_shards(root: Path, images: int = 2, split: str = "train_pbr") -> Path:
    """Write a shard in BOP's web format; return it."""
    path = root / split / "shard-000000.tar"
    path.parent.mkdir(parents=True, exist_ok=True)
    with tarfile.open(path, "w") as file:

        def add(name: str, content: bytes) -> None:
            member = tarfile.TarInfo(name)
            member.size = len(content)
            file.addfile(member, io.BytesIO(content))

        for number in range(images):
            key, (camera, gt, info) = f"000001_{number:06d}", bop_records(number)
            coded = cv2.imencode(".png", picture(number)[..., ::-1])[1].tobytes()
            add(f"{key}.rgb.png", coded)
            levels = np.rint(depth() * 10000).astype(np.uint16)
            add(f"{key}.depth.png", cv2.imencode(".png", levels)[1].tobytes())
            masks = {str(n): _run_lengths(ids() == n + 1) for n in range(len(POSES))}
            parts = {"camera": camera, "gt": gt, "gt_info": info, "mask_visib": masks}
            for name, data in parts.items():
                add(f"{key}.{name}.json", json.dumps(data).encode())
    save_json(root / split / "key_to_shard.json", {f"000001_{n:06d}": 0 for n in range(images)})
    bop_models(root)
    return path


def _run_lengths(mask: np.ndarray) -> dict:
    flat = mask.T.reshape(-1)
    ends = np.flatnonzero(np.diff(flat)) + 1
    counts = np.diff(np.array([0, *ends.tolist(), len(flat)])).tolist()
    return {"size": list(mask.shape), "counts": counts if not flat[0] else [0, *counts]}


def trans10k(root: Path, version: int) -> Path:
    """Write two pictures of Trans10K; return the folder of the first split."""
    for split in ("train", "test"):
        save(root / split / "images" / "1.jpg", picture())
        if version == 1:
            levels = np.stack([np.array([0, 255, 255])[ids()], *[np.array([0, 0, 255])[ids()]] * 2], axis=-1)
            save(root / split / "masks" / "1_mask.png", levels.astype(np.uint8))
        else:
            palette = [(7 * n, 255 - 3 * n, n) for n in range(12)]
            path = root / split / "masks_12" / "1_mask.png"
            path.parent.mkdir(parents=True)
            path.write_bytes(indexed_png(np.array([0, 7, 11], np.uint8)[ids()], palette))
    return root / "train"


def transcg(root: Path) -> Path:
    """Write a scene of TransCG with two perspectives of each camera; return its folder."""
    save_json(root / "metadata.json", {"total_scenes": 1, "perspective_num": 2, "train": [1], "test": []})
    (root / "camera_intrinsics").mkdir()
    for number, name in ((1, "D435"), (2, "L515")):
        np.save(root / "camera_intrinsics" / f"{number}-camIntrinsics-{name}.npy", K)
    lists = {"D435_valid_perspective_list": [0, 1], "L515_valid_perspective_list": [1]}
    save_json(root / "scene1" / "metadata.json", {"type": "isolated", "split": "train", **lists})
    for perspective in (0, 1):
        for number, steps in ((1, 1000), (2, 4000)):
            folder = root / "scene1" / str(perspective)
            save(folder / f"rgb{number}.png", picture())
            for end in ("", "-gt"):
                save(folder / f"depth{number}{end}.png", np.rint(depth() * steps).astype(np.uint16))
            save(folder / f"depth{number}-gt-mask.png", (ids() > 0).astype(np.uint8) * 255)
    return root / "scene1"


def todd(root: Path, views: int = 2) -> Path:
    """Write views of TODD, of its size; return the folder of the first."""
    for number in range(views):
        folder = root / "train" / f"{1622673245.25 + 30 * number}"
        save(folder / "image.jpg", plain(number))
        large = cv2.resize(ids(), (640, 480), interpolation=cv2.INTER_NEAREST)
        save(folder / "instance_segment.png", np.stack([large * 10] * 3, axis=-1))
        Z = cv2.resize(depth(), (640, 480), interpolation=cv2.INTER_NEAREST)
        save_exr(folder / "depth.exr", {"R": np.where(Z == 0, np.inf, Z).astype(np.float32)})
        save_exr(folder / "detph_GroundTruth.exr", {"R": Z})
        poses = {str(n): {"pose": pose[:3].tolist(), "type": "beaker"} for n, pose in enumerate(seen_from(number))}
        save_json(folder / "pose_type.json", poses)
    return sorted((root / "train").iterdir())[0]


def clearpose(root: Path, frames: int = 3, inverse: bool = False, classes: tuple[int, int] = (7, 205)) -> Path:
    """Write a scene of ClearPose; its cameras' poses are to the world, or their inverse; return its folder."""
    folder = root / "set4" / "scene1"
    captured = np.array([[902.19, 0.0, 662.35], [0.0, 902.39, 372.23], [0.0, 0.0, 1.0]])
    records = {}
    for number in range(frames):
        save(folder / f"{number:06d}-color.png", plain(number))
        labels = cv2.resize(ids(), (640, 480), interpolation=cv2.INTER_NEAREST)
        save(folder / f"{number:06d}-label.png", np.array([0, *classes], np.uint8)[labels.astype(int)])
        Z = np.rint(cv2.resize(depth(), (640, 480), interpolation=cv2.INTER_NEAREST) * 1000).astype(np.uint16)
        save(folder / f"{number:06d}-depth_true.png", Z)
        save(folder / f"{number:06d}-depth.png", np.where(labels > 0, 0, Z).astype(np.uint16))
        pose = world_T_camera(number)
        records[f"{number:06d}"] = {
            "cls_indexes": np.array(classes)[:, None],
            "intrinsic_matrix": captured,
            "factor_depth": 1000,
            "rotation_translation_matrix": (np.linalg.inv(pose) if inverse else pose)[:3],
            "poses": np.stack([p[:3] for p in seen_from(number)], axis=-1),
        }
    savemat(folder / "metadata.mat", records)
    return folder


def syn_todd(root: Path, cameras: int = 3, inverse: bool = False) -> Path:
    """Write a raw scene of Syn-TODD as Blender would; return its folder."""
    folder, record = root / "1234", {}
    blender = np.diag([1.0, -1.0, -1.0, 1.0])
    corners = np.array(BLENDER_CORNERS) * SIZE / 2.0
    names = ("transparent_vessel_with_a_name_longer_than_forty", "bowl")
    for number in range(cameras):
        base = folder / f"Camera_{number}_EmptyVessel_Frame_0_"
        save(Path(f"{base}RGB_L.jpg"), picture(number))
        save(Path(f"{base}RGB_R.jpg"), picture(number + 50))
        save_exr(Path(f"{base}Depth.exr"), {"G": depth()})
        pose = world_T_camera(number) @ blender
        entry = {
            "camera_intrinsic": (K + np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])).tolist(),
            "camera_extrinsic": (np.linalg.inv(pose) if inverse else pose).tolist(),
            "baseline": 0.065,
        }
        for index, name in enumerate(names):
            box = (blender @ seen_from(number)[index] @ np.column_stack([corners, np.ones(8)]).T).T[:, :3]
            entry[name] = {"3dbox": {"camera_frame": box.tolist()}}
            codes = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
            codes[ids() == index + 1] = 206
            codes[ids() == 2 - index] = (177, 0, 7)
            save(folder / f"segmentation_Camera_{number}_{name[:38]}_visible_L.png", codes)
        record[f"Camera_{number}"] = entry
    save_json(folder / "BoundingBox.json", record)
    return folder


def ttd(root: Path) -> Path:
    """Write a pair of TTD; return its folder of benchmarks."""
    values = ", ".join(f"{value:.6f}" for value in K.reshape(-1))
    (root / "models").mkdir(parents=True)
    (root / "cameras_params.yml").write_text(
        f"%YAML:1.0\n---\nK: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ {values} ]\n"
    )
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    rows = "\n".join(f"{500 * SIZE[0] * x + 7} {500 * SIZE[1] * y} {500 * SIZE[2] * z}" for x, y, z in corners)
    head = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    (root / "models" / "glass.ply").write_text(head + rows + "\n")
    save(root / "scene" / "left.png", picture(1))
    save(root / "scene" / "right.png", picture(2))
    save(root / "scene" / "mask.png", (ids() == 1).astype(np.uint8) * 255)
    turn = ", ".join(str(value) for value in POSES[0][:3, :3].reshape(-1))
    shift = ", ".join(str(value) for value in POSES[0][:3, 3])
    (root / "scene" / "pose.yaml").write_text(f"rotation: {{data: [{turn}]}}\ntranslation: {{data: [{shift}]}}\n")
    hidden = {"poses": {"left_camera": None}, "masks": {"left_camera": None}}
    seen = {"poses": {"left_camera": "scene/pose.yaml"}, "masks": {"left_camera": "scene/mask.png"}}
    pair = {"left_camera": "scene/left.png", "right_camera": "scene/right.png"}
    folder = root / "default_benchmarks" / "stereo" / "mixed"
    save_json(folder / "train.json", [{"stereo_images": pair, "ground_truth": {"glass": seen, "coffee_cup": hidden}}])
    return folder


def dreds(root: Path, captured: bool) -> Path:
    """Write a picture of DREDS, or of STD, whose pictures are twice as large as its labels; return its folder."""
    folder = root / ("test_0" if captured else "00000")
    scale = 2 if captured else 1
    save(folder / "0000_color.png", picture(0, WIDTH * scale, HEIGHT * scale))
    large = cv2.resize(depth(), (WIDTH * scale, HEIGHT * scale), interpolation=cv2.INTER_NEAREST)
    index = np.array([255, 1, 2], np.uint8)[ids()]
    if captured:
        save(folder / "0000_mask.png", index)
        save_exr(folder / "0000_depth_415.exr", {"R": large})
        save_exr(folder / "0000_gt_depth.exr", {"R": depth()})
    else:
        save_exr(folder / "0000_mask.exr", {name: (index / 255.0).astype(np.float32) for name in "RGB"})
        save_exr(folder / "0000_simDepthImage.exr", {"R": large})
        save_exr(folder / "0000_depth_120.exr", {"R": depth()})
    pose = "1 0 0 0 -0.1 0.02 0.6"
    (folder / "0000_meta.txt").write_text(f"1 1 02876657 model-a 0.2 2 {pose}\n2 6 03797390 model-b 0.1 3 {pose}\n")
    return folder
