"""What a new scene in a running process costs to compile, and a scene in which only numbers changed.

A study: it backs the table "Compiling" of docs/performance.md, last run 2026-11-22. It is not maintained beyond
importing.

    python bench/studies/compilation.py [--scenes 5] [--json FILE]

The kernel cache on the disk starts empty.
"""

from __future__ import annotations

import os
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import thread_time
from typing import TypeVar

import drjit as dr
from pydantic import BaseModel

sys.path.append(str(Path(__file__).resolve().parents[1]))
from command import Output, run
from table import Row, report

from glassware.dataset.settings.config import preset
from glassware.procedural.description.scene import GlassBody, Scene
from glassware.procedural.optics.medium import Medium
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.render.backend.variant import activate
from glassware.render.renderer import Renderer

M = TypeVar("M", bound=BaseModel)
#: Most that the kernels of a new scene may take to compile [s].
BOUND = 0.5
#: Kernels that another size of the picture may cost: copies between arrays, which Dr.Jit writes for one length.
FEW = 3
SEED = 11
#: Pictures only have to be drawn, not to be good: the size and the samples are numbers that no kernel knows.
WIDTH, HEIGHT, SPP = 64, 48, 4


@dataclass(frozen=True)
class Compiled:
    """What one scene cost."""

    kernels: int  #: launched
    new: int  #: that had to be compiled or read from the disk
    seconds: float  #: of code generation and compilation, CPU time of the one thread that does it
    waited: float  #: the same by the clock, which counts what else the machine does
    operations: int  #: of the largest kernel


@dataclass(frozen=True, kw_only=True)
class Options(Output):
    """What to measure."""

    scenes: int = 5
    """Number of scenes."""


def main(given: Options) -> int:
    """Measure and print; 1 where a bound is broken."""
    scenes = [_drawn(number) for number in range(given.scenes)]
    with tempfile.TemporaryDirectory() as folder:
        os.environ["HOME"] = folder  # Dr.Jit keeps its kernels there
        variant = activate()
        dr.set_flag(dr.JitFlag.KernelHistory, True)
        rows = [_row(number, scene) for number, scene in enumerate(scenes)]
        cost = _cost(_other_numbers(scenes[-1]))
    note = f"{cost.waited:.2f} s by the clock, {cost.new} of {cost.kernels} kernels new, at most {FEW}"
    rows.append(Row("the last one with other numbers", cost.seconds, "s", ok=cost.new <= FEW, note=note))
    return report("Compiling kernels", rows, given.json_file, seed=SEED, preset="fast", variant=variant)


def _row(number: int, scene: Scene) -> Row:
    cost = _cost(scene)
    shape = f"{len(scene.vessels)} vessels, {len(scene.props)} props, {len(scene.lights)} lamps"
    note = f"{cost.waited:.2f} s by the clock, {cost.new} of {cost.kernels} kernels new, {cost.operations} ops; {shape}"
    if number == 0:
        return Row("first scene", cost.seconds, "s", note=note)
    ratio, ok = cost.seconds / BOUND, cost.seconds <= BOUND
    return Row(f"new scene {number}", cost.seconds, "s", bound=BOUND, ratio=ratio, ok=ok, note=note)


def _drawn(number: int) -> Scene:
    settings = SceneSettings.model_validate(preset("fast"))
    cameras = settings.cameras.model_copy(update={"views": 1, "width": WIDTH, "height": HEIGHT})
    picture = settings.picture.model_copy(update={"spp": SPP})
    return draw_scene(settings.model_copy(update={"cameras": cameras, "picture": picture}), SEED, number)


def _other_numbers(scene: Scene) -> Scene:
    """Return the scene with another glass, another light, another camera, another picture, another roughness."""
    props = []
    for prop in scene.props:
        material = _copy(prop.material, roughness=0.5 + 0.5 * prop.material.roughness)
        props.append(_copy(prop, material=material))
    lights = []
    for light in scene.lights:
        radiance, size = tuple(0.5 * x for x in light.radiance), (0.5 * light.size[0], light.size[1])
        lights.append(_copy(light, radiance=radiance, size=size))
    camera = scene.cameras[0]
    return _copy(
        scene,
        props=tuple(props),
        lights=tuple(lights),
        cameras=(_copy(camera, exposure=2.0 * camera.exposure, width=WIDTH // 2),),
        picture=_copy(scene.picture, spp=2 * SPP, max_depth=40),
        environment=_copy(scene.environment, strength=0.5),
        vessels=tuple(_denser(vessel) for vessel in scene.vessels),
    )


def _copy(model: M, **update: object) -> M:
    return model.model_copy(update=update)


def _denser(vessel: GlassBody) -> GlassBody:
    def dense(medium: Medium) -> Medium:
        return _copy(medium, eta=1.01 * medium.eta) if medium.eta > 1.0 else medium

    interfaces = tuple(_copy(side, front=dense(side.front), back=dense(side.back)) for side in vessel.interfaces)
    liquid = vessel.liquid and _copy(vessel.liquid, medium=dense(vessel.liquid.medium))
    return _copy(vessel, glass=dense(vessel.glass), liquid=liquid, interfaces=interfaces)


def _cost(scene: Scene) -> Compiled:
    """Return what a scene costs. It is gone before the next one: Dr.Jit compiles for everything that is alive."""
    dr.kernel_history_clear()
    renderer = Renderer(scene)
    first = _frame_seconds(renderer)
    history = [entry for entry in dr.kernel_history() if entry["type"] == dr.KernelType.JIT]
    seconds = max(0.0, first - _frame_seconds(renderer))  # the second time there is nothing to compile
    new = [entry for entry in history if not entry["cache_hit"]]
    waited = sum(entry["codegen_time"] + entry["backend_time"] for entry in history) / 1000.0
    return Compiled(len(history), len(new), seconds, waited, max(entry["operation_count"] for entry in history))


def _frame_seconds(renderer: Renderer) -> float:
    """Render the view and return the CPU time of this thread, which compiles; others trace the rays."""
    start = thread_time()
    renderer.frame(0)
    return thread_time() - start


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
