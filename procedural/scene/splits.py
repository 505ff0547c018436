"""Training, validation and test splits of scenes, vessel families and files.

A split depends on the seed and the scene's number only, so scenes keep their splits when a data set grows.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from typing import Literal, TypeVar

from pydantic import Field, model_validator

from ...core.errors import InputError
from ...core.model import Model
from ...core.randomness import stream

Split = Literal["train", "val", "test"]
T = TypeVar("T")


class SplitSettings(Model):
    """How scenes are split, and what only scenes of the test split show."""

    val: float = Field(default=0.1, ge=0.0, le=1.0, description="Probability that a scene is in the validation split")
    test: float = Field(default=0.1, ge=0.0, le=1.0, description="Probability that a scene is in the test split")
    unseen_families: int = Field(
        default=0, ge=0, le=27, description="Number of vessel families that only test scenes show (no others)"
    )
    unseen_assets: float = Field(
        default=0.0,
        ge=0.0,
        lt=1.0,
        description="Fraction of each folder's files that only test scenes use (no others)",
    )

    @model_validator(mode="after")
    def _fractions_fit(self) -> SplitSettings:
        if self.val + self.test > 1.0:
            raise ValueError(f"test: expected at most 1 together with val ({self.val}), found {self.test}")
        return self


def split_of(settings: SplitSettings, seed: int, scene_id: int) -> Split:
    """Return the split of a scene."""
    u = float(stream(seed, scene_id, "split").uniform())
    if u < settings.test:
        return "test"
    return "val" if u < settings.test + settings.val else "train"


def families_of(settings: SplitSettings, seed: int, split: Split, families: Sequence[T]) -> tuple[T, ...]:
    """Return the vessel families of a split, in their order.

    Raises
    ------
    InputError
        Where all families would be unseen.
    """
    count = settings.unseen_families
    if not count:
        return tuple(families)
    if count >= len(families):
        raise InputError("splits.unseen_families", f"fewer than the {len(families)} families", count)
    held = set(stream(seed, 0, "split/families").permutation(len(families))[:count].tolist())
    return tuple(family for i, family in enumerate(families) if (i in held) == (split == "test"))


def files_of(
    settings: SplitSettings, seed: int, split: Split, files: Sequence[T], name: Callable[[T], str]
) -> tuple[T, ...]:
    """Return the files of a split, in their order.

    Parameters
    ----------
    settings : SplitSettings
        The fraction of files for the test split.
    seed : int
        Of the data set.
    split : str
        Of the scene.
    files : sequence
        All files of a folder.
    name : callable
        File -> its path below the folder; the choice follows from the names and the seed.

    Raises
    ------
    InputError
        Where a folder has one file only.
    """
    if not settings.unseen_assets or not files:
        return tuple(files)
    if len(files) < 2:
        raise InputError("splits.unseen_assets", "folders of two files or more", f"one with {name(files[0])} alone")
    count = min(max(1, round(settings.unseen_assets * len(files))), len(files) - 1)
    ranked = sorted(files, key=lambda file: hashlib.sha256(f"{seed}/{name(file)}".encode()).digest())
    held = {name(file) for file in ranked[:count]}
    return tuple(file for file in files if (name(file) in held) == (split == "test"))
