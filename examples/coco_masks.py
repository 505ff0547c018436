"""Write the masks and boxes of a data set as a COCO file, which detectors such as Mask R-CNN are trained from.

    .venv/bin/build-dataset --count 20 --out data
    .venv/bin/python examples/coco_masks.py data [--out data/coco.json] [--vessels-only]

Each object of each view is one annotation. Its mask is what no opaque surface hides: what is visible, and what is seen
through glass. Masks are run-length codes of COCO, as `pycocotools` reads them.
`glassware export --format coco` does this for large data sets, with amodal masks, keypoints and splits.
"""

from __future__ import annotations

import json
import sys
from argparse import ArgumentParser
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pycocotools import mask as coco

import glassware as gw
from glassware.annotate.labels import ObjectLabel
from glassware.core.exit_codes import run_command
from glassware.dataset.reader import Dataset, StoredScene


def main() -> None:
    """Read the data set and write the file."""
    parser = ArgumentParser(description="Write the masks of a data set as a COCO file.")
    parser.add_argument("data", type=Path, help="folder of the data set")
    parser.add_argument("--out", type=Path, help="by default coco.json in the data set")
    parser.add_argument("--vessels-only", action="store_true", help="leave out what is not glass")
    given = parser.parse_args()
    file = coco_file(gw.Dataset.open(given.data), given.data, given.vessels_only)
    out = given.out or given.data / "coco.json"
    out.write_text(json.dumps(file), "utf-8")
    print(f"{out}: {len(file['images'])} images, {len(file['annotations'])} objects of {len(file['categories'])} kinds")


def coco_file(dataset: Dataset, root: Path, vessels_only: bool) -> dict[str, Any]:
    """Return images, annotations and categories as COCO names them; ids count from 1."""
    images, annotations, categories = [], [], {}
    of_views = [(view, glass_ids(scene)) for scene in dataset.scenes for view in scene.views]
    for number, (view, glass) in enumerate(of_views, start=1):
        camera = view.camera()
        name = (view.folder / "left.png").relative_to(root).as_posix()
        images.append({"id": number, "file_name": name, "width": camera.width, "height": camera.height})
        for label in shown(view.labels().objects, glass if vessels_only else None):
            category = categories.setdefault(label.category, len(categories) + 1)
            entry = annotation(label) | {"id": len(annotations) + 1, "image_id": number, "category_id": category}
            annotations.append(entry)
    kinds = [{"id": number, "name": name} for name, number in categories.items()]
    return {"images": images, "annotations": annotations, "categories": kinds}


def glass_ids(scene: StoredScene) -> set[int]:
    """Return the ids of the objects of glass; others are props, and straws, caps and prints of vessels."""
    return {record.id for record in scene.objects().objects if record.material.kind == "glass"}


def shown(labels: tuple[ObjectLabel, ...], chosen: set[int] | None) -> Iterator[ObjectLabel]:
    """Yield the objects of which anything can be seen; with ids, only those."""
    for label in labels:
        if annotation(label)["area"] and (chosen is None or label.id in chosen):
            yield label


def annotation(label: ObjectLabel) -> dict[str, Any]:
    """Return mask, area [px] and box (x, y, width, height) [px] of an object."""
    code: Any = {"size": list(label.mask_seen.size), "counts": label.mask_seen.counts}
    return {"segmentation": code, "area": int(coco.area(code)), "bbox": coco.toBbox(code).tolist(), "iscrowd": 0}


if __name__ == "__main__":
    sys.exit(run_command(main))
