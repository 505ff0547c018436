from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from glassware.dataset.builds.build_log import BuildLog
from glassware.dataset.builds.messages import Attempt
from glassware.dataset.format.checksums import write_checksums

#: Text that would be markup, were it not escaped.
MARKUP = "<script>document.title='run'</script> & \"co\""


class Page(HTMLParser):
    """The rows of the tables of a page by the id of their card, and what the page refers to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.text = text
        self.rows: dict[str, list[list[str]]] = {}
        self.tags: list[str] = []
        self.references: list[str] = []
        self._card, self._cell = "", False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        self.tags.append(tag)
        self.references += [value or "" for name, value in attrs if name in ("src", "href", "srcset", "action")]
        if "card" in (found.get("class") or "").split():
            self._card = found["id"] or ""
            self.rows[self._card] = []
        if tag == "tr":
            self.rows[self._card].append([])
        if tag in ("td", "th"):
            self.rows[self._card][-1].append("")
            self._cell = True

    def handle_endtag(self, tag: str) -> None:
        if tag in ("td", "th"):
            self._cell = False

    def handle_data(self, data: str) -> None:
        if self._cell:
            self.rows[self._card][-1][-1] += data

    def statistics(self, card: str) -> dict[str, float]:
        """Return the numbers below a histogram by their headings."""
        names, texts = self.rows[card]
        return {name: float(text.replace(",", "")) for name, text in zip(names, texts, strict=True)}

    def counts(self, card: str) -> dict[str, int]:
        """Return a card's counts by name."""
        return {row[0]: int(row[1].replace(",", "")) for row in self.rows[card]}


@dataclass(frozen=True)
class Files:
    """A data set as plain JSON files."""

    root: Path

    @property
    def scenes(self) -> list[Path]:
        return sorted((self.root / "scenes").iterdir())

    @property
    def views(self) -> list[Path]:
        return [view for scene in self.scenes for view in sorted(scene.glob("[0-9]*"))]

    def read(self, path: Path, name: str) -> Any:
        return json.loads((path / name).read_text("utf-8"))

    def change(self, path: Path, change: Callable[[Any], Any]) -> None:
        """Change the data of a file in place."""
        data = json.loads(path.read_text("utf-8"))
        change(data)
        path.write_text(json.dumps(data), "utf-8")

    def add_scene(self, number: int) -> Path:
        """Add a copy of scene 0 with another number."""
        folder = self.root / "scenes" / f"{number:06d}"
        shutil.copytree(self.root / "scenes" / "000000", folder)

        def renumber(data: dict) -> None:
            for row in data["views"]:
                row["scene_id"] = number

        self.change(folder / "views.json", renumber)
        return folder


@pytest.fixture
def files(copy) -> Files:
    """Three scenes, of which two are changed copies, with a log, splits, and names that could be markup."""
    found = Files(copy)
    for number in (1, 2):
        _change_scene(found, found.add_scene(number), 1.0 + number)
    found.change(copy / "dataset.json", _changed_head)
    splits = {"schema_version": "glassware/splits/1", "train": [0, 2], "val": [], "test": [1]}
    splits |= {"unseen_families": ["vase"], "unseen_assets": {"mesh_dir": ["cup.obj"]}}
    (copy / "splits.json").write_text(json.dumps(splits), "utf-8")
    with BuildLog(copy) as log:
        log.add_attempt(Attempt(scene=0, state="failed", reason="no light"), 1)
        log.add_attempt(Attempt(scene=0, state="made", total=5.0, seconds={"picture": 4.0, "labels": 1.0}), 2)
        log.add_attempt(Attempt(scene=1, state="made", total=3.0, seconds={"picture": 2.0, "labels": 1.0}), 1)
        log.add_attempt(Attempt(scene=4, state="failed", reason=MARKUP, peak=900.0), 1)
    return found


def _change_scene(files: Files, folder: Path, factor: float) -> None:
    """Change exposure, sizes, a family and the pile, so that scenes differ."""
    files.change(folder / "views.json", lambda data: _piled(data, int(factor)))
    files.change(folder / "scene.json", lambda data: _changed_scene(data, factor))
    files.change(folder / "objects.json", lambda data: _changed_objects(data, factor))
    for view in folder.glob("[0-9]*"):
        files.change(view / "camera.json", lambda data: data.update(exposure=data["exposure"] * factor))
    (folder / "checksums.json").unlink()
    write_checksums(folder)


def _changed_scene(data: dict, factor: float) -> None:
    """Change the exposure, put prints on the table, and say that contents and places were drawn again."""
    data["table"]["prints"] = [{"kind": kind} for kind in ("mat", "sheet", "sheet")[: int(factor)]]
    for camera in data["cameras"]:
        camera["exposure"] *= factor
    data["vessels"][0].update(redrawn=2, category=MARKUP)
    data["placed_again"] = 3


def _changed_objects(data: dict, factor: float) -> None:
    """Change sizes, a family and a medium, so that scenes differ."""
    vessel, prop = data["objects"][0], data["objects"][-1]
    vessel["category"] = MARKUP
    vessel["size"] = [side * factor for side in vessel["size"]]
    prop["mechanics"]["whole"]["mass"] *= factor


def _piled(data: dict, attempt: int) -> None:
    data["rest"] = {"attempt": attempt, "fell_again": 2 * attempt, "seconds": 4.0, "moved": 0.0, "contacts": []}


def _changed_head(data: dict) -> None:
    data.update(name=MARKUP, scenes="0:5", config={"spp": 1})
    data["findings"] = [
        {"folder": "mesh_dir", "path": MARKUP, "reason": "expected a mesh, found none", "used": False},
        {"folder": "mesh_dir", "path": "cup.obj", "reason": "no unit", "used": True},
    ]


@pytest.fixture
def page() -> Callable[[Path], Page]:
    """An HTML file -> what is on it."""
    return lambda path: Page(path.read_text("utf-8"))
