"""Cycles as the comparisons drive it: a worker under another Python, kept running between pictures."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from types import TracebackType

import numpy as np
import OpenEXR
from picture import Picture

from glassware.core.errors import InputError
from glassware.procedural.description.scene import Scene

from .exchange import write_exchange

#: Where the Python that has `bpy` is found without an argument.
PYTHON_VARIABLE = "GLASSWARE_CYCLES_PYTHON"
_WORKER = Path(__file__).with_name("worker.py")
_LAYER = "ViewLayer"


class Cycles:
    """A scene held by a Cycles worker. Use it as a context: leaving it ends the worker.

    Parameters
    ----------
    python : Path
        A Python with `bpy` 4.5.
    scene : Scene
        What to render (`exchange.write_exchange` has the limits).
    folder : Path
        Where the exchange files, pictures and Blender's log go.
    threads : int
        Threads to render with.
    lambertian : bool
        Whether opaque surfaces are ideal diffusers.
    """

    def __init__(self, python: Path, scene: Scene, folder: Path, threads: int, lambertian: bool) -> None:
        self.scene, self._folder = scene, folder.resolve()
        write_exchange(scene, self._folder, lambertian)
        self._log = (self._folder / "blender.log").open("w", encoding="utf-8")
        self._process = subprocess.Popen(
            [str(python), str(_WORKER), str(self._folder), str(threads)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            text=True,
        )
        ready = self._answer()
        self.version: str = ready["version"]
        self.build_seconds: float = ready["build_seconds"]  #: making Blender's scene from the exchange folder

    def render(self, spp: int, seed: int, denoise: bool = True, threshold: float = 0.0) -> Picture:
        """Render with `spp` samples per pixel, or at most that many with adaptive sampling where `threshold` > 0."""
        file = self._folder / "picture.exr"
        request = {"spp": spp, "seed": seed, "denoise": denoise, "threshold": threshold, "file": str(file)}
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        took = self._answer()
        with OpenEXR.File(str(file), separate_channels=True) as exr:
            channels = {name: channel.pixels for name, channel in exr.channels().items()}
        combined = _rgb(channels, "Combined")
        noisy = _rgb(channels, "Noisy Image") if denoise else combined
        clean = combined if denoise else None
        return Picture(noisy, clean, took["render_seconds"], setup_seconds=took["setup_seconds"])

    def _answer(self) -> dict:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            log = (self._folder / "blender.log").read_text("utf-8", errors="replace").strip().splitlines()
            raise RuntimeError(
                f"the Cycles worker ended with {self._process.wait()}: {log[-1] if log else 'no message'}"
            )
        return json.loads(line)

    def __enter__(self) -> Cycles:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()
        self._log.close()


def cycles_python(given: Path | None) -> Path:
    """Return the Python that has `bpy`: the given one, or the environment variable's.

    Raises
    ------
    InputError
        Where neither names an executable.
    """
    named = given or (Path(os.environ[PYTHON_VARIABLE]) if os.environ.get(PYTHON_VARIABLE) else None)
    if named is None or not os.access(named, os.X_OK):
        raise InputError(f"--cycles-python or {PYTHON_VARIABLE}", "a Python with bpy 4.5", named or "nothing")
    return named


def _rgb(channels: dict[str, np.ndarray], name: str) -> np.ndarray:
    return np.stack([channels[f"{_LAYER}.{name}.{colour}"] for colour in "RGB"], axis=-1)
