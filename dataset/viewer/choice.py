"""Which scenes and views of a data set are shown: few enough for a file of bounded size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...core.errors import InputError
from ..preview.contact_sheet import chosen_views
from ..reader import Dataset, StoredScene, StoredView


@dataclass(frozen=True)
class Choice:
    """A scene and the views of it that are shown."""

    scene: StoredScene
    views: tuple[StoredView, ...]

    def following(self, place: int) -> StoredView | None:
        """Return the view after one, the first after the last; None where there is no other."""
        return self.views[(place + 1) % len(self.views)] if len(self.views) > 1 else None


def chosen(dataset: Dataset, wanted: Sequence[int], most: int) -> list[Choice]:
    """Return scenes with at most so many views in all, evenly spaced: of many scenes the first view of each.

    Parameters
    ----------
    dataset : Dataset
        The data set.
    wanted : sequence of int
        The scenes; all where it is empty.
    most : int
        Most views.

    Raises
    ------
    InputError
        Where a scene is missing, or there is none.
    """
    scenes = [dataset.scene(number) for number in wanted] if wanted else list(dataset.scenes)
    if not scenes:
        raise InputError(dataset.root, "a data set with scenes", "none")
    scenes = [scenes[place] for place in chosen_views(len(scenes), most)]
    found = []
    for place, scene in enumerate(scenes):
        limit = most // len(scenes) + (place < most % len(scenes))
        views = scene.views
        if not views:
            raise InputError(scene.folder, "views", "none")
        found.append(Choice(scene, tuple(views[number] for number in chosen_views(len(views), limit))))
    return found
