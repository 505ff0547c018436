"""CPU time of a frame, side by side with another checkout: the same stored scene, frames in turn.

    python bench/frame_speed.py --scene DATA/scenes/000000/scene.json --other OTHER/.venv/bin/python

OTHER is a checkout of another commit with its own environment; it may be older than `glassware.Renderer`. One process
of each checkout loads the scene, stores its light where it does, and renders every view once, which compiles. Then
they render the views in turn, one frame at a time and in the opposite order each time, so that whatever else the
machine does meets both. A frame is a stereo view with its geometry, as the scene describes it. A ratio is this
checkout's CPU time over the other's for one such pair of frames.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from statistics import median, quantiles

from command import Output, run
from table import Row, cores, report

from glassware.core.errors import InputError

#: Greatest ratio of CPU times: 2 % slower than the other checkout.
BOUND = 1.02
_CHILD = Path(__file__).with_name("render_frames.py")


@dataclass(frozen=True, kw_only=True)
class Options(Output):
    """What to measure."""

    scene: Path
    """Stored scene, a file scene.json."""
    other: Path
    """Python of the other checkout's environment."""
    pairs: int = 24
    """Timed frames of each checkout; views are rendered in turn."""
    threads: int = cores()
    """Threads of the renderer."""


def main(options: Options) -> int:
    """Measure and print; 1 where the bound is broken."""
    for name, path in (("--scene", options.scene), ("--other", options.other)):
        if not path.is_file():
            raise InputError(name, "a file", str(path))
    pythons = {"this checkout": Path(sys.executable), "the other": options.other}
    # An empty folder: a checkout in the current one is not imported.
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        children = {name: stack.enter_context(_child(python, options, folder)) for name, python in pythons.items()}
        views = {name: int(_answer(child)) for name, child in children.items()}
        found: dict[str, list[dict]] = {name: [] for name in pythons}
        for pair in range(options.pairs):
            for name in sorted(pythons, reverse=bool(pair % 2)):
                found[name].append(_frame(children[name], pair % views[name]))
    return _report(found, options)


def _child(python: Path, options: Options, folder: str) -> subprocess.Popen[str]:
    command = [str(python.absolute()), "-P", str(_CHILD), str(options.scene.resolve()), str(options.threads)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=folder)


def _answer(child: subprocess.Popen[str]) -> str:
    """Return the next line of a process; RuntimeError where it has ended."""
    assert child.stdout is not None
    line = child.stdout.readline()
    if not line:
        raise RuntimeError(f"{child.args}: exit code {child.wait()}")
    return line


def _frame(child: subprocess.Popen[str], view: int) -> dict:
    """Return what a process measured of one frame."""
    assert child.stdin is not None
    child.stdin.write(f"{view}\n")
    child.stdin.flush()
    return json.loads(_answer(child))


def _report(found: dict[str, list[dict]], options: Options) -> int:
    this, other = found["this checkout"], found["the other"]
    ratios = [a["cpu"] / b["cpu"] for a, b in zip(this, other, strict=True)]
    rows = []
    for clock in ("cpu", "wall"):
        rows += [_spread(f"{clock} time of a frame, {name}", [frame[clock] for frame in frames], "s")
                 for name, frames in found.items()]  # fmt: skip
    low, middle, high = quantiles(ratios, n=4)
    note = f"quartiles {low:.4f} and {high:.4f} of {len(ratios)} pairs"
    rows.append(Row("ratio of CPU times, median", middle, bound=BOUND, ok=middle <= BOUND, note=note))
    best = min(frame["cpu"] for frame in this) / min(frame["cpu"] for frame in other)
    rows.append(Row("ratio of the least CPU times", best))
    same = all(a["digest"] == b["digest"] for a, b in zip(this, other, strict=True))
    facts = {"scene": options.scene, "threads": options.threads, "same pictures": same}
    return report("Frames of two checkouts", rows, options.json_file, other=options.other, **facts)


def _spread(name: str, values: list[float], unit: str) -> Row:
    return Row(name, median(values), unit, note=f"min {min(values):.3f}, max {max(values):.3f}")


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
