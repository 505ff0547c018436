"""What a build takes on the disk and in time: estimated before it begins, measured on its first scene."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ...core.errors import InputError
from ...core.user_text import sized
from ...procedural.scene.settings import SceneSettings
from ..format import layout
from ..format.file_kinds import SCENE_BYTES, FileKinds, pair_bytes

#: Fraction of the free space that a build may fill without being asked: estimates of scenes differ by about a tenth.
FILLED = 0.9
#: Most scenes whose files are counted for the size of a data set, which takes about a millisecond each.
MOST_READ = 500
#: What a user can do.
REMEDY = "fewer scenes, fewer files (--write), another --out, or --yes to go on until the disk is full"


@dataclass(frozen=True)
class Need:
    """What the scenes of a build are likely to take."""

    scenes: int
    pairs: int  #: of all scenes
    each: float  #: what a pair takes, with its part of the scene's own files [bytes]
    free: int  #: on the disk of the output [bytes]

    @property
    def total(self) -> float:
        """What all scenes take [bytes]."""
        return self.pairs * self.each

    @property
    def fits(self) -> bool:
        """Whether they fit on the disk."""
        return self.total <= FILLED * self.free


def estimated(root: Path, settings: SceneSettings, files: FileKinds, scenes: int) -> Need:
    """Return what scenes are likely to take, from their settings alone."""
    cameras, size = settings.cameras, settings.cameras.intrinsics()
    raw = ("radiance",) if settings.sensors.sensitivities != "none" and "radiance" in files else ()  # as much again
    each = pair_bytes(size.width, size.height, (*files, *raw)) + SCENE_BYTES / cameras.views
    return Need(scenes, scenes * cameras.views, each, free_space(root))


def measured(root: Path, scene: int, scenes: int) -> Need:
    """Return what scenes take if each is like one that is on the disk."""
    folder = layout.scene_folder(root, scene)
    views = max(1, len(layout.view_numbers(folder)))
    return Need(scenes, scenes * views, folder_size(folder) / views, free_space(root))


def folder_size(folder: Path) -> int:
    """Return what the files of a folder take [bytes]."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def dataset_size(root: Path, scenes: Sequence[int]) -> float:
    """Return what scenes take [bytes]; of many, by the mean of some that are evenly spaced."""
    chosen = scenes[:: 1 + len(scenes) // MOST_READ]
    return sum(folder_size(layout.scene_folder(root, scene)) for scene in chosen) / len(chosen) * len(scenes)


def free_space(folder: Path) -> int:
    """Return the free space on the disk of a folder, which may not exist yet [bytes]."""
    existing = next(place for place in (folder, *folder.parents) if place.exists())
    return shutil.disk_usage(existing).free


def space_error(root: Path, need: Need) -> InputError:
    """Return the error of a build that does not fit on the disk."""
    space = f"{sized(need.total)} of space for {need.pairs} pairs of {sized(need.each)}"
    return InputError(root, f"{space} ({REMEDY})", sized(need.free))
