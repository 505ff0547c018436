"""Render vessels of one's own in scenes of the preset `keypose`: the picture in `docs/assets.md`.

``python bench/gallery_keypose.py FOLDER out.jpg``: FOLDER holds the OBJ files of KeyPose's objects (Liu et al., CVPR
2020). Each stands in a scene of its own, drawn by the preset with a seed of its own, with water up to half of what it
holds; the picture is what the preset's camera sees around it, enlarged so that all objects have about one size.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from time import process_time

import imageio.v3 as iio
import numpy as np

import glassware as gw
from glassware.core.images import srgb8
from glassware.dataset.preview.asset_sheet import asset_sheet
from glassware.procedural.description.camera import Camera
from glassware.procedural.description.scene import GlassBody, Scene

#: Share of a picture's height that the ball around an object takes [1].
SHARE = 0.85
#: Elevations of the cameras, of the preset's: from the side the level of a liquid shows.
ELEVATION = ["20deg", "35deg"]
#: Seeds other than the number of an object: those have a table as bright as the glass.
SEEDS = {"bottle_2": 103, "mug_1": 108}


def main() -> None:
    """Render all objects of the folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("path")
    parser.add_argument("--only", nargs="*", help="names of objects, such as mug_3")
    parser.add_argument("--width", type=int, default=320, help="of each picture [px]; its height is 3/4 of it")
    parser.add_argument("--spp", type=int, default=24, help="samples per pixel")
    parser.add_argument("--light", default="shared", choices=["shared", "path"], help="picture.light")
    request = parser.parse_args()
    pictures, captions = [], []
    for seed, path in enumerate(sorted(request.folder.glob("*.obj"))):
        if request.only and path.stem not in request.only:
            continue
        start = process_time()
        scene = described(path, SEEDS.get(path.stem, seed), request.width, request.spp, request.light)
        frame = gw.Renderer(scene).frame(0)
        pictures.append(srgb8(np.asarray(frame.left, np.float32), scene.cameras[0].exposure, scene.cameras[0].tone))
        captions.append([path.stem])
        sys.stdout.write(f"{path.stem}: {scene.table.kind}, {scene.environment.kind}, {process_time() - start:.1f} s\n")
        sys.stdout.flush()
    iio.imwrite(request.path, asset_sheet(pictures, captions))


def described(path: Path, seed: int, width: int, spp: int, light: str) -> Scene:
    """Return a scene of the preset with one object, seen by one camera that is turned to nothing but it."""
    scene = gw.draw(
        seed,
        preset="keypose",
        vessel_dir=str(path),
        vessels={"fill": 0.5, "fill_probability": 1.0, "liquids": ["water"], "glasses": ["borosilicate glass 3.3"]},
        cameras={"views": 1, "elevation": ELEVATION},
        environment={"shipped_share": 1.0},
        picture={"spp": spp, "light": light, "layers": 0, "refraction": False},
    )
    (body,) = scene.vessels
    return scene.model_copy(update={"cameras": (around(scene.cameras[0], body, width),)})


def around(camera: Camera, body: GlassBody, width: int) -> Camera:
    """Return a camera that shows a part of the picture of another one, larger, with an object in the middle."""
    x, y, z = (np.linalg.inv(camera.world_T_camera) @ body.world_T_object[:, 3])[:3].tolist()
    height = 3 * width // 4
    enlarged = SHARE * height * z / float(np.linalg.norm(body.size)) / camera.focal
    right, down = (side / z * camera.focal * enlarged for side in (x, y))
    return camera.model_copy(
        update={
            "width": width,
            "height": height,
            "focal": camera.focal * enlarged,
            "focal_y": None if camera.focal_y is None else camera.focal_y * enlarged,
            "centre": ((width - 1) / 2 - right, (height - 1) / 2 - down),
        }
    )


if __name__ == "__main__":
    main()
