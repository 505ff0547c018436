"""The formats, by the names that are typed."""

from __future__ import annotations

from .detection import coco
from .job import Exporter
from .poses import bop, bop_webdataset, syn_todd
from .reconstruction import nerfstudio, ply
from .scenes import gltf, mjcf, urdf, usd
from .shards import webdataset

FORMATS: dict[str, Exporter] = {
    "coco": coco.EXPORTER,
    "bop": bop.EXPORTER,
    "bop-webdataset": bop_webdataset.EXPORTER,
    "gltf": gltf.EXPORTER,
    "mjcf": mjcf.EXPORTER,
    "nerfstudio": nerfstudio.EXPORTER,
    "ply": ply.EXPORTER,
    "syn-todd": syn_todd.EXPORTER,
    "urdf": urdf.EXPORTER,
    "usd": usd.EXPORTER,
    "webdataset": webdataset.EXPORTER,
}
