"""Cycles as the comparisons drive it: a worker under another Python, kept running between pictures."""

from __future__ import annotations

import json
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import numpy as np
import OpenEXR

from glassware.core.errors import InputError
from glassware.procedural.description.scene import Scene

from .exchange import write_exchange

#: Where the Python that has `bpy` is looked for when no argument says so.
PYTHON_VARIABLE = "GLASSWARE_CYCLES_PYTHON"
_WORKER = Path(__file__).with_name("worker.py")
_LAYER = "ViewLayer"


@dataclass(frozen=True, eq=False)
class PeerPicture:
    """One picture by Cycles and what it took."""

    noisy: np.ndarray  #: (H, W, 3) float32, linear radiance
    clean: np.ndarray | None  #: (H, W, 3) float32; None where no denoiser ran
    setup_seconds: float  #: from the request to the first sample
    render_seconds: float  #: tracing and denoising

    @property
    def denoised(self) -> np.ndarray:
        """The picture after the denoiser; ValueError where none ran."""
        if self.clean is None:
            raise ValueError("this picture was not denoised")
        return self.clean


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
    plain : bool
        Whether opaque surfaces are ideal diffusers.
    """

    def __init__(self, python: Path, scene: Scene, folder: Path, threads: int, plain: bool) -> None:
        self._folder = folder.resolve()
        write_exchange(scene, self._folder, plain)
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

    def render(self, spp: int, seed: int, clean: bool = True, threshold: float = 0.0) -> PeerPicture:
        """Render with `spp` samples, or with at most so many and adaptive sampling at a threshold above 0."""
        file = self._folder / "picture.exr"
        request = {"spp": spp, "seed": seed, "denoise": clean, "threshold": threshold, "file": str(file)}
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        took = self._answer()
        with OpenEXR.File(str(file), separate_channels=True) as exr:
            channels = {name: channel.pixels for name, channel in exr.channels().items()}
        combined = _rgb(channels, "Combined")
        noisy = _rgb(channels, "Noisy Image") if clean else combined
        return PeerPicture(noisy, combined if clean else None, took["setup_seconds"], took["render_seconds"])

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


def cycles_python(asked: Path | None) -> Path:
    """Return the Python that has `bpy`: the one asked for, or the environment variable's.

    Raises
    ------
    InputError
        Where neither names an executable.
    """
    named = asked or (Path(os.environ[PYTHON_VARIABLE]) if os.environ.get(PYTHON_VARIABLE) else None)
    if named is None or not os.access(named, os.X_OK):
        raise InputError(f"--cycles-python or {PYTHON_VARIABLE}", "a Python with bpy 4.5", named or "nothing")
    return named


def _rgb(channels: dict[str, np.ndarray], name: str) -> np.ndarray:
    return np.stack([channels[f"{_LAYER}.{name}.{colour}"] for colour in "RGB"], axis=-1)
