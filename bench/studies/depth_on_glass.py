"""Why a simulated D435 reports other things on glass than a real one: one change of the optics at a time.

python bench/studies/depth_on_glass.py --scenes 4

The scenes are those of `bench/depth_camera.py`. Each row has one change: surfaces that scatter a fraction of the
projector's light diffusely (haze, dust), and no mirror image of the projector in glass. The columns are those of
`dataset.depth_cameras.errors`, in the median over objects, and the last two the part of the depths within 10 mm among
those in a band along the silhouette, and among those further inside.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import tyro
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).parent.parent))

from depth_camera import BAND, FEWEST, Run, drawn, right_by_band, settings, touches_border

from glassware.core.randomness import stream_seed
from glassware.dataset.depth_cameras.errors import DepthErrors, depth_errors
from glassware.dataset.depth_cameras.measure import measured
from glassware.procedural.description.depth_camera import DepthCamera
from glassware.render.frame import EYES
from glassware.render.infrared import pictures, trace_pattern
from glassware.render.infrared.media import at_wavelength
from glassware.render.infrared.pattern import pattern_map
from glassware.render.infrared.projected_light import projected_light
from glassware.render.infrared.reflectances import infrared_reflectances
from glassware.render.renderer import Renderer


@dataclass(frozen=True)
class Change:
    """One change of the optics."""

    name: str
    haze: float = 0.0  #: part of the projector's light that a surface of glass scatters diffusely, at either side
    mirrored: bool = True  #: whether glass mirrors the projector


CHANGES = (
    Change("as it is"),
    Change("1 % haze", haze=0.01),
    Change("10 % haze", haze=0.10),
    Change("no mirrored projector", mirrored=False),
)


@contextmanager
def optics(change: Change) -> Iterator[None]:
    """Replace the lobe of interfaces within a block."""
    known: Callable = trace_pattern.interface_lobe

    def changed(table, surface, wi, wo):
        import drjit as dr
        import mitsuba as mi

        cos = dr.dot(wo, surface.ns)
        lit = (cos > 0.0) & (dr.dot(wi, surface.ns) > 0.0)
        diffuse = dr.select(lit, dr.opaque(mi.Float, change.haze) * cos * dr.inv_pi, 0.0)
        return diffuse + (known(table, surface, wi, wo) if change.mirrored else 0.0)

    trace_pattern.interface_lobe = changed
    # Faint lobes count as well.
    faint, trace_pattern._FAINT = trace_pattern._FAINT, 1e-6
    try:
        yield
    finally:
        trace_pattern.interface_lobe, trace_pattern._FAINT = known, faint


def dots(renderer: Renderer, device: DepthCamera) -> tuple[np.ndarray, np.ndarray]:
    """Return the projector's light in both infrared pictures of the first view."""
    scene = renderer.scene
    camera = scene.cameras[0]
    loaded = at_wavelength(renderer.loaded, device.projector.wavelength)
    light = projected_light(pattern_map(device.projector, scene.seed, device.name), device.world_T_projector(camera))
    seeds = [stream_seed(scene.seed, scene.scene_id, f"sensors/0/dots/{eye}") for eye in EYES]
    pair = device.infrared_pair(camera)
    with infrared_reflectances(renderer.loaded):
        left, right = (
            pictures._dots(loaded, pair, eye, light, device, seed) for eye, seed in zip(EYES, seeds, strict=True)
        )
    return left, right


def main() -> None:
    """Print the table."""
    run, console = tyro.cli(Run), Console(width=120)
    found: dict[str, list[tuple[float, ...]]] = {change.name: [] for change in CHANGES}
    for scene in drawn(settings(run), run):
        renderer = Renderer(scene)
        device, geometry, known = scene.depth_camera, renderer.geometry(0), renderer.infrared(0)
        assert isinstance(device, DepthCamera)
        Z = np.where(np.isfinite(geometry.Z), geometry.Z, np.nan)
        masks = [geometry.id == body.id for body in scene.vessels]
        masks = [one for one in masks if one.sum() >= FEWEST * run.scale**2 and not touches_border(one)]
        for change in CHANGES:
            light = known.dots
            if change.haze or not change.mirrored:
                with optics(change):
                    light = dots(renderer, device)
            place = (scene.seed, scene.scene_id, 0)
            changed = replace(known, dots=light)
            report = measured(device, changed, scene.cameras[0], geometry.Z, place).metres
            found[change.name] += [
                (*depth_errors(report, Z, one), *right_by_band(report, Z, one, BAND * run.scale)) for one in masks
            ]
        console.print(f"scene {scene.scene_id}: {len(masks)} objects")
    table = Table(*("change", *DepthErrors._fields, "right near", "right inside", "objects"))
    for name, errors in found.items():
        medians = np.nanmedian(np.array(errors, float), axis=0)
        table.add_row(name, *(f"{value:.2f}" for value in medians), str(len(errors)))
    console.print(table)


if __name__ == "__main__":
    main()
