"""The files of a view that are written on request (``--write``), and what each takes on the disk.

Every view has ``camera.json``, ``labels.json``, ``left.png``, ``right.png``, ``geometry.exr`` and ``instances.png``:
pictures, depth, normals, ids, masks, poses and boxes, with which networks are trained. The rest is many times larger:

================  ========================================================================================
``radiance``      ``left.exr`` and ``right.exr``: linear radiance
``noisy``         the same files: radiance before the denoiser; in part the same numbers, so it takes less
``layers``        ``layers.exr``: every surface along the straight rays
``refraction``    ``refraction.exr``: end points of refracted rays
``right-labels``  ``right_labels.json``, ``right_geometry.exr``, ``right_instances.png``: the right camera's
``disparity``     ``disparity.exr`` of both cameras, and ``pair.png``: whether the other camera sees it too
``heatmap``       ``heatmap.png``: where objects are, as the networks learn it
``coordinates``   ``coordinates.exr``: object coordinates of first surfaces and back walls
``vessel-parts``  ``vessel_parts.png``: glass, wet wall, liquid surface, content, opening
``mattes``        ``mattes.exr`` and ``cryptomatte.exr``: soft edges, and what each object lets through
``infrared``      ``ir_left.png``, ``ir_right.png``: a depth camera's infrared pictures, with `sensors.depth`
================  ========================================================================================
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Annotated, Literal, get_args

from pydantic import BeforeValidator

from ...core.setting_errors import shortened, suggest

FileKind = Literal[
    "radiance",
    "noisy",
    "layers",
    "refraction",
    "right-labels",
    "disparity",
    "heatmap",
    "coordinates",
    "vessel-parts",
    "mattes",
    "infrared",
]
KINDS: tuple[FileKind, ...] = get_args(FileKind)
#: The kinds of data sets that do not say which they have: those of earlier versions.
EARLIER_KINDS: tuple[FileKind, ...] = ("radiance", "noisy", "layers", "refraction")
#: The kinds that the right camera's rays are traced for.
PAIR_KINDS: tuple[FileKind, ...] = ("right-labels", "disparity")
#: The kinds that follow from layers, and are left out where `picture.layers` is 0.
LAYERED: tuple[FileKind, ...] = ("coordinates", "vessel-parts")
#: Words that stand for every kind and for none.
ALL, NONE = "all", "none"
#: What the files of every view take, and those of each kind [bytes per pixel of the left picture]: means of three
#: pairs of preset `fast`, seed 7 (640x480 px, 16 samples, 3 vessels, 7 props), by `bench/labels.py`.
VIEW_BYTES = 4.1
KIND_BYTES: dict[str, float] = {
    "radiance": 6.3,
    "noisy": 6.1,
    "layers": 6.5,
    "refraction": 10.9,
    "right-labels": 2.1,
    "disparity": 2.1,
    "heatmap": 0.6,
    "coordinates": 0.6,
    "vessel-parts": 0.02,
    "mattes": 0.7,
    "infrared": 1.4,
}
#: Description and meshes of a scene [bytes]: of the same scene.
SCENE_BYTES = 4.2e6
#: Pixels of the pictures for which help texts give sizes.
_SHOWN_PIXELS = 640 * 480


def parse_kinds(value: object) -> tuple[str, ...]:
    """Return kinds from a list, or from a text such as ``radiance,layers``, ``all`` or ``none``.

    Raises
    ------
    ValueError
        Where one is unknown; the line lists the known ones.
    """
    words = value.split(",") if isinstance(value, str) else value
    if not isinstance(words, list | tuple) or not all(isinstance(word, str) for word in words):
        raise ValueError(f"expected {_expected()}, found {shortened(value)}")
    if list(words) in ([ALL], [NONE]):
        return KINDS if words[0] == ALL else ()
    for word in words:
        if word in (ALL, NONE):
            raise ValueError(f"expected {word} by itself, found {','.join(words)}")
        if word not in KINDS:
            raise ValueError(f"expected {_expected()}{suggest(word, [*KINDS, ALL, NONE])}, found {shortened(word)}")
    return tuple(kind for kind in KINDS if kind in words)


#: Kinds of files, as a field of a request or of a file.
FileKinds = Annotated[tuple[str, ...], BeforeValidator(parse_kinds)]


def pair_bytes(width: int, height: int, files: Collection[str]) -> float:
    """Return what a stereo pair with its labels is likely to take [bytes]; noisier pictures take more."""
    return width * height * (VIEW_BYTES + sum(KIND_BYTES[kind] for kind in files))


def costs() -> str:
    """Return what each kind takes, for help texts."""
    each = ", ".join(f"{kind} {KIND_BYTES[kind] * _SHOWN_PIXELS / 1e6:.1f}" for kind in KINDS)
    return (
        "Files of each view beside pictures, depth, normals, ids, camera and labels, which take "
        f"{VIEW_BYTES * _SHOWN_PIXELS / 1e6:.1f} MB a pair of 640x480 px; more [MB]: {each}; or all; none by default"
    )


def _expected() -> str:
    return f"some of {', '.join(KINDS)}, or {ALL}, or {NONE}"
