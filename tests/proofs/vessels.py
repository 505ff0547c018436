"""Vessels as the product draws them: against a second tracer, and in a white furnace with a picture's own settings."""

from __future__ import annotations

import importlib.util
import sys
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np

from glassware.procedural.description.scene import GlassBody, Scene
from glassware.procedural.optics.medium import Medium
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.render.scene.loaded_scene import RAY_OFFSET

from .bundles import refracted_rays, rows, traced
from .check import EPS, ROUNDINGS, Check, mean_check, single, worst
from .energy import FURNACE_BOUND
from .loading import alone, loaded_scene

#: The second tracer lives with the tests and shares nothing with the product but the triangles.
_TRACER = Path(__file__).resolve().parents[1] / "numpy_tracer.py"
_SEED = 20230213


def second_tracer(rays: int, most: int = 6) -> list[Check]:
    """Send rays through a drawn glass of a liquid and compare with ray-by-ray tracing of its triangles in float64.

    A curved wall magnifies what is rounded before it. How much is measured for each ray by tracing it again in float64,
    moved and turned by what one interface rounds; every interface met may add as much. Rays that meet other surfaces
    when moved so little graze an edge; they are left out, and counted.

    Parameters
    ----------
    rays : int
        Number of rays.
    most : int
        Most interfaces of the rays compared: air, glass, liquid, glass, air, and a base on the way.
    """
    scene = drawn(filled=True)
    kernel = loaded_scene(scene)
    eye, directions = _towards(scene, rays)
    tracer = numpy_tracer()
    limit_interfaces = most + 2
    exact = tracer.trace(scene, eye, directions, limit_interfaces)
    shift = kernel.offset + ROUNDINGS * EPS * kernel.offset / RAY_OFFSET
    near = [tracer.trace(scene, eye + shift * side, directions, limit_interfaces) for side in np.eye(3)]
    turn = ROUNDINGS * EPS
    near += [tracer.trace(scene, eye, directions + turn * side, limit_interfaces) for side in np.eye(3)]
    end = refracted_rays(kernel, eye, directions)
    bounces, instance = np.array(end.bounces), np.array(end.instance)
    steady = np.all([(other.bounces == exact.bounces) & (other.id == exact.id) for other in near], axis=0)
    used = steady & (exact.id > 0) & (exact.bounces >= 4) & (exact.bounces <= most)
    same = (bounces == exact.bounces) & (instance == exact.id)
    moved = sum(np.linalg.norm(other.point - exact.point, axis=1) for other in near)
    landed = np.linalg.norm(rows(end.point) - exact.point, axis=1)
    explained = exact.bounces * moved + 2.0 * shift
    return [
        single(
            "Drawn glass of water: rays that meet what the second tracer's meet",
            100.0,
            100.0 * same[used].mean(),
            100.0 * (1.0 - same[used].mean()),
            "%",
            0.0,
            f"none of {used.sum()} rays may differ; {int((~steady).sum())} of {rays} graze an edge and are left out",
        ),
        worst(
            "Drawn glass of water: landing point, off the second tracer's",
            0.0,
            1e3 * landed[used & same],
            1e3 * explained[used & same],
            "float32 and start offset at each interface, magnified as measured",
            unit="mm",
        ),
    ]


def default_furnace(paths: int, roughness: float) -> list[Check]:
    """Look at drawn vessels of clear media in a white furnace, with the path lengths and roulette of a picture.

    Parameters
    ----------
    paths : int
        Paths at each vessel.
    roughness : float
        GGX roughness of the glass.
    """
    checks = []
    for filled in (False, True):
        scene = _clear(alone(drawn(filled)), roughness)
        eye, directions = _towards(scene, paths)
        found = traced(loaded_scene(scene), eye, directions)
        what = f"rough {roughness:g}" if roughness else "smooth"
        name = f"White furnace: drawn vessel, {what}, {'filled' if filled else 'empty'}, default settings"
        rounding = ROUNDINGS * EPS * found.segments.mean()
        checks.append(mean_check(name, 1.0, found.radiance[:, 0], rounding, FURNACE_BOUND))
    return checks


@cache
def drawn(filled: bool) -> Scene:
    """Return a scene of one vessel on a table, smooth."""
    fill = 1.0 if filled else 0.0
    settings = {
        "vessel_count": (1, 1),
        "prop_count": (0, 0),
        "vessels": {"fill_probability": fill, "chord_error": 5e-5, "rough_probability": 0.0},
        "lights": {"max_count": 0},
        "cameras": {"views": 1, "width": 64, "height": 48},
    }
    return draw_scene(SceneSettings.model_validate(settings), _SEED, 0)


def numpy_tracer() -> ModuleType:
    """Return the module of the second tracer."""
    name = "glassware_second_tracer"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, _TRACER)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
    return sys.modules[name]


def _towards(scene: Scene, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Rays from half a metre away that cover the vessel, from its middle to its silhouette."""
    (vessel,) = scene.vessels
    centre, size = vessel.world_T_object[:3, 3], np.array(vessel.size)
    eye = centre + np.array([0.05, -0.5, 0.3])
    rng = np.random.default_rng(_SEED)
    targets = centre + (rng.random((count, 3)) - 0.5) * size * [0.8, 0.0, 0.8]
    directions = targets - eye
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return eye.astype(np.float32).astype(float), directions.astype(np.float32).astype(float)


def _clear(scene: Scene, roughness: float) -> Scene:
    def medium(item: Medium) -> Medium:
        return item.model_copy(update={"sigma_a": (0.0, 0.0, 0.0), "absorbers": ()})

    def body(item: GlassBody) -> GlassBody:
        liquid = None if item.liquid is None else medium(item.liquid.medium)
        return item.with_media(medium(item.glass), liquid, roughness)

    return scene.model_copy(update={"vessels": tuple(body(item) for item in scene.vessels)})
