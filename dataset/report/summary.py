"""A data set in numbers, gathered scene by scene: memory holds numbers and names, and the pictures of the gallery."""

from __future__ import annotations

from array import array
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...core.assets import Asset
from ...core.errors import InputError
from ..format import layout
from ..format.dataset_file import DatasetFile, PileCounts, counted_in
from ..format.split_file import SplitsFile, read_splits
from ..preview.contact_sheet import chosen_views
from ..reader import Dataset, StoredScene
from ..settings.scene_ranges import parse_scenes
from .build_record import BuildRecord, build_record
from .facts import SceneFacts, scene_facts
from .thumbnails import Thumbnail, thumbnail

#: Goes through scenes, and may say how far it is.
Each = Callable[[Sequence[int]], Iterable[int]]


@dataclass(frozen=True)
class Summary:
    """What a page shows of a data set."""

    head: DatasetFile
    scenes: int  #: that were read
    missing: int  #: scenes that the data set is meant to hold and are not there
    left_out: Mapping[int, str]  #: reason by scene that is there and could not be read
    numbers: Mapping[str, np.ndarray]  #: (n,) float32 by the keys of `QUANTITIES`, SI units
    names: Mapping[str, Counter[str]]  #: by the keys of `TOPICS`
    sizes: Counter[str]  #: bytes by kind of file
    assets: Mapping[Asset, int]  #: scenes that use each asset
    meshes: Counter[str]  #: objects by mesh file
    piles: PileCounts
    redrawn: int  #: contents of vessels that did not fit, and were drawn again
    placed_again: int  #: how often the objects of a scene did not fit on its table, and were placed again
    turbid: int  #: vessels with a turbid liquid
    layered: int  #: vessels with more than one liquid
    gallery: tuple[Thumbnail, ...]
    record: BuildRecord | None
    splits: SplitsFile | None


@dataclass
class _Sums:
    """What is added up over scenes."""

    scenes: int = 0
    numbers: dict[str, array] = field(default_factory=lambda: defaultdict(lambda: array("f")))
    names: dict[str, Counter[str]] = field(default_factory=lambda: defaultdict(Counter))
    sizes: Counter[str] = field(default_factory=Counter)
    assets: Counter[str] = field(default_factory=Counter)
    known: dict[str, Asset] = field(default_factory=dict)
    meshes: Counter[str] = field(default_factory=Counter)
    piles: PileCounts = field(default_factory=PileCounts)
    redrawn: int = 0
    placed_again: int = 0
    turbid: int = 0
    layered: int = 0


def summarise(dataset: Dataset, most: int, each: Each = iter) -> Summary:
    """Read a data set once, and return what a page shows of it.

    Parameters
    ----------
    dataset : Dataset
        The data set.
    most : int
        Pictures of the gallery at most; they are of evenly spaced scenes.
    each : callable, optional
        Goes through the scenes' numbers, and may show how far it is.

    Raises
    ------
    InputError
        Where ``splits.json`` is damaged. Scenes that cannot be read are left out, and are named in the summary.
    """
    root = dataset.root
    every = layout.scene_ids(root)
    shown = {every[i] for i in chosen_views(len(every), most)} if every and most else set()
    sums, gallery, left_out = _Sums(), [], {}
    for scene_id in each(every):
        scene = dataset.scene(scene_id)
        try:
            facts, picture = scene_facts(scene), _picture(scene, scene_id in shown)
        except InputError as error:  # the others are worth a page; this one is named on it
            left_out[scene_id] = str(error).replace(f"{root}/", "")
            continue
        _add(sums, facts)
        gallery += picture
    record = build_record(root)
    if record is not None:
        sums.numbers["seconds"].extend(record.seconds)
    wanted = set(parse_scenes(dataset.head.scenes, str(root / layout.DATASET)))
    return Summary(
        head=dataset.head,
        scenes=sums.scenes,
        missing=len(wanted - set(every)),
        left_out=left_out,
        numbers={key: np.frombuffer(values, np.float32) for key, values in sums.numbers.items()},
        names=sums.names,
        sizes=sums.sizes,
        assets={sums.known[digest]: count for digest, count in sums.assets.most_common()},
        meshes=sums.meshes,
        piles=sums.piles,
        redrawn=sums.redrawn,
        placed_again=sums.placed_again,
        turbid=sums.turbid,
        layered=sums.layered,
        gallery=tuple(gallery),
        record=record,
        splits=read_splits(root) if (root / layout.SPLITS).is_file() else None,
    )


def _picture(scene: StoredScene, shown: bool) -> list[Thumbnail]:
    return [thumbnail(scene)] if shown else []


def _add(sums: _Sums, facts: SceneFacts) -> None:
    """Add a scene to the sums."""
    sums.scenes += 1
    for key, values in facts.numbers.items():
        sums.numbers[key].extend(values)
    for topic, names in facts.names.items():
        sums.names[topic].update(names)
    sums.sizes.update(facts.sizes)
    for item in facts.assets:
        sums.assets[item.sha256] += 1
        sums.known.setdefault(item.sha256, item)
    sums.meshes.update(facts.meshes)
    sums.piles = counted_in(sums.piles, facts.rest)
    sums.redrawn += facts.redrawn
    sums.placed_again += facts.placed_again
    sums.turbid += facts.turbid
    sums.layered += facts.layered
