"""What a new scene in a running process costs to compile, and a scene in which only numbers changed.

python bench/compilation.py [--scenes 5] [--json FILE]

Kernels are compiled anew: what earlier runs have left in the disk's cache does not count.
"""

from __future__ import annotations

import os
import sys
import tempfile
from argparse import ArgumentParser
from dataclasses import dataclass
from pathlib import Path
from time import thread_time

from table import Row, report

from glassware.dataset.settings.config import preset
from glassware.procedural.description.scene import Scene, Vessel
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.render.backend.variant import activate
from glassware.render.renderer import Renderer

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


def main() -> int:
    """Measure and print; 1 where a bound is broken."""
    options = ArgumentParser(description=__doc__)
    options.add_argument("--scenes", type=int, default=5)
    options.add_argument("--json", type=Path)
    given = options.parse_args()
    scenes = [_drawn(number) for number in range(given.scenes)]
    with tempfile.TemporaryDirectory() as folder:
        os.environ["HOME"] = folder  # Dr.Jit keeps its kernels there
        variant = activate()
        _count_kernels()
        rows = [_row(number, scene) for number, scene in enumerate(scenes)]
        cost = _cost(_other_numbers(scenes[-1]))
    note = f"{cost.waited:.2f} s by the clock, {cost.new} of {cost.kernels} kernels new, at most {FEW}"
    rows.append(Row("the last one with other numbers", cost.seconds, "s", ok=cost.new <= FEW, note=note))
    return report("Compiling kernels", rows, given.json, seed=SEED, preset="fast", variant=variant)


def _row(number: int, scene: Scene) -> Row:
    cost = _cost(scene)
    shape = f"{len(scene.vessels)} vessels, {len(scene.props)} props, {len(scene.lights)} lamps"
    note = f"{cost.waited:.2f} s by the clock, {cost.new} of {cost.kernels} kernels new, {cost.operations} ops; {shape}"
    if number == 0:
        return Row("first scene", cost.seconds, "s", note=note)
    ratio, ok = cost.seconds / BOUND, cost.seconds <= BOUND
    return Row(f"new scene {number}", cost.seconds, "s", bound=BOUND, ratio=ratio, ok=ok, note=note)


def _count_kernels() -> None:
    import drjit as dr

    dr.set_flag(dr.JitFlag.KernelHistory, True)


def _drawn(number: int) -> Scene:
    settings = SceneSettings.model_validate(preset("fast"))
    cameras = settings.cameras.model_copy(update={"views": 1, "width": WIDTH, "height": HEIGHT})
    picture = settings.picture.model_copy(update={"spp": SPP})
    return draw_scene(settings.model_copy(update={"cameras": cameras, "picture": picture}), SEED, number)


def _other_numbers(scene: Scene) -> Scene:
    """Return the scene with another glass, another light, another camera, another picture, another roughness."""
    props = tuple(
        prop.model_copy(
            update={"material": prop.material.model_copy(update={"roughness": 0.5 + 0.5 * prop.material.roughness})}
        )
        for prop in scene.props
    )
    lights = tuple(
        light.model_copy(
            update={
                "radiance": tuple(0.5 * x for x in light.radiance),
                "size": (0.5 * light.size[0], light.size[1]),
            }
        )
        for light in scene.lights
    )
    camera = scene.cameras[0]
    cameras = (camera.model_copy(update={"exposure": 2.0 * camera.exposure, "width": WIDTH // 2}),)
    picture = scene.picture.model_copy(update={"spp": 2 * SPP, "max_depth": 40})
    environment = scene.environment.model_copy(update={"strength": 0.5})
    changed = {"props": props, "lights": lights, "cameras": cameras, "picture": picture, "environment": environment}
    return scene.model_copy(update=changed | {"vessels": tuple(_denser(vessel) for vessel in scene.vessels)})


def _denser(vessel: Vessel) -> Vessel:
    interfaces = tuple(
        interface.model_copy(
            update={
                side: medium.model_copy(update={"eta": 1.01 * medium.eta})
                for side, medium in (("front", interface.front), ("back", interface.back))
                if medium.eta > 1.0
            }
        )
        for interface in vessel.interfaces
    )
    return vessel.model_copy(update={"interfaces": interfaces})


def _cost(scene: Scene) -> Compiled:
    """Return what a scene costs. It is gone before the next one: Dr.Jit compiles for everything that is alive."""
    import drjit as dr

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
    sys.exit(main())
