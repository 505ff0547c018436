"""Lay models out as the collections that `glassware assets` knows, and render them: the picture in `docs/assets.md`.

``python bench/gallery_layouts.py FOLDER out.png``: FOLDER holds the models of `BlendSwap-CC-0.sh3f` (CC0), unpacked, of
Debian's `sweethome3d-furniture`. Each of six models is written as one of the collections has it, and the whole folder
is listed by the command.
"""

from __future__ import annotations

import argparse
import gzip
import json
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh

from glassware.dataset.commands.assets import main as assets

#: An identifier of Objaverse and of ShapeNet, and a synset of WordNet (lamp).
UID, SYNSET = "0123456789abcdef0123456789abcdef", "03636649"
#: From y up to z up.
UPRIGHT = trimesh.transformations.rotation_matrix(0.5 * np.pi, [1, 0, 0])


def as_shapenet(model: Path, root: Path) -> None:
    """Write a model as ShapeNetCore.v2 has it: y up, of no size."""
    shutil.copytree(model.parent, folder := root / "shapenet" / SYNSET / UID / "models")
    (folder / model.name).rename(folder / "model_normalized.obj")
    (root / "shapenet" / "taxonomy.json").write_text(json.dumps([{"synsetId": SYNSET, "name": "lamp"}]))


def as_scanned_object(model: Path, root: Path) -> None:
    """Write a model as Google Scanned Objects have it: metres, z up, pictures in another folder."""
    folder = root / "gso" / "Toy_Bear"
    _scaled(model, 0.3).apply_transform(UPRIGHT).export(_made(folder / "meshes") / "model.obj")
    for picture in [*(folder / "meshes").glob("*.png"), *(folder / "meshes").glob("*.jp*g")]:
        picture.rename(_made(folder / "materials" / "textures") / picture.name)
    (folder / "metadata.pbtxt").write_text('categories {\n  first: "Stuffed Toys"\n}\n')


def as_ycb(model: Path, root: Path) -> None:
    """Write a model as YCB has it: metres, z up, several meshes of one object."""
    scene = _scaled(model, 0.2).apply_transform(UPRIGHT)
    for kind in ("google_16k/textured.obj", "tsdf/textured.obj"):
        scene.export(_made((root / "ycb" / "004_ammo_box" / kind).parent) / "textured.obj")


def as_bop(model: Path, root: Path) -> None:
    """Write a model as BOP has it: PLY in millimetres, z up, with colours of its vertices."""
    mesh = _scaled(model, 0.22).apply_transform(UPRIGHT).to_mesh()
    mesh.visual = mesh.visual.to_color()
    mesh.apply_scale(1000.0).export(_made(root / "bop" / "models") / "obj_000001.ply")


def as_objaverse(model: Path, root: Path) -> None:
    """Write a model as Objaverse has it: GLB, y up, its licence in a list."""
    _scaled(model, 0.25).export(_made(root / "objaverse" / "glbs" / "000-000") / f"{UID}.glb")
    with gzip.open(_made(root / "objaverse" / "metadata") / "000-000.json.gz", "wt") as file:
        json.dump({UID: {"license": "cc0"}}, file)


def as_plain(model: Path, root: Path) -> None:
    """Write a model as people have it in a folder: here a GLB file."""
    _scaled(model, 0.12).export(_made(root / "plain") / f"{model.stem}.glb")


LAYOUTS: dict[str, Callable[[Path, Path], None]] = {
    "lantern": as_shapenet,
    "teddyBear": as_scanned_object,
    "ammoBox": as_ycb,
    "basketball": as_bop,
    "cactus": as_objaverse,
    "cupcake": as_plain,
}


def _made(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _scaled(model: Path, longest: float) -> trimesh.Scene:
    """Return a model whose longest side has a length [m]."""
    scene = trimesh.load_scene(model)
    return scene.scaled(longest / float(np.ptp(scene.bounds, axis=0).max()))


def main() -> int:
    """Write the collections, list them, and render the sheet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("path")
    request = parser.parse_args()
    with tempfile.TemporaryDirectory() as root:
        for name, write in LAYOUTS.items():
            write(request.folder / name / f"{name}.obj", Path(root))
        return assets([root, "--sheet", request.path, "--picture-width", "200", "--samples", "32"])


if __name__ == "__main__":
    sys.exit(main())
