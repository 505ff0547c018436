"""Render frames of a stored scene on request and print the time of each: one checkout's half of `frame_speed.py`.

    PYTHON -P bench/render_frames.py SCENE THREADS

It runs under the Python of any checkout, also one before `glassware.Renderer`, so it imports nothing from its
neighbours. It prints the number of views when it has rendered each once, which compiles; then, for each line of
standard input that names a view, one JSON object.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time
from typing import Any


def main() -> None:
    """Render what is asked for, until the input ends."""
    path, threads = Path(sys.argv[1]), int(sys.argv[2])
    views, frame = _renderer(path, threads)
    for view in range(views):
        frame(view)
    print(views, flush=True)  # noqa: T201
    for line in sys.stdin:
        start, start_cpu = perf_counter(), process_time()
        made = frame(int(line))
        found: dict[str, Any] = {"cpu": process_time() - start_cpu, "wall": perf_counter() - start}
        found["digest"] = hashlib.sha256(made.left.tobytes() + made.right.tobytes()).hexdigest()
        print(json.dumps(found), flush=True)  # noqa: T201


def _renderer(path: Path, threads: int) -> tuple[int, Callable[[int], Any]]:
    """Return the number of views, and the function that renders one."""
    try:
        from glassware import Renderer, load_scene
    except ImportError:
        return _old_renderer(path, threads)
    scene = load_scene(path)
    return len(scene.cameras), Renderer(scene, threads=threads).frame


def _old_renderer(path: Path, threads: int) -> tuple[int, Callable[[int], Any]]:
    """Do the same by the functions that `Renderer` replaced."""
    from glassware.procedural.scene_file import load_scene  # pyright: ignore
    from glassware.render.light.scene_light import is_shared, shared_light  # pyright: ignore
    from glassware.render.machine.backend import activate  # pyright: ignore

    scene = load_scene(path)
    activate(spectral=scene.picture.spectral, threads=threads)
    from glassware.render.pictures.picture import PATHS  # pyright: ignore
    from glassware.render.scene.kernel import load  # pyright: ignore
    from glassware.render.view import render_view  # pyright: ignore

    shared = is_shared(scene)
    kernel = load(scene, cut=shared)
    tracer = shared_light(kernel)[0] if shared else PATHS
    return len(scene.cameras), lambda view: render_view(kernel, view, tracer)


if __name__ == "__main__":
    main()
