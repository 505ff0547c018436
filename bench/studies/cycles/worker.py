"""Render a scene with Cycles on request. Runs under Blender's Python, started by `peer.Cycles`.

    python worker.py FOLDER THREADS

Requests come as JSON lines on standard input, ``{"spp": 16, "seed": 1, "denoise": true, "threshold": 0.0, "file":
"/.../a.exr"}``; each is answered with one JSON line. A threshold above 0 turns on adaptive sampling. Blender's own
messages go to standard error.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TextIO

import bpy
from blender_scene import build


def main() -> None:
    """Build the scene, say so, and serve requests until the input ends."""
    answers = _own_standard_output()
    start = time.perf_counter()
    build(Path(sys.argv[1]), int(sys.argv[2]))
    _answer(answers, {"version": bpy.app.version_string, "build_seconds": time.perf_counter() - start})
    for line in sys.stdin:
        _answer(answers, _render(json.loads(line)))


def _own_standard_output() -> TextIO:
    # Blender writes to the file descriptor itself; it gets standard error instead.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    return answers


def _answer(answers: TextIO, content: dict) -> None:
    answers.write(json.dumps(content) + "\n")
    answers.flush()


def _render(request: dict) -> dict:
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = request["spp"], request["seed"]
    scene.cycles.use_denoising = request["denoise"]
    scene.cycles.use_adaptive_sampling = request["threshold"] > 0.0
    scene.cycles.adaptive_threshold, scene.cycles.adaptive_min_samples = request["threshold"], 0
    scene.render.filepath = request["file"]
    begun: list[float] = []
    watcher = _first_sample(begun)
    bpy.app.handlers.render_stats.append(watcher)
    start = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    bpy.app.handlers.render_stats.remove(watcher)
    first, last = begun[0], begun[-1]
    return {"setup_seconds": first - start, "render_seconds": last - first}


def _first_sample(moments: list[float]) -> Callable[[str], None]:
    """Return a handler that notes the times of Cycles' messages from the first sample to the end of the denoiser.

    The message "Sample 0/N" comes when everything is loaded and the tree of triangles is built, "Finished" when the
    denoised picture is there and before the file is written.
    """

    def watch(message: str) -> None:
        if "| Sample 0/" in message or (moments and message.endswith("| Finished")):
            moments.append(time.perf_counter())

    return watch


if __name__ == "__main__":
    main()
