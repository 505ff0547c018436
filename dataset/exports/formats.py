"""The formats, by the names that are typed."""

from __future__ import annotations

from . import bop, coco, gltf, nerfstudio, ply, syn_todd, webdataset
from .job import Exporter

FORMATS: dict[str, Exporter] = {
    "coco": coco.EXPORTER,
    "bop": bop.EXPORTER,
    "gltf": gltf.EXPORTER,
    "nerfstudio": nerfstudio.EXPORTER,
    "ply": ply.EXPORTER,
    "syn-todd": syn_todd.EXPORTER,
    "webdataset": webdataset.EXPORTER,
}
