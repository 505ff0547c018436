"""The formats, by the names that are typed."""

from __future__ import annotations

from .completion import cleargrasp, dreds
from .detection import coco
from .job import Exporter
from .poses import bop, bop_webdataset, keypose, syn_todd
from .reconstruction import nerfstudio, ply
from .scenes import gltf, mjcf, urdf, usd
from .shards import webdataset

FORMATS: dict[str, Exporter] = {
    "coco": coco.EXPORTER,
    "bop": bop.EXPORTER,
    "bop-webdataset": bop_webdataset.EXPORTER,
    "cleargrasp": cleargrasp.EXPORTER,
    "dreds": dreds.EXPORTER,
    "gltf": gltf.EXPORTER,
    "keypose": keypose.EXPORTER,
    "mjcf": mjcf.EXPORTER,
    "nerfstudio": nerfstudio.EXPORTER,
    "ply": ply.EXPORTER,
    "syn-todd": syn_todd.EXPORTER,
    "urdf": urdf.EXPORTER,
    "usd": usd.EXPORTER,
    "webdataset": webdataset.EXPORTER,
}
