"""Rays a second inside the integrator against Dr.Jit's bare `ray_intersect`, alternating in one run.

python bench/integrator.py [--scene filled] [--spp 8] [--repeats 5] [--json FILE]

The integrator's rays are the segments of its paths and its shadow rays. The bare ones are the rays of the same paths
after the first hit, recorded in the order in which they were traced: the same distribution in the same scene, and
incoherent, because they have left surfaces in all directions.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from statistics import median
from time import perf_counter, process_time
from typing import Any
from unittest.mock import patch

import drjit as dr
import mitsuba as mi
import numpy as np
from command import Output, run
from ours import VARIANT
from scenes import bench_scene
from table import Row, report

from glassware.render.pictures.integrator import trace
from glassware.render.pictures.picture import camera_paths
from glassware.render.scene.loaded_scene import load
from glassware.render.scene.rays import pinhole

#: Least fraction of the bare rate that the integrator must reach.
BOUND = 0.5
WIDTH, HEIGHT = 320, 240
#: Most rays that are recorded; 24 bytes each.
CAPACITY = 1 << 23


@dataclass
class Taken:
    """Seconds of each measurement."""

    wall: list[float]
    cpu: list[float]

    def add(self, work: Callable[[], object]) -> None:
        """Do the work and take its time. The machine may have other users, whom CPU time does not count."""
        wall, cpu = perf_counter(), process_time()
        work()
        self.wall.append(perf_counter() - wall)
        self.cpu.append(process_time() - cpu)


@dataclass(frozen=True, kw_only=True)
class Options(Output):
    """What to measure."""

    scene: str = "filled"
    """Name of the scene."""
    spp: int = 8
    """Samples per pixel."""
    repeats: int = 5
    """Measurements of each, alternating."""


def main(given: Options) -> int:
    """Measure and print; 1 where the bound is broken."""
    scene = bench_scene(given.scene, WIDTH, HEIGHT)
    loaded = load(scene)
    with _recording() as record:
        segments = _traced(loaded, given.spp)
    rays, shadows = record.rays(), record.shadows()
    ours, bare = Taken([], []), Taken([], [])
    _traced(loaded, given.spp)  # compiles
    _bare(loaded, rays)
    for _ in range(given.repeats):
        ours.add(lambda: _traced(loaded, given.spp))
        bare.add(lambda: _bare(loaded, rays))
    recorded = len(rays.maxt)
    rows = [
        Row("segments", segments / 1e6, "M"),
        Row("shadow rays", shadows / 1e6, "M"),
        Row("recorded rays", recorded / 1e6, "M", note="of the segments that leave a surface"),
    ]
    for name, one, other in (("CPU", ours.cpu, bare.cpu), ("wall", ours.wall, bare.wall)):
        rate, bare_rate = (segments + shadows) / median(one) / 1e6, recorded / median(other) / 1e6
        judged = {"bound": BOUND, "ok": rate / bare_rate >= BOUND} if name == "CPU" else {}
        rows += [
            Row(f"integrator, {name} time", rate, "M rays/s"),
            Row(f"bare ray_intersect, {name} time", bare_rate, "M rays/s"),
            Row(f"integrator / bare, {name} time", rate / bare_rate, "", **judged),
        ]
    facts = {"scene": given.scene, "size": f"{WIDTH}x{HEIGHT}", "spp": given.spp, "variant": VARIANT}
    return report("Rays inside the integrator", rows, given.json_file, repeats=given.repeats, **facts)


def _traced(loaded: Any, spp: int) -> int:
    """Trace the picture once and return the number of segments."""
    pixel, view = np.arange(WIDTH * HEIGHT, dtype=np.uint32), pinhole(loaded.description.cameras[0])
    ray, weight, sampler = camera_paths(view, pixel, np.zeros_like(pixel), spp, spp, seed=1)
    result = trace(loaded, ray, weight, sampler, loaded.description.picture)
    dr.eval(result)
    return int(np.array(result.segments).sum(dtype=np.int64))


def _bare(loaded: Any, rays: Any) -> None:
    """Intersect the rays with the scene and read what a path needs of the hit."""
    si = loaded.mi_scene.ray_intersect(rays, mi.RayFlags.All, False)
    dr.eval(si.t + dr.sum(si.p) + dr.sum(si.n) + dr.sum(si.sh_frame.n) + dr.sum(si.uv))
    dr.sync_thread()


class _Record:
    """Rays that left surfaces, and the number of shadow rays."""

    def __init__(self) -> None:
        self._next, self._shadows = dr.zeros(mi.UInt32, 1), dr.zeros(mi.UInt32, 1)
        self._o, self._d = dr.zeros(mi.Point3f, CAPACITY), dr.zeros(mi.Vector3f, CAPACITY)

    def bounce(self, ray: Any, coherent: Any, active: Any) -> None:
        """Keep the rays that are active and no camera rays."""
        wanted = mi.Bool(active) & ~mi.Bool(coherent)
        slot = dr.scatter_inc(self._next, mi.UInt32(0), wanted)
        wanted &= slot < CAPACITY
        dr.scatter(self._o, ray.o, slot, wanted)
        dr.scatter(self._d, ray.d, slot, wanted)

    def shadow(self, active: Any) -> None:
        """Count shadow rays."""
        dr.scatter_add(self._shadows, mi.UInt32(1), mi.UInt32(0), mi.Bool(active))

    def rays(self) -> Any:
        """Return the recorded rays."""
        index = dr.arange(mi.UInt32, min(int(self._next[0]), CAPACITY))
        ray = mi.Ray3f(dr.gather(mi.Point3f, self._o, index), dr.gather(mi.Vector3f, self._d, index))
        ray.maxt = dr.full(mi.Float, dr.largest(mi.Float), len(index))
        dr.eval(ray)
        return ray

    def shadows(self) -> int:
        """Return the number of shadow rays."""
        return int(self._shadows[0])


@contextmanager
def _recording() -> Iterator[_Record]:
    """Record what the integrator asks of Mitsuba's scene; for one trace, which is not timed."""
    record, intersect, test = _Record(), mi.Scene.ray_intersect, mi.Scene.ray_test

    def intersected(scene: Any, ray: Any, flags: Any, coherent: Any, active: Any) -> Any:
        record.bounce(ray, coherent, active)
        return intersect(scene, ray, flags, coherent, active)

    def tested(scene: Any, ray: Any, coherent: Any, active: Any) -> Any:
        record.shadow(active)
        return test(scene, ray, coherent, active)

    with patch.object(mi.Scene, "ray_intersect", intersected), patch.object(mi.Scene, "ray_test", tested):
        yield record


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
