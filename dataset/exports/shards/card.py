"""The card of a data set on the Hugging Face Hub: ``README.md`` with the types of all columns in its YAML.

(huggingface.co/docs/datasets, "Structure your repository", "WebDataset"; docs/hub, "Dataset Cards".)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import yaml

from ....core.errors import InputError
from ....procedural.scene.splits import Split
from ...format.scene_outline import picture_notes
from ...reader import StoredScene
from ..job import Job
from .features import CAMERA, GEOMETRY, OBJECT, Kind, features_yaml
from .sensors import SENSOR_CONFIGS, SETTINGS, sensor_columns

#: The configurations, in the order in which their shards are written; the last two where a data set has such cameras.
CONFIGS = ("pictures", "geometry", *SENSOR_CONFIGS, "labels")
#: Splits by the names that the Hub gives them.
_HUB_SPLITS = {"train": "train", "val": "validation", "test": "test"}
#: What a card says of them.
_SENSOR_NOTES = {
    "sensor": "`sensor_depth.png` is what a depth camera reports, in metres times `unit`, 0 for nothing, in the left "
    "picture's pixels; `sensor_valid.png` says why, by its number among `reasons`.",
    "polarisation": "`stokes.exr` has Stokes vectors that the left camera sees, and `polarisation_mosaic.png` what a "
    "sensor with polarising filters reports.",
}


def columns(job: Job) -> dict[str, dict[str, Kind]]:
    """Return the columns of each configuration with their types; InputError for one that the data set has not."""
    own: dict[str, dict[str, Kind]] = {
        "pictures": {f"{eye}.png": "image" for eye in job.eyes()} | {"camera.json": CAMERA},
        "geometry": {
            "depth.png": "image",
            "instances.png": "image",
            "geometry.exr": "binary",
            "geometry.json": GEOMETRY,
        },
        **sensor_columns(job),
        "labels": {"labels.json": {"objects": [OBJECT]}},
    }
    lacking = next((name for name in job.options.labels or () if name not in own), None)
    if lacking is not None:
        expected = f"labels of cameras that the data set has; {lacking} needs --sensors.{SETTINGS[lacking]}"
        raise InputError("--labels", expected, lacking)
    both: dict[str, Kind] = {"__key__": "string", "__url__": "string"}
    return {config: both | own[config] for config in CONFIGS if config in own and job.has(config)}


def card(job: Job, splits: Sequence[Split], scenes: Sequence[StoredScene]) -> str:
    """Return the text of ``README.md``."""
    head, configs = job.dataset.head, columns(job)
    files = {name: [{"split": _HUB_SPLITS[s], "path": f"{name}/{s}-*.tar"} for s in splits] for name in configs}
    first = next(iter(configs))
    data: dict[str, Any] = {"license": job.options.licence} if job.options.licence else {}
    data |= {
        "pretty_name": head.name,
        "task_categories": ["depth-estimation", "image-segmentation", "object-detection"],
        "tags": ["synthetic", "transparent objects", "stereo", "6d-pose"],
        "configs": [
            {"config_name": name, "data_files": files[name]} | ({"default": True} if name == first else {})
            for name in configs
        ],
        "dataset_info": [{"config_name": name, "features": features_yaml(kinds)} for name, kinds in configs.items()],
    }
    rows = [f"| `{asset.source}` | {asset.licence} | `{asset.sha256[:16]}` |" for asset in head.assets]
    assets = ["| asset file | licence | SHA-256 |", "|---|---|---|", *rows] if rows else ["No asset files were used."]
    lines = [
        f"# {head.name}",
        "",
        f"{len(scenes)} scenes of transparent objects, rendered and labelled by glassware (seed {head.seed}).",
        "Metres and radians, OpenCV camera axes; the centre of pixel (0, 0) is at 0. `depth.png` is the planar depth",
        "of the first surface in steps of `depth_step_mm`, 0 without one. Masks are COCO's compressed run lengths.",
        *(f"Of the pictures: {note}." for note in picture_notes(scene.outline() for scene in scenes)),
        *(_SENSOR_NOTES[name] for name in SENSOR_CONFIGS if name in configs),
        "",
        "`SHA256SUMS` has the digests of all shards, `croissant.json` describes them for programs.",
        "",
        "## Assets",
        "",
        *assets,
    ]
    return "---\n" + yaml.safe_dump(data, sort_keys=False) + "---\n\n" + "\n".join(lines) + "\n"
