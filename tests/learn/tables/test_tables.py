"""The paper's tables: cells, figures, files, and the one command that fills them."""

from __future__ import annotations

import json
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

from glassware.core.errors import InputError
from glassware.core.json_file import parsed, read_json
from glassware.dataset.commands.glassware import main
from glassware.learn.tables.cells import NOT_RUN, experiment_table, latex, markdown
from glassware.learn.tables.comparison import comparison_table
from glassware.learn.tables.experiments import EXPERIMENTS, equal_rows, experiment, row_settings
from glassware.learn.tables.plots import bar_plot, experiment_plots, line_plot
from glassware.learn.tables.runs import Plan, Result, seeded_settings, with_checkpoints
from glassware.learn.training.settings import TrainSettings

#: A report of a network that is told where objects are, and of one that finds them.
TOLD: dict[str, Any] = {
    "keypoints": {"auc": 0.5, "near": 0.25, "mae": 0.0123, "accuracy": list(np.linspace(0.0, 1.0, 21))}
}
TOLD |= {"by_category": {"cup": {"axis_mae": 0.02}}, "kept": {"auc": 0.75}, "dropped": 2, "missed": 0, "lost": 0}
TOLD |= {"unknown": 0}
TOLD["keypoints"]["objects"] = 8
REPORT = {"locations": {"truth": TOLD, "jitter": TOLD}}
FACTS = {"parameters": 0.28, "gmac": 6.04, "seen": 400.0, "evaluated": 8.0}


@pytest.fixture
def plan() -> Plan:
    return Plan(
        experiment="keypose",
        data="0" * 64,
        settings=TrainSettings(),
        seeds=2,
        split="test",
        budget=3.0,
        samples=400,
        seconds={},
        machine="a machine",
    )


@pytest.fixture
def table(plan):
    better = {"locations": {"truth": TOLD | {"keypoints": TOLD["keypoints"] | {"auc": 0.7}}}}
    results = {"keypose": Result((REPORT, better), facts=FACTS), "simnet": Result((), "not run: no stereo")}
    return experiment_table(experiment("keypose"), plan, results)


def test_a_cell_has_our_mean_over_seeds_and_the_papers_figure(table):
    (row,) = (row for row in table.rows if row[0].ours == "KeyPose")
    assert row[1].text() == "60.0 ± 14.1 (paper 90.0)"
    assert row[3].text() == "12.3 ± 0.0 (paper 9.9)"
    assert [cell.ours for cell in row[-5:]] == ["0.28", "6.04", "2", "400", "8"]


def test_what_was_not_run_says_so_and_why(table):
    (row,) = (row for row in table.rows if row[0].ours == "SimNet")
    assert {cell.ours for cell in row[1:]} == {NOT_RUN}
    assert row[1].paper == "87.9"
    assert "SimNet: not run: no stereo" in table.notes
    assert any("0.02 % of the paper's 2,000,000" in note for note in table.notes)
    assert any("2 dropped of 8 objects; without them AUC 75.0 %" in note for note in table.notes)


def test_the_notes_say_what_was_seen_and_which_scenes_were_used(plan):
    def notes(settings: dict, *seen: float) -> str:
        changed = plan.model_copy(update={"settings": TrainSettings.model_validate(settings)})
        names = ("keypose", "simnet")
        results = {name: Result((REPORT,), facts=FACTS | {"seen": n}) for name, n in zip(names, seen, strict=False)}
        return "\n".join(experiment_table(experiment("keypose"), changed, results).notes)

    assert "Each network saw 240 samples, 0.012 %" in notes({}, 240.0)
    assert "Networks saw 240 to 8,000 samples" in notes({}, 240.0, 8000.0)
    assert "Each network saw as many samples as the paper's, 2,000,000" in notes({}, 2e6, 2e6)
    assert "on the split train, chosen by the split val, tested on test; seeds: 2.\n" in notes({}, 1.0)
    assert "on the split all, the last step is taken, tested on test; seeds: 2. TRAINED ON SCENES THAT ARE TESTED." in (
        notes({"train_split": "all", "val_split": "none"}, 1.0)
    )


def test_tables_of_depth_begin_with_what_needs_no_network(plan):
    median = {"rmse": 0.06, "mae": 0.05, "rel": 0.08}
    report = {"floors": {"cleargrasp": {"objects": {"picture_median": median, "semi_global": None}}}}
    results = {"mvtrans-2": Result((report,), facts=FACTS)}
    table = experiment_table(experiment("syn-todd"), plan.model_copy(update={"experiment": "syn-todd"}), results)
    by_title = {row[0].ours: [cell.ours for cell in row[1:]] for row in table.rows[:3]}
    assert by_title["no network: the true median of each picture"][:4] == ["0.060", "0.050", "0.080", "-"]
    assert by_title["no network: semi-global matching of both eyes"][0] == NOT_RUN


def test_the_table_of_keypoints_begins_with_one_answer_for_all_windows(plan):
    constant = {"constant": {"auc": 0.4, "near": 0.1, "mae": 0.0615}}
    report = {
        "locations": {"truth": TOLD | constant, "jitter": TOLD | {"constant": constant["constant"] | {"auc": 0.2}}}
    }
    first, *others = experiment_table(experiment("keypose"), plan, {"keypose": Result((report,), facts=FACTS)}).rows
    assert [cell.ours for cell in first[1:8]] == ["40.0", "10.0", "61.5", "20.0", NOT_RUN, "-", "-"]
    assert not any("no network" in row[0].ours for row in others)


def test_tables_are_written_in_markdown_and_latex(table):
    lines = markdown(table).splitlines()
    rows = [line for line in lines if line.startswith("|")]
    assert len(rows) == len(table.rows) + 2
    assert len({line.count(" | ") for line in rows}) == 1
    text = latex(table)
    assert r"60.0 $\pm$ 14.1 (paper 90.0)" in text
    assert text.count(r"\\") == len(table.rows) + 1
    assert "<2" not in text


def test_the_papers_figures_are_where_the_paper_has_them():
    of = {name: experiment(name) for name in EXPERIMENTS}
    assert of["keypose"].paper["mvtrans-5"] == {"auc": 92.9, "near": 94.0, "mae": 7.2, "ap25": 92.2}
    assert of["syn-todd"].paper["mvtrans-3"]["rmse"] == 0.125
    for what in of.values():
        names = {row.name for row in what.rows}
        columns = {column.name for column in what.columns}
        assert set(what.paper) <= names
        assert all(set(values) <= columns for values in what.paper.values())


def test_a_switch_that_all_rows_have_already_needs_no_run_of_its_own():
    rows = experiment("ablation").rows
    assert equal_rows(rows, TrainSettings()) == {"concat": "base", "linear": "base"}
    common = TrainSettings.model_validate({"network": {"matching": "group", "spacing": "inverse"}})
    assert equal_rows(rows, common) == {"group": "base", "inverse": "base"}


def test_every_row_has_settings_and_sees_equally_many_samples(plan):
    for name in EXPERIMENTS:
        for row in experiment(name).rows:
            chosen = seeded_settings(row, plan, 1, None)
            assert (chosen.steps * chosen.batch, chosen.seed) == (400, 1)
    rows = {row.name: row for row in experiment("keypose").rows}
    rate = TrainSettings().optimiser.learning_rate
    assert row_settings(rows["keypose"], TrainSettings()).optimiser.learning_rate == pytest.approx(rate * 10 / 6)
    assert row_settings(rows["mvtrans-3"], TrainSettings()).views.count == 3


def test_the_plan_knows_which_weights_a_row_was_begun_with(plan, tmp_path):
    first, second = tmp_path / "a.safetensors", tmp_path / "b.safetensors"
    first.write_bytes(b"one")
    second.write_bytes(b"two")
    rows = {row.name: row for row in experiment("keypose").rows}
    told = [rows["keypose"]]
    simnet, all_three = [rows["simnet"]], [*told, rows["simnet"], rows["mvtrans-stereo"]]
    plan = with_checkpoints(plan, tmp_path, all_three, {"simnet": first, "mvtrans-stereo": first})
    assert plan.checkpoints["keypose"] is None
    assert parsed(Plan, read_json(tmp_path / "plan.json"), tmp_path) == plan
    same = tmp_path / "copy.safetensors"
    same.write_bytes(b"one")
    assert with_checkpoints(plan, tmp_path, simnet, {"simnet": same, "mvtrans-stereo": first}) == plan
    again = f"expected simnet={first}, as an earlier call has it (or another --out)"
    told_by = f"expected mvtrans-stereo={first}, as an earlier call has it (or another --out), found none"
    for chosen, given, line in (
        (simnet, {"mvtrans-stereo": first}, f"{again}, found none"),
        (simnet, {"simnet": second, "mvtrans-stereo": first}, f"{again}, found simnet={second}, of other content"),
        (told, {}, told_by),
        (told, {"keypose": second, "mvtrans-stereo": first}, "expected none, as it is trained here (or another --out)"),
    ):
        with pytest.raises(InputError) as error:
            with_checkpoints(plan, tmp_path, chosen, given)
        assert f"plan.json: checkpoints: {line}" in str(error.value)


def test_plots_are_pictures_with_a_line_or_bar_for_each_row(plan):
    plots = experiment_plots(experiment("keypose"), {"keypose": Result((REPORT,), facts=FACTS)})
    assert set(plots) == {"accuracy", "categories"}
    for picture in plots.values():
        assert ElementTree.fromstring(picture).tag.endswith("svg")
    lines = line_plot("a < b", "x", "y", {"one": [(0.0, 0.0), (1.0, 2.0)], "two": [(0.0, 1.0), (1.0, 1.0)]})
    found = ElementTree.fromstring(lines)
    places = [line.attrib["points"].split() for line in found.iter() if line.tag.endswith("polyline")]
    # The first line ends at the top, and begins at the bottom; the second lies half as high.
    tops = [[float(place.split(",")[1]) for place in line] for line in places]
    assert tops[0][0] > tops[1][0] == tops[1][1] > tops[0][1]
    assert tops[1][0] == pytest.approx(sum(tops[0]) / 2)
    assert ElementTree.fromstring(bar_plot("bars", "y", {"one": {"cup": 1.0}, "two": {"mug": 2.0}})) is not None


def test_data_sets_are_counted_from_their_files(rendered):
    table = comparison_table((rendered,))
    name, samples, objects, scenes, annotations, _source = (cell.ours for cell in table.rows[0])
    assert (samples, scenes) == ("10", "2")
    assert "transparent" in objects
    assert "right pictures" in annotations
    assert "depth, normals" in annotations
    assert "refraction" not in annotations
    assert name
    assert any(row[0].ours == "Syn-TODD" and "1,996" in row[3].ours for row in table.rows[1:])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--only", "simnets"], "only: expected rows of keypose: densefusion-true"),
        (["--checkpoints", "simnet"], "checkpoints: expected ROW=PATH with a row of"),
        (["--experiment", "all"], "expected one of keypose, syn-todd, ablation"),
        (["--steps", "5"], "steps: expected --samples or --budget, which say how much each network sees, found 5"),
        (["--checkpoints", "simnet=a", "simnet=b"], "checkpoints: expected one checkpoint of simnet"),
        (["--only", "keypose", "--checkpoints", "simnet=a"], "checkpoints: expected rows that --only names: keypose"),
        (["--budget", "1", "--samples", "100"], "glassware tables: expected --budget or --samples, found both"),
    ],
)
def test_a_wrong_request_is_one_line(rendered, tmp_path, capsys, options, message):
    out = ["--out", str(tmp_path / "out")]
    assert main(["tables", str(rendered), "--experiment", "keypose", *options, *out]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.slow
def test_one_command_fills_the_table_and_goes_on_where_it_stopped(rendered, tiny, tmp_path, capsys):
    network = tiny.model_dump(mode="json") | {"depth_range": None}
    network["keypose"] |= {"crop": [32, 48], "filters": 4}
    settings = {"network": network, "machine": {"accelerator": "cpu", "workers": 0, "threads": 1}, "batch": 2}
    (tmp_path / "run.yaml").write_text(yaml.safe_dump(settings))
    out = tmp_path / "report"
    command = ["tables", str(rendered), "--experiment", "keypose", "--config", str(tmp_path / "run.yaml")]
    command += ["--only", "keypose", "mvtrans-stereo", "--budget", "0.02", "--split", "val", "--out", str(out)]
    assert main(command) == 0
    first = (out / "tables.md").read_text()
    assert "not run (paper 87.9)" in first
    assert ElementTree.fromstring((out / "accuracy.svg").read_text()) is not None
    results = json.loads((out / "results.json").read_text())
    assert set(results["rows"]) == {"keypose", "mvtrans-stereo"}
    assert "detector" in results["rows"]["keypose"]["reports"][0]["locations"]
    capsys.readouterr()
    assert main(command) == 0
    assert "steps" not in capsys.readouterr().out  # nothing is trained again
    assert (out / "tables.md").read_text() == first
    (out / "runs" / "keypose-0" / "report" / "report.json").unlink()
    assert main(command) == 0
    assert (out / "tables.md").read_text() == first
    assert main([*command, "--seeds", "2"]) == 2
    assert "plan.json: expected the plan of the same experiment, with the same seeds (or" in capsys.readouterr().err
    assert main([*command, "--out", str(rendered)]) == 2
    assert "out: expected a folder of its own, found the data set" in capsys.readouterr().err
    # Another table may show as many samples to each network, and take runs of the first.
    number = json.loads((out / "plan.json").read_text())["samples"] + 2
    again = [*command[:6], "--only", "keypose", "--samples", str(number), "--split", "val", "--out", str(out) + "-2"]
    assert main(again) == 0
    assert f"saw {number} samples" in (tmp_path / "report-2" / "tables.md").read_text()
    assert main(again) == 0
    assert main([*again, "--samples", str(number + 2)]) == 2
    capsys.readouterr()
    for options, message in (
        (["--samples", "3"], "samples: expected a multiple of the batch, 2, of 4 or more, found 3"),
        (["--split", "test"], "split test: expected scenes that exist, found none"),
        (
            ["--only", "simnet", "--checkpoints", f"simnet={out}/runs/keypose-0/last.safetensors"],
            "checkpoints: simnet: expected corrected simnet of 2 views, found corrected keypose of 2 views",
        ),
    ):
        assert main([*again[:-2], *options, "--out", str(tmp_path / "report-3")]) == 2
        assert message in capsys.readouterr().err
