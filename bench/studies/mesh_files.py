"""Mesh files as glassware reads them against a second reader, trimesh with Pillow: shape and colour.

For each file of a folder that both read, silhouettes along the three axes are compared, and the mean colours of parts
of the same material by area. A file counts as alike where the silhouettes overlap by `LEAST_OVERLAP` and the colours
differ by at most `MOST_DIFFERENCE`; the others are listed with what differs. A file that differs and needs something
that trimesh does not do (`LACKING`) is counted by itself. With `--assimp` it is compared with a third reader, the
command of the Open Asset Import Library (Debian's `assimp-utils`), as OBJ files that it writes.

    python bench/studies/mesh_files.py FOLDER [--assimp assimp]
"""

from __future__ import annotations

import argparse
import logging
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import trimesh

from glassware.core.errors import InputError
from glassware.procedural.description.material import PictureTexture, UniformTexture
from glassware.procedural.materials.picture_files import srgb_to_linear
from glassware.procedural.materials.textures import bake
from glassware.procedural.mesh_files.model import FilePart, Source
from glassware.procedural.mesh_files.read import MESH_SUFFIXES, read_parts

#: Least overlap (intersection over union) of silhouettes of this many pixels a side, and most difference of mean
#: colours, linear [1]: a texel's interpolation and a pixel's edge.
LEAST_OVERLAP, SIDE, MOST_DIFFERENCE = 0.97, 192, 0.04
#: What trimesh does not do, and the text that a file has which needs it. Polygons that are not convex are found apart.
LACKING = {
    "shifted or turned pictures": b"KHR_texture_transform",
    "specular-glossiness": b"KHR_materials_pbrSpecularGlossiness",
    "second texture coordinates": b"TEXCOORD_1",
    "opacity in pictures": b"map_d ",
}
#: How outcomes begin that are counted by themselves.
KINDS = ("alike", "as assimp reads it", "refused", "only read here", "beyond the other reader")


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface as triangles with a colour each."""

    corners: np.ndarray  #: (m, 3, 3)
    colours: np.ndarray  #: (m, 3) linear Rec.709, NaN where the file states none
    names: np.ndarray  #: (m,) names of their materials

    def mean(self, name: str) -> np.ndarray:
        """Mean colour by area of the faces of one material, (3,); NaN where the file states none."""
        area = np.linalg.norm(
            np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0]), axis=1
        )
        known = np.isfinite(self.colours).all(1) & (area > 0) & (self.names == name)
        return np.average(self.colours[known], axis=0, weights=area[known]) if known.any() else np.full(3, np.nan)


def ours(path: Path, root: Path, pictures: Path) -> Surface:
    """Return a file's surface as glassware reads it."""
    parts = read_parts(Source(path, root, pictures))
    return Surface(
        np.concatenate([part.vertices[part.faces] for part in parts]),
        np.concatenate([_our_colours(part) for part in parts]),
        np.concatenate([np.full(len(part.faces), part.look.name, object) for part in parts]),
    )


def _our_colours(part: FilePart) -> np.ndarray:
    texture = part.look.texture
    if isinstance(texture, UniformTexture):
        return np.tile(texture.colour, (len(part.faces), 1))
    if isinstance(texture, PictureTexture) and part.uv is not None:
        return _texels(bake(texture), part.uv[part.faces])
    if part.colours is not None and texture is not None:
        return part.colours[part.faces].mean(1)
    return np.full((len(part.faces), 3), np.nan)


def _texels(pixels: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Return the mean colour of faces (m, 3) at 7 places in each; the first row of pixels is at v = 0."""
    height, width = pixels.shape[:2]
    third, most = 1 / 3, 0.8
    weights = np.array([[third] * 3, *np.roll([[most, 0.1, 0.1]] * 3, 0), [0.1, most, 0.1], [0.1, 0.1, most]])
    places = np.einsum("kc,mcj->kmj", weights, np.nan_to_num(uv)) % 1.0
    columns, rows = (np.clip((places[..., j] * n).astype(int), 0, n - 1) for j, n in ((0, width), (1, height)))
    return pixels[rows, columns].mean(0)


def theirs(path: Path) -> Surface:
    """Return a file's surface as trimesh reads it."""
    scene = trimesh.load_scene(path, process=False)
    corners, colours, names = [], [], []
    for node in sorted(scene.graph.nodes_geometry):
        pose, name = scene.graph[node]
        mesh = scene.geometry[name]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            corners.append(trimesh.transform_points(mesh.vertices, pose)[mesh.faces])
            colours.append(_their_colours(mesh))
            name = getattr(getattr(mesh.visual, "material", None), "name", None) or ""
            names.append(np.full(len(mesh.faces), name, object))
    if not corners:
        raise ValueError("no triangles")
    return Surface(np.concatenate(corners), np.concatenate(colours), np.concatenate(names))


def _their_colours(mesh: trimesh.Trimesh) -> np.ndarray:
    visual: Any = mesh.visual
    material = getattr(visual, "material", None)
    image = getattr(material, "image", None) or getattr(material, "baseColorTexture", None)
    uv = getattr(visual, "uv", None)
    if image is not None and uv is not None:
        pixels = np.asarray(image.convert("RGB"), np.float32)[::-1] / 255.0
        return _texels(srgb_to_linear(pixels), np.asarray(uv)[mesh.faces])
    if material is not None:
        factor = getattr(material, "baseColorFactor", None)
        diffuse = getattr(material, "diffuse", None)
        if factor is None and diffuse is None:
            return np.full((len(mesh.faces), 3), np.nan)
        # A factor of glTF and a Kd are linear here.
        colour = np.asarray(factor if factor is not None else diffuse, float)[:3]
        return np.tile(
            colour / 255.0 if colour.max() > 1.0 or np.asarray(diffuse).dtype == np.uint8 else colour,
            (len(mesh.faces), 1),
        )
    if visual is not None and visual.kind == "vertex":
        return srgb_to_linear(np.asarray(visual.vertex_colors, np.float32)[:, :3] / 255.0)[mesh.faces].mean(1)
    if visual is not None and visual.kind == "face":
        return srgb_to_linear(np.asarray(visual.face_colors, np.float32)[:, :3] / 255.0)
    return np.full((len(mesh.faces), 3), np.nan)


def overlap(one: Surface, other: Surface) -> float:
    """Return the least overlap of the silhouettes along the three axes."""
    low = np.minimum(one.corners.min((0, 1)), other.corners.min((0, 1)))
    extent = float((np.maximum(one.corners.max((0, 1)), other.corners.max((0, 1))) - low).max()) or 1.0
    least = 1.0
    for axis in range(3):
        first, second = (_silhouette(surface, axis, low, extent) for surface in (one, other))
        either = (first | second).sum()
        least = min(least, (first & second).sum() / either if either else 1.0)
    return least


def _silhouette(surface: Surface, axis: int, low: np.ndarray, extent: float) -> np.ndarray:
    flat = np.delete((surface.corners - low) / extent * (SIDE - 1), axis, axis=2)
    picture = np.zeros((SIDE, SIDE), np.uint8)
    for triangle in np.unique(np.round(flat).astype(np.int32), axis=0):
        cv2.fillConvexPoly(picture, triangle, 1)
    return picture.astype(bool)


def lacking(path: Path) -> list[str]:
    """Return what a file needs that the other reader does not do."""
    content = path.read_bytes()
    beside = path.with_suffix(".mtl")
    content += beside.read_bytes() if beside.is_file() else b""
    found = [what for what, text in LACKING.items() if text in content]
    return [*found, "polygons that are not convex"] if path.suffix.lower() == ".obj" and _not_convex(content) else found


def _not_convex(content: bytes) -> bool:
    """Return whether an OBJ file has a flat polygon with a corner that turns the other way."""
    places = np.array([line.split()[1:4] for line in content.splitlines() if line.startswith(b"v ")], dtype=np.float64)
    for line in content.splitlines():
        words = line.split()
        if len(words) < 6 or words[0] != b"f":
            continue
        index = [int(word.split(b"/")[0]) for word in words[1:]]
        ring = places[[k - 1 if k > 0 else k for k in index]]
        sides = np.roll(ring, -1, axis=0) - ring
        turns = np.cross(np.roll(sides, 1, axis=0), sides)
        if (turns @ turns.sum(0) < -1e-6 * np.abs(turns).max() * np.linalg.norm(turns.sum(0))).any():
            return True
    return False


def theirs_by_assimp(command: str, path: Path) -> Surface | None:
    """Return a file's surface as assimp's command reads it and trimesh its OBJ file; None where it fails."""
    with tempfile.TemporaryDirectory() as folder:
        for file in path.parent.iterdir():
            if file.is_file():
                shutil.copy(file, folder)
        out = Path(folder) / "written-by-assimp.obj"  # beside the pictures
        words = [command, "export", str(path), str(out), "--triangulate", "--transform-uv-coords"]
        if subprocess.run(words, capture_output=True, timeout=60, check=False).returncode:
            return None
        materials = out.with_suffix(".mtl")
        if materials.is_file():
            # Names of pictures keep the separators of another system, which trimesh does not know.
            materials.write_text(materials.read_text(errors="replace").replace("\\", "/").replace(" ./", " "))
        return theirs(out)


def compared(path: Path, root: Path, pictures: Path, assimp: str | None = None) -> str:
    """Return "alike", or what differs, or who does not read the file and why."""
    try:
        first = ours(path, root, pictures)
    except InputError as error:
        return f"refused: {error}".replace(f"{path}: ", "")
    try:
        faults = differences(first, theirs(path))
        missing = lacking(path) if faults else []
        outcome = f"beyond the other reader ({', '.join(missing)}): " if missing else ""
        outcome = outcome + "; ".join(faults) or "alike"
    except Exception as error:  # whatever the other reader raises
        outcome = f"only read here ({type(error).__name__})"
    if outcome == "alike" or assimp is None:
        return outcome
    third = theirs_by_assimp(assimp, path)
    if third is None:
        return f"{outcome}; assimp does not read it"
    faults = differences(first, third)
    return f"{outcome}; by assimp: {'; '.join(faults)}" if faults else f"as assimp reads it, by trimesh {outcome}"


def differences(first: Surface, second: Surface) -> list[str]:
    """Return what differs between two readings of a file."""
    faults = []
    if (found := overlap(first, second)) < LEAST_OVERLAP:
        faults.append(f"silhouettes overlap by {found:.3f}")
    for name in sorted(set(first.names) & set(second.names)):
        here, there = first.mean(name), second.mean(name)
        difference = np.abs(here - there).max()
        if np.isfinite(difference) and difference > MOST_DIFFERENCE:
            faults.append(f"{name or 'colour'} {np.round(here, 2).tolist()}, there {np.round(there, 2).tolist()}")
    return faults


def main() -> int:
    """Compare all files of a folder, and print the counts and the differences."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="folder of mesh files, searched with its subfolders")
    parser.add_argument("--assimp", help="command of the Open Asset Import Library, for what trimesh does not do")
    request = parser.parse_args()
    folder = request.folder
    logging.disable()
    files = sorted(path for path in folder.rglob("*") if path.suffix.lower() in MESH_SUFFIXES and path.is_file())
    counts: dict[str, int] = {}
    with tempfile.TemporaryDirectory() as pictures:
        for path in files:
            outcome = compared(path, folder, Path(pictures), request.assimp)
            kind = next((kind for kind in KINDS if outcome.startswith(kind)), "different")
            counts[kind] = counts.get(kind, 0) + 1
            if outcome != "alike":
                sys.stdout.write(f"{path.relative_to(folder)}: {outcome}\n")
    shown = ", ".join(f"{count} {kind}" for kind, count in counts.items())
    sys.stdout.write(f"{len(files)} files: {shown}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
