"""The left eye of a scene's first camera with any number of samples, and the time that it takes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

import mitsuba as mi
from picture import Picture
from references import PASS_SPP, Reference, reference
from scenes import digest

from glassware.procedural.description.scene import Prop, Scene
from glassware.render.backend.variant import activate

# The variant is set before the modules of the renderer are imported: their types depend on it.
VARIANT = activate()
from glassware.render.pictures.picture import PATH_TRACER, Tracer, denoise_image, trace_picture
from glassware.render.scene.bodies import opaque_bsdf
from glassware.render.scene.loaded_scene import LoadedScene, load


@dataclass(frozen=True, eq=False)
class Ours:
    """A loaded scene whose kernels are compiled."""

    loaded: LoadedScene
    load_seconds: float
    compile_seconds: float

    @property
    def exposure(self) -> float:
        """Exposure of the first camera."""
        return self.loaded.description.cameras[0].exposure


def prepare(scene: Scene, lambertian: bool = False, for_cache: bool = False) -> Ours:
    """Load a scene and compile its kernels.

    Parameters
    ----------
    scene : Scene
        The scene; its first camera is used.
    lambertian : bool
        Make every opaque surface an ideal diffuser of its base colour, which two renderers define alike.
    for_cache : bool
        Refine the meshes for the irradiance cache.
    """
    start = perf_counter()
    loaded = load(scene, for_cache=for_cache)
    if lambertian:
        _make_lambertian(loaded)
    ours = Ours(loaded, perf_counter() - start, 0.0)
    start = perf_counter()
    render(ours, 1, seed=0)
    return replace(ours, compile_seconds=perf_counter() - start)


def render(ours: Ours, spp: int, seed: int, denoise: bool = True, tracer: Tracer = PATH_TRACER) -> Picture:
    """Render with `spp` samples per pixel."""
    scene = ours.loaded.description
    picture = scene.picture.model_copy(update={"spp": spp, "noise": None})
    loaded = replace(ours.loaded, description=scene.model_copy(update={"picture": picture}))
    start = perf_counter()
    noisy = trace_picture(loaded, scene.cameras[0], "left", seed, tracer)
    traced = perf_counter()
    clean = denoise_image(noisy) if denoise else None
    end = perf_counter()
    return Picture(noisy.radiance, clean, end - start, end - traced)


def our_reference(
    ours: Ours, folder: Path, spp: int, lambertian: bool = False, tracer: Tracer = PATH_TRACER
) -> Reference:
    """Return the converged picture of a loaded scene; passes that the folder holds are not rendered again."""
    kind = "plain-" if lambertian else "" if tracer is PATH_TRACER else "photons-"
    path = folder / f"ours-{kind}{digest(ours.loaded.description)}.npz"
    return reference(
        path, spp, lambda seed: render(ours, PASS_SPP, seed, denoise=False, tracer=tracer).noisy * ours.exposure
    )


def _make_lambertian(loaded: LoadedScene) -> None:
    """Replace the BSDFs of the opaque bodies, which `load` names body0, body1, ... in the order of the scene."""
    scene, shapes = loaded.description, {shape.id(): shape for shape in loaded.mi_scene.shapes()}
    materials = [scene.table.material]
    for item in scene.objects:
        materials += [item.material] if isinstance(item, Prop) else [None] * len(item.interfaces)
    for number, material in enumerate(materials):
        if material is not None:
            bsdf = {"type": "diffuse", "reflectance": opaque_bsdf(material)["base_color"]}
            shapes[f"body{number}"].set_bsdf(mi.load_dict({"type": "twosided", "bsdf": bsdf}))
