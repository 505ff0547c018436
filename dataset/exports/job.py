"""What an export is asked for, and what every exporter gets."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal, get_args

from pydantic import Field

from ...annotate.labels import Labels, ObjectLabel
from ...core.errors import InputError
from ...core.model import Model
from ...procedural.scene.splits import Split
from ..format import layout
from ..format.objects_file import ObjectsFile
from ..format.split_file import read_splits
from ..reader import Dataset, StoredScene, StoredView

Eyes = Literal["left", "right", "both"]


class ExportOptions(Model):
    """What of a data set is exported, and how; an export folder holds one choice."""

    split: Split | None = Field(default=None, description="Only the scenes of this split; all by default")
    eye: Eyes = Field(default="left", description="Pictures of the left camera, the right one, or both")
    labels: tuple[str, ...] | None = Field(
        default=None, description="Only these of the labels that a format can leave out; all by default"
    )
    vessels_only: bool = Field(default=False, description="Leave out what is not glass: props, straws, caps, prints")
    liquids: bool = Field(
        default=False, description="Of bop and bop-webdataset: liquids as objects of their own beside the glass"
    )
    polygons: bool = Field(default=False, description="Of coco: masks as polygons instead of run lengths")
    layers: bool = Field(default=False, description="Of ply: all surfaces along the rays; needs --write layers")
    licence: str | None = Field(
        default=None, description="Of webdataset: licence of your data set for its card, such as cc-by-4.0"
    )
    copy_pictures: bool = Field(default=False, description="Copy pictures instead of making hard links")


@dataclass(frozen=True)
class Job:
    """An export: from where, to where, and of what."""

    dataset: Dataset
    out: Path
    options: ExportOptions

    def scenes(self) -> tuple[StoredScene, ...]:
        """Return the scenes to export, in the order of their ids; InputError where there is none."""
        split = self.options.split
        found = self.dataset.scenes if split is None else self.dataset.split(split)
        if not found:
            raise InputError(self.dataset.root, f"scenes{'' if split is None else f' of the split {split}'}", "none")
        return found

    def split_of(self, scene_id: int) -> Split:
        """Return the split of a scene; `train` where the data set has no splits or does not name the scene."""
        return self._splits.get(scene_id, "train")

    def splits(self, scenes: Sequence[StoredScene]) -> tuple[Split, ...]:
        """Return the splits that scenes belong to."""
        found = {self.split_of(scene.scene_id) for scene in scenes}
        return tuple(split for split in get_args(Split) if split in found)

    def eyes(self) -> tuple[Literal["left", "right"], ...]:
        """Return the cameras of a pair whose pictures are exported."""
        return ("left", "right") if self.options.eye == "both" else (self.options.eye,)

    def has(self, label: str) -> bool:
        """Return whether one of the labels that a format can leave out is exported."""
        return self.options.labels is None or label in self.options.labels

    @cached_property
    def _splits(self) -> dict[int, Split]:
        if not (self.dataset.root / layout.SPLITS).is_file():
            return {}
        record = read_splits(self.dataset.root)
        return {scene: split for split in get_args(Split) for scene in getattr(record, split)}


@dataclass(frozen=True)
class Exporter:
    """A format: what is written for a scene, and at the end."""

    purpose: str  #: one line for help texts
    place: Callable[[Job, StoredScene], Path]  #: what appears last of a scene's files; a scene that has it is kept
    write: Callable[[Job, StoredScene], None]  #: write the files of a scene
    finish: Callable[[Job, Sequence[StoredScene]], None]  #: write what describes all scenes
    eyes: bool = False  #: whether the format can hold the right camera
    labels: tuple[str, ...] = ()  #: what can be left out, by the names of `--labels`


def write_nothing(job: Job, scenes: Sequence[StoredScene]) -> None:
    """Write nothing at the end: each scene stands by itself."""


def vessel_ids(objects: ObjectsFile) -> set[int]:
    """Return the ids of the transparent objects of a scene."""
    return {record.id for record in objects.objects if record.material.kind == "glass"}


def chosen_ids(job: Job, objects: ObjectsFile) -> list[int]:
    """Return the ids of the objects to export, ascending."""
    vessels = vessel_ids(objects)
    return [record.id for record in objects.objects if not job.options.vessels_only or record.id in vessels]


def chosen_labels(labels: Labels, ids: Sequence[int], view: StoredView) -> Iterator[ObjectLabel]:
    """Yield the labels of objects in the order of their ids; InputError where one has none."""
    by_id = {label.id: label for label in labels.objects}
    for number in ids:
        if number not in by_id:
            raise InputError(view.folder / layout.LABELS, f"an object {number}, as objects.json has it", "none")
        yield by_id[number]
