"""CPU time of a frame, side by side with another checkout: the same stored scene, alternating processes.

    python bench/frame_speed.py --scene DATA/scenes/000000/scene.json --other OTHER/.venv/bin/python

OTHER is a checkout of another commit with its own environment; it may be older than `glassware.Renderer`. Each repeat
starts one process of each checkout, in the opposite order of the repeat before. A process loads the scene, renders
one frame that compiles the kernels, and then the timed ones. A frame is a stereo view with its geometry, as the scene
describes it. The ratio of a repeat is this checkout's CPU time over the other's, each the mean of its frames.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from statistics import mean, median

from command import Output, run
from rich.console import Console
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
    repeats: int = 5
    """Processes of each checkout."""
    frames: int = 3
    """Timed frames of a process; views are rendered in turn."""
    threads: int = cores()
    """Threads of the renderer."""


def main(options: Options) -> int:
    """Measure and print; 1 where the bound is broken."""
    for name, path in (("--scene", options.scene), ("--other", options.other)):
        if not path.is_file():
            raise InputError(name, "a file", str(path))
    pythons = {"this checkout": Path(sys.executable), "the other": options.other}
    found: dict[str, list[dict]] = {name: [] for name in pythons}
    for repeat in range(options.repeats):
        for name in sorted(pythons, reverse=bool(repeat % 2)):
            Console(stderr=True).print(f"repeat {repeat + 1} of {options.repeats}: {name}", highlight=False)
            found[name].append(_frames(pythons[name], options))
    cpu = {name: [mean(process["cpu"]) for process in processes] for name, processes in found.items()}
    ratios = [a / b for a, b in zip(cpu["this checkout"], cpu["the other"], strict=True)]
    rows = [_spread(f"CPU time of a frame, {name}", values, "s") for name, values in cpu.items()]
    wall = {name: [mean(process["wall"]) for process in processes] for name, processes in found.items()}
    rows += [_spread(f"wall time of a frame, {name}", values, "s") for name, values in wall.items()]
    middle, low, high = median(ratios), min(ratios), max(ratios)
    note = f"min {low:.4f}, max {high:.4f} of {len(ratios)} repeats"
    rows.append(Row("ratio of CPU times, median", middle, bound=BOUND, ok=middle <= BOUND, note=note))
    same = len({process["digest"] for processes in found.values() for process in processes}) == 1
    facts = {"scene": options.scene, "frames": options.frames, "threads": options.threads, "same pictures": same}
    return report("Frames of two checkouts", rows, options.json_file, other=options.other, **facts)


def _frames(python: Path, options: Options) -> dict:
    """Return what one process measured; RuntimeError with its last line where it fails."""
    scene = options.scene.resolve()
    command = [str(python.absolute()), "-P", str(_CHILD), str(scene), str(options.frames), str(options.threads)]
    # An empty folder: a checkout in the current one is not imported.
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    if done.returncode:
        raise RuntimeError(f"{python}: {done.stderr.strip().splitlines()[-1]}")
    return json.loads(done.stdout.splitlines()[-1])


def _spread(name: str, values: list[float], unit: str) -> Row:
    return Row(name, median(values), unit, note=f"min {min(values):.3f}, max {max(values):.3f}")


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
