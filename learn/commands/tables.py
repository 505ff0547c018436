"""``glassware tables``: the paper's tables, trained, evaluated and written by one command."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import tyro
from pydantic import Field
from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import run_command
from ...core.user_text import UserPath
from ...dataset.settings.config import parse_request
from ..data.splits import SplitName
from ..tables.cells import TableData, experiment_table
from ..tables.comparison import comparison_table
from ..tables.experiments import DETECTOR, Experiment, ExperimentName, Row, equal_rows, experiment
from ..tables.page import write_report
from ..tables.plots import experiment_plots
from ..tables.runs import Plan, Result, check_checkpoint, detector_of, make_plan, run_row, with_checkpoints
from ..training.out_folder import locked_out_folder
from ..training.settings import TrainSettings
from ..training.weights import weights_path

_DESCRIPTION = """Train the networks of one of the paper's tables, evaluate them, and write the table.

  glassware tables --experiment keypose data --config network.yaml --budget 60 --out report
  glassware tables --experiment syn-todd data --config network.yaml --seeds 3 --out report
  glassware tables --experiment keypose data --checkpoints simnet=a.safetensors --only simnet --out report

DATA is a data set with the splits train, val and test. OUT gets tables.md, tables.html, tables.tex, plots and the runs.
A call that was stopped goes on with the same command. With --budget all networks see equally many samples, so many
that the training of all takes that time here; the table says how many."""


class Tables(TrainSettings):
    """Arguments of the command; the settings are those that all rows share."""

    data: tyro.conf.Positional[UserPath | None] = Field(default=None, description="Folder of the data set")
    experiment: ExperimentName = Field(
        default="syn-todd",
        description="keypose: 3D keypoints; syn-todd: depth, boxes and masks; ablation: parts of MVTrans",
    )
    out: UserPath = Field(default=Path("out-tables"), description="Output folder")
    budget: float | None = Field(
        default=None, gt=0.0, description="Minutes of all training together; by default the paper's number of samples"
    )
    samples: int | None = Field(default=None, description="Samples that each network sees, in place of a budget")
    seeds: int = Field(default=1, ge=1, le=100, description="Runs of each row, with seeds of their own")
    split: SplitName = Field(default="test", description="Scenes to evaluate on")
    only: tuple[str, ...] = Field(default=(), description="Rows to run, such as simnet; by default all")
    checkpoints: tuple[str, ...] = Field(
        default=(), description="Checkpoints that are evaluated in place of training, such as simnet=best.safetensors"
    )
    compare: tuple[UserPath, ...] = Field(default=(), description="Other data sets for the table that compares them")
    config: UserPath | None = Field(default=None, description="YAML file of settings")


#: For the completion of shells.
REQUEST = Tables


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _tables(given))


def _tables(arguments: Sequence[str]) -> None:
    request = parse_request(Tables, arguments, "glassware tables", _DESCRIPTION)
    data = _checked(request)
    what = experiment(request.experiment)
    checkpoints = {name: weights_path(path) for name, path in _checkpoints(request, what).items()}
    rows = _rows(request, what)
    for row in what.rows:
        if row.name in checkpoints:
            check_checkpoint(row, _common(request), checkpoints[row.name])
    console = Console()

    def say(line: str) -> None:
        console.print(line, markup=False, highlight=False, soft_wrap=True)

    compared = comparison_table((data, *request.compare))
    with locked_out_folder(request.out, say):
        _fill(request, data, what, rows, checkpoints, compared, say)
    say(f"written to {request.out}/tables.html")


def _fill(
    request: Tables,
    data: Path,
    what: Experiment,
    rows: Sequence[Row],
    checkpoints: Mapping[str, Path],
    compared: TableData,
    say: Callable[[str], None],
) -> None:
    """Run the rows and write the table, in a locked folder."""
    common = _common(request)
    trained = [row for row in rows if row.name not in checkpoints]
    equal = equal_rows(_in_order(trained), common)
    trained = [row for row in trained if row.name not in equal]
    amount = {"budget": request.budget, "samples": request.samples}
    options = {**amount, "seeds": request.seeds, "split": request.split, "rows": trained, "say": say}
    plan = make_plan(what, common, data, request.out, **options)
    plan = with_checkpoints(plan, request.out, rows, checkpoints)
    results: dict[str, Result] = {}
    for row in _in_order(rows):
        if row.name in equal:
            first = equal[row.name]
            reason = f"the settings of {first}, so one run serves both"
            results[row.name] = replace(results[first], reason=results[first].reason or reason)
            continue
        detectors = detector_of(request.out, plan.seeds, checkpoints)
        given = checkpoints.get(row.name)
        results[row.name] = run_row(row, plan, data, request.out, given=given, detectors=detectors, say=say)
        if not results[row.name].reports:
            say(f"{row.title}: {results[row.name].reason}")
        # Written after each row, so that a call that is stopped leaves what it has.
        _write(request.out, what, plan, results, compared)
    _write(request.out, what, plan, results, compared)
    if not any(result.reports for result in results.values()):
        expected = "a row that can be run on this data set"
        raise InputError("glassware tables", expected, "; ".join(result.reason for result in results.values()))


def _common(request: Tables) -> TrainSettings:
    return TrainSettings.model_validate({name: getattr(request, name) for name in TrainSettings.model_fields})


def _checked(request: Tables) -> Path:
    """Return the folder of the data set; InputError where it, or how much is trained, is not said or said twice."""
    if request.data is None:
        raise InputError("glassware tables", "the folder of a data set", "none")
    if request.budget is not None and request.samples is not None:
        raise InputError("glassware tables", "--budget or --samples", "both")
    if request.steps != TrainSettings.model_fields["steps"].default:
        raise InputError("steps", "--samples or --budget, which say how much each network sees", request.steps)
    return request.data


def _write(out: Path, what: Experiment, plan: Plan, results: dict[str, Result], compared: TableData) -> None:
    table = experiment_table(what, plan, results)
    write_report(out, [table, compared], experiment_plots(what, results), plan, results)


def _in_order(rows: Sequence[Row]) -> list[Row]:
    """Return rows in the order of their runs: the detector first, which others need."""
    return sorted(rows, key=lambda row: (row.name != DETECTOR, row.needs_detector))


def _rows(request: Tables, what: Experiment) -> list[Row]:
    names = [row.name for row in what.rows]
    for name in request.only:
        if name not in names:
            raise InputError("only", f"rows of {what.name}: {', '.join(names)}", name)
    return [row for row in what.rows if not request.only or row.name in request.only]


def _checkpoints(request: Tables, what: Experiment) -> dict[str, Path]:
    names, found = [row.name for row in what.rows], {}
    for text in request.checkpoints:
        name, equals, path = text.partition("=")
        if not equals or name not in names:
            raise InputError("checkpoints", f"ROW=PATH with a row of {', '.join(names)}", text)
        if name in found:
            raise InputError("checkpoints", f"one checkpoint of {name}", text)
        if request.only and name not in (*request.only, DETECTOR):
            raise InputError("checkpoints", f"rows that --only names: {', '.join(request.only)}", name)
        found[name] = Path(path)
    return found


if __name__ == "__main__":
    sys.exit(main())
