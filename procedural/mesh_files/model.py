"""What a mesh file holds, in its own axes and unit."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ...core.errors import InputError, cause_of
from ..description.material import PictureTexture, UniformTexture, VertexColours
from .inside import may_read

#: Most triangles and most vertices of one file [1]. A prop fills a view of some megapixels, and one of two million
#: triangles takes about 1 GB while it is read.
MOST_FACES, MOST_VERTICES = 2_000_000, 6_000_000
#: Largest file [bytes]: above what `MOST_FACES` triangles take as text, with texture coordinates and normals.
LARGEST_FILE = 512 * 2**20
#: First bytes of the text that stands for a file in a checkout without Git LFS.
_LFS_POINTER = b"version https://git-lfs"
#: Longest path that the text of a link has [bytes] (PATH_MAX of Linux).
_LONGEST_LINK = 4096


@dataclass(frozen=True)
class GlassLook:
    """What a file says of a transparent surface."""

    index: float = 1.5  #: refractive index; 1.5 is the default of KHR_materials_ior
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)  #: transmittance after `distance`, linear Rec.709
    distance: float = float("inf")  #: [unit of the file]


@dataclass(frozen=True, eq=False)
class Cutout:
    """Where a surface is cut away: the opacity of a picture."""

    opacity: np.ndarray  #: (h, w) float32 in [0, 1], first row at the top
    threshold: float  #: below it there is no surface


@dataclass(frozen=True)
class Glow:
    """What a file says of the light that a surface sends out."""

    texture: PictureTexture | UniformTexture
    strength: float  #: factor on the texture [1]; 1 is the white of the screen that the file was made at


@dataclass(frozen=True)
class Look:
    """The material of a part; what the file does not say is None."""

    name: str = ""
    texture: PictureTexture | UniformTexture | VertexColours | None = None
    roughness: float | None = None
    metallic: float | None = None
    maps: dict[str, object] = field(default_factory=dict)  #: further fields of `OpaqueMaterial`
    glass: GlassLook | None = None
    cutout: Cutout | None = None
    plain: tuple[float, float, float] | None = None  #: colour where there are no texture coordinates for a picture
    glow: Glow | None = None
    #: Of the pictures, in OBJ files: factors on u and v, and what is added to them then.
    placement: tuple[float, float, float, float] = (1.0, 1.0, 0.0, 0.0)

    @property
    def is_bare(self) -> bool:
        """Whether the file says nothing of the colour."""
        return self.texture is None and self.glass is None


@dataclass(frozen=True, eq=False)
class FilePart:
    """The faces of a file that have one material."""

    vertices: np.ndarray  #: (n, 3) float64, axes and unit of the file
    faces: np.ndarray  #: (m, 3) int64
    look: Look = Look()
    normals: np.ndarray | None = None  #: (n, 3) float64
    uv: np.ndarray | None = None  #: (n, 2) float64, v upwards
    colours: np.ndarray | None = None  #: (n, 3) float64, linear Rec.709

    def moved(self, pose: np.ndarray) -> FilePart:
        """Return the part after an affine (4, 4) transform; one that mirrors turns the faces over."""
        linear = pose[:3, :3]
        normals = self.normals
        with np.errstate(all="ignore"):
            if normals is not None:
                # Normals transform by the cofactors, which exist where the inverse does not.
                normals = normals @ _cofactors(linear).T
            mirrored = np.linalg.det(linear) < 0.0
            vertices = self.vertices @ linear.T + pose[:3, 3]
        faces = self.faces[:, ::-1] if mirrored else self.faces
        if mirrored and normals is not None:
            normals = -normals
        return replace(self, vertices=vertices, faces=faces, normals=normals)


@dataclass(frozen=True)
class Notes:
    """What reading a file finds on the way: lines for the user, and further files that were looked for."""

    remarks: list[str] = field(default_factory=list)
    others: list[Path] = field(default_factory=list)
    facts: dict[str, str] = field(default_factory=dict)  #: such as the licence that the file states

    def say(self, line: str) -> None:
        """Add a remark, once."""
        if line not in self.remarks:
            self.remarks.append(line)


@dataclass(frozen=True)
class Source:
    """A mesh file to be read, and what it may use."""

    path: Path
    root: Path  #: the user's folder; no file outside is read
    pictures: Path  #: folder to which pictures inside a file are written
    notes: Notes = field(default_factory=Notes)
    check_pictures: bool = True  #: whether pictures are decoded, so that a broken one is found


def content_of(source: Source) -> bytes:
    """Return a file's bytes; InputError where it cannot be read, is too large, or stands for a file elsewhere."""
    try:
        size = source.path.stat().st_size
        if size > LARGEST_FILE:
            raise InputError(source.path, f"at most {LARGEST_FILE // 2**20} MiB", f"{size // 2**20} MiB")
        content = source.path.read_bytes()
    except OSError as error:
        raise InputError(source.path, "a readable mesh", cause_of(error)) from error
    if not content:
        raise InputError(source.path, "a mesh", "an empty file")
    check_fetched(source.path, content)
    target = _link_in_text(source.path, content)
    if target is None:
        return content
    if not may_read(target, source.root):
        raise InputError(source.path, "a mesh", f"the text of a link to {target}, which is not in {source.root}")
    return target.read_bytes()


def text_of(content: bytes) -> str:
    """Return the text of an OBJ or MTL file: UTF-8 or UTF-16, or, where it is neither, Windows-1252 and Latin-1."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", "replace")
    for encoding in ("utf-8-sig", "cp1252"):
        try:
            return content.decode(encoding)
        except UnicodeDecodeError:
            continue
    return content.decode("latin-1")


def check_fetched(path: Path, content: bytes) -> None:
    """Refuse what stands for a file in a checkout without Git LFS."""
    if content.startswith(_LFS_POINTER):
        raise InputError(path, "the file itself", "a pointer of Git LFS (git lfs pull gets the file)")


def _link_in_text(path: Path, content: bytes) -> Path | None:
    """Return the target of a link that a checkout without links has stored as text; None for any other file."""
    if len(content) > _LONGEST_LINK or b"\n" in content.rstrip(b"\n") or b" " in content or b"\0" in content:
        return None
    text = content.decode("utf-8", "replace").strip()
    if "/" not in text or Path(text).suffix.lower() != path.suffix.lower():
        return None
    return Path(os.path.normpath((path.parent / text).absolute()))


def check_counts(path: Path, faces: int, vertices: int = 0) -> None:
    """Refuse a file of more triangles or vertices than are read, before memory is taken for them."""
    for count, most, what in ((faces, MOST_FACES, "faces"), (vertices, MOST_VERTICES, "vertices")):
        if count > most:
            raise InputError(path, f"at most {most:,} {what}", f"{count:,}; simplify the mesh")


def _cofactors(linear: np.ndarray) -> np.ndarray:
    a, b, c = linear
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)])
