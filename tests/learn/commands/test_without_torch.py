"""The commands that train, evaluate and predict where torch is not installed."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import NamedTuple

import pytest

COMMANDS = ("train", "evaluate", "predict")
#: A Python in which the extra `learn` is not installed: it runs commands and prints their results.
_WITHOUT = """
import contextlib, io, json, sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("torch", "safetensors", "lightning_fabric", "tensorboard"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())
from glassware.dataset.commands.glassware import main
found = []
for arguments in json.loads(sys.argv[1]):
    out, error = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
        try:
            code = main(arguments)
        except SystemExit as stop:
            code = stop.code
    found.append([code, out.getvalue(), error.getvalue()])
print(json.dumps(found))
"""


class Result(NamedTuple):
    code: int
    out: str
    error: str


@pytest.fixture(scope="module")
def results(tmp_path_factory) -> dict[str, Result]:
    """What each command prints, by its arguments: one process for all, as its imports take seconds."""
    given = [[command, "--help"] for command in COMMANDS]
    given += [["train", str(tmp_path_factory.mktemp("data"))], ["completion", "bash"]]
    done = subprocess.run(
        [sys.executable, "-c", _WITHOUT, json.dumps(given)], capture_output=True, text=True, check=True
    )
    found = [Result(*result) for result in json.loads(done.stdout)]
    return dict(zip([*COMMANDS, "work", "completion"], found, strict=True))


@pytest.mark.parametrize("command", COMMANDS)
def test_help_needs_no_torch(results, command):
    code, out, error = results[command]
    assert (code, error) == (0, "")
    assert f"glassware {command}" in out
    assert "--out" in out


def test_work_without_torch_ends_with_a_line_that_says_what_to_install(results):
    assert results["work"].code == 2
    assert results["work"].error.strip() == (
        "glassware train: expected its extra, as in pip install 'glassware[learn]', found no torch, safetensors, "
        "lightning_fabric, tensorboard"
    )


def test_completion_knows_the_options_of_training_without_torch(results):
    assert any("train) echo" in line and "--resume" in line for line in results["completion"].out.splitlines())
