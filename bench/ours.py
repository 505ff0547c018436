"""Our renderer as the comparisons drive it: load once, render with any number of samples, denoise, take the time."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from unittest.mock import patch

import numpy as np
from references import PASS_SPP, Reference, reference
from scenes import digest

from glassware.procedural.description.material import OpaqueMaterial
from glassware.procedural.description.scene import Scene
from glassware.render.backend.variant import activate
from glassware.render.pictures.picture import PATH_TRACER, Tracer, denoise_image, trace_picture
from glassware.render.scene import bodies
from glassware.render.scene.loaded_scene import LoadedScene, load

#: Samples of the picture that compiles the kernels.
_WARM_UP = 1


@dataclass(frozen=True, eq=False)
class Rendered:
    """One picture and what it took."""

    noisy: np.ndarray  #: (H, W, 3) float32, linear radiance
    clean: np.ndarray | None  #: (H, W, 3) float32; None where no denoiser ran
    trace_seconds: float
    denoise_seconds: float

    @property
    def denoised(self) -> np.ndarray:
        """The picture after the denoiser; ValueError where none ran."""
        if self.clean is None:
            raise ValueError("this picture was not denoised")
        return self.clean


@dataclass(frozen=True, eq=False)
class Ours:
    """A scene loaded and its kernels compiled."""

    kernel: LoadedScene
    load_seconds: float
    compile_seconds: float


def loaded(scene: Scene, plain: bool = False, cut: bool = False) -> Ours:
    """Load a scene and compile its kernels.

    Parameters
    ----------
    scene : Scene
        The scene; its first camera is used.
    plain : bool
        Draw every opaque surface as an ideal diffuser of its base colour. Two renderers then mean the same by it.
    cut : bool
        Load it so that light can be stored on its surfaces.
    """
    activate()
    start = perf_counter()
    with _plain_materials() if plain else nullcontext():
        kernel = load(scene, for_cache=cut)
    load_seconds = perf_counter() - start
    ours = Ours(kernel, load_seconds, 0.0)
    start = perf_counter()
    render(ours, _WARM_UP, seed=0)
    return replace(ours, compile_seconds=perf_counter() - start)


def render(ours: Ours, spp: int, seed: int, clean: bool = True, tracer: Tracer = PATH_TRACER) -> Rendered:
    """Render the left eye of the first camera with `spp` samples."""
    scene = ours.kernel.description
    picture = scene.picture.model_copy(update={"spp": spp, "noise": None})
    kernel = replace(ours.kernel, description=scene.model_copy(update={"picture": picture}))
    start = perf_counter()
    noisy = trace_picture(kernel, scene.cameras[0], "left", seed, tracer)
    traced = perf_counter()
    denoised = denoise_image(noisy) if clean else None
    return Rendered(noisy.radiance, denoised, traced - start, perf_counter() - traced)


def our_reference(ours: Ours, folder: Path, spp: int, plain: bool) -> Reference:
    """Return the converged picture of a loaded scene, from the folder as far as it is there."""
    scene = ours.kernel.description
    exposure = scene.cameras[0].exposure
    path = folder / f"ours-{'plain-' if plain else ''}{digest(scene)}.npz"
    return reference(path, spp, lambda seed: render(ours, PASS_SPP, seed, clean=False).noisy * exposure)


def _plain_materials() -> AbstractContextManager[object]:
    # The product has one opaque material, the principled one. This swaps it while a scene is loaded.
    return patch.object(bodies, "opaque_bsdf", _diffuse(bodies.opaque_bsdf))


def _diffuse(principled: Callable[[OpaqueMaterial], dict]) -> Callable[[OpaqueMaterial], dict]:
    def diffuse(material: OpaqueMaterial) -> dict:
        colour = principled(material)["base_color"]
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": colour}}

    return diffuse
