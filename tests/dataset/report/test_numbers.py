"""The numbers on the page are those of the files, counted here from plain JSON, of other files where there are some."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest

from glassware.dataset.commands.report import main

#: Text of the files that would be markup, were it not escaped (`conftest`).
MARKUP = "<script>document.title='run'</script> & \"co\""
#: Numbers on the page have four digits: they are within half a unit of the last one, at most 5e-4 of the number, and
#: are kept as 32-bit floats, with 6e-8.
DIGITS = 5.1e-4


@pytest.fixture
def shown(files, page):
    """The page of the three scenes."""
    assert main([str(files.root)]) == 0
    return page(files.root / "report.html")


def _counted(files) -> dict[str, list[float]]:
    """Return the numbers of a data set by the ids of their cards, in the units of the page."""
    found: dict[str, list[float]] = {}
    for key, value in _from_scenes(files):
        found.setdefault(key, []).append(value)
    for key, value in _from_views(files):
        found.setdefault(key, []).append(value)
    return found


def _from_scenes(files) -> Iterator[tuple[str, float]]:
    for folder in files.scenes:
        objects = files.read(folder, "objects.json")["objects"]
        scene, photometry = files.read(folder, "scene.json"), files.read(folder, "views.json")["photometry"]
        alone = [item for item in objects if not item.keys() & {"part_of", "within"}]
        vessels = [item for item in alone if item["material"]["kind"] == "glass"]
        yield from (("objects", len(alone)), ("vessels", len(vessels)), ("props", len(alone) - len(vessels)))
        yield "views", len(list(folder.glob("[0-9]*")))
        yield "parts", len(objects) - len(alone)
        yield "illuminance", photometry["illuminance"]
        for body in scene["vessels"]:  # the description, not the records
            if "part_of" not in body and "within" not in body:
                yield "glass_index", body["glass"]["eta"]
                yield "roughness", body["roughness"]
                poured = [liquid for liquid in (body["liquid"], *body.get("layers", ())) if liquid]
                yield from (("liquid_index", one["medium"]["eta"]) for one in poured if not one.get("turbid"))
                if poured:
                    yield "fill", 1e2 * sum(one["fill"] for one in poured)
                    yield "liquid_volume", 1e6 * sum(one["volume"] for one in poured)
        for item in alone:
            if item in vessels:
                yield from (("height", 1e3 * item["size"][2]), ("width", 1e3 * max(item["size"][:2])))
                yield from (("brimful", 1e6 * item["volumes"]["brimful"]),)
            else:
                yield "longest", 1e3 * max(item["size"])
            yield "vessel_mass" if item in vessels else "prop_mass", 1e3 * item["mechanics"]["whole"]["mass"]
        written = [file for file in folder.rglob("*") if file.is_file() and file.name != "checksums.json"]
        yield "bytes", 1e-6 * sum(file.stat().st_size for file in written)


def _from_views(files) -> Iterator[tuple[str, float]]:
    for view in files.views:
        labels = files.read(view, "labels.json")
        seen = [label for label in labels["objects"] if label["fractions"] is not None]
        yield "in_view", len(seen)
        for label in seen:
            yield "visible", 1e2 * label["fractions"]["visible"]
            yield "seen_through", 1e2 * label["fractions"]["seen_through"]
            yield "depth", label["centroid"]["point"][2]
        for eye in ("left", "right"):
            yield "spp", labels[eye]["spp"]
            yield "noise", 1e2 * labels[eye]["noise"]
        if view.name == "000":
            yield "exposure", files.read(view, "camera.json")["exposure"]


def test_distributions_are_those_of_the_files(files, shown):
    expected = _counted(files)
    assert expected["objects"] == [4, 4, 4]
    for card, values in expected.items():
        found = shown.statistics(card)
        assert found["n"] == len(values), card
        for name, value in (
            ("min", min(values)),
            ("5 %", np.percentile(values, 5)),
            ("median", np.median(values)),
            ("mean", np.mean(values)),
            ("95 %", np.percentile(values, 95)),
            ("max", max(values)),
        ):
            assert found[name] == pytest.approx(value, rel=DIGITS, abs=1e-9), (card, name)


def test_no_distribution_on_the_page_is_left_unchecked(files, shown):
    cards = {card for card, rows in shown.rows.items() if rows and rows[0][:2] == ["n", "min"]}
    checked = _counted(files).keys() | {"seconds", "lamp_flux"}
    assert cards <= checked
    assert {"height", "fill", "visible", "depth", "illuminance", "exposure"} <= cards


def test_names_are_counted_as_in_the_descriptions(files, shown):
    scenes = [files.read(folder, "scene.json") for folder in files.scenes]
    vessels = [body for scene in scenes for body in scene["vessels"] if "part_of" not in body]
    props = [item for scene in scenes for item in scene["props"] if not item.keys() & {"part_of", "within"}]
    assert shown.counts("families") == Counter(body["category"] for body in vessels)
    assert shown.counts("walls") == Counter(body["glass"]["name"] for body in vessels)
    assert shown.counts("kinds") == Counter(item["category"] for item in props)
    assert shown.counts("tables") == Counter(scene["table"].get("kind", "plain") for scene in scenes)
    prints = [scene["table"].get("prints", [{"kind": "none"}]) for scene in scenes]
    assert shown.counts("prints") == Counter(item["kind"] for items in prints for item in items)
    assert shown.counts("prints") == {"none": 1, "mat": 2, "sheet": 3}
    assert sum(shown.counts("liquids").values()) == sum(
        1 + len(body.get("layers", ())) for body in vessels if body["liquid"]
    )


def test_files_of_a_kind_take_what_they_take_on_disk(files, shown):
    rows = {row[0]: float(row[1].replace(",", "")) for row in shown.rows["sizes"][1:]}
    for kind in ("left.png", "labels.json", "layers.exr", "scene.json"):
        size = sum(file.stat().st_size for file in (files.root / "scenes").rglob(kind))
        assert rows[kind] == pytest.approx(1e-6 * size, rel=DIGITS)
    meshes = sum(file.stat().st_size for file in (files.root / "scenes").rglob("*.ply"))
    assert rows["meshes"] == pytest.approx(1e-6 * meshes, rel=DIGITS)


def test_time_failures_piles_and_splits_are_those_of_the_log_and_the_records(files, shown):
    assert shown.rows["stages"] == [
        ["stage", "s a scene", "s in all", "of all"],
        ["picture", "3", "6", "75.0 %"],
        ["labels", "1", "2", "25.0 %"],
        ["all", "4", "8", "100.0 %"],
    ]
    facts = {row[0]: row[1] for row in shown.rows["failures"]}
    assert (facts["attempts"], facts["scenes made"], facts["of these after a failure"]) == ("4", "2", "1")
    assert facts["scenes failed"] == "1"
    assert facts["highest memory of a process [MB]"] == "900"
    assert next(row for row in shown.rows["failures"] if row[0] == "4")[1].startswith("<script>")
    assert shown.statistics("seconds")["mean"] == 4.0
    piles = [rest for folder in files.scenes if (rest := files.read(folder, "views.json")["rest"])]
    given_up = sum(rest.get("given_up", False) for rest in piles)
    again = [sum(rest["attempt"] - 1 for rest in piles), given_up, sum(rest["fell_again"] for rest in piles), 4, 6]
    assert [row[1] for row in shown.rows["piles"]] == [f"{len(piles) - given_up} of 3", *map(str, again)]
    assert [row[:2] for row in shown.rows["splits"]][:3] == [
        ["train", "2 (66.7 %)"],
        ["val", "0 (0.0 %)"],
        ["test", "1 (33.3 %)"],
    ]
    assert shown.rows["splits"][4:] == [["vase"], ["mesh_dir: cup.obj"]]
    assert "2 scenes of the data set (0:5) not there" in shown.text


def test_assets_have_their_use_and_their_licences(files, shown):
    used = Counter(item["source"] for folder in files.scenes for item in files.read(folder, "views.json")["assets"])
    assert {row[0]: int(row[2]) for row in shown.rows.get("assets", [])[1:]} == used
    assert shown.rows["passed-over"][1:] == [["mesh_dir", MARKUP, "expected a mesh, found none"]]
    assert shown.rows["remarks"][1:] == [["mesh_dir", "cup.obj", "no unit"]]
