"""What a D435 gets wrong on glass, captured and simulated, side by side.

python bench/depth_camera.py --captures DIR

DIR holds real captures in ClearGrasp's layout (``real-val/d435``): depth of transparent objects, and of the same
objects sprayed opaque, which is the truth. The simulated ones show empty vessels of clear plastic and glass, 0.5 to
0.7 m away on tables with texture. Each row has the five numbers of `dataset.depth_cameras.errors`, per object in the
median and from the least to the most, and what holds off the glass.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from time import process_time

import cv2
import numpy as np
import tyro
from rich.console import Console
from rich.table import Table

from glassware.core.errors import InputError
from glassware.core.images import srgb8
from glassware.dataset.depth_cameras.errors import DepthErrors, depth_errors
from glassware.dataset.depth_cameras.measure import MEASURED, measured
from glassware.dataset.format.exr import read_exr
from glassware.dataset.format.pictures import write_png
from glassware.procedural.description.depth_camera import DepthCamera
from glassware.procedural.description.scene import Scene
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.surroundings.colour import luminance
from glassware.procedural.surroundings.environments import bake_environment
from glassware.procedural.surroundings.metering import irradiance
from glassware.render.renderer import Renderer

#: Objects of fewer pixels are left out: of 1280 x 720 in the captures, of half of that in the simulation.
FEWEST = 4000
#: Of the captures' colour camera [px], and its width.
FOCAL, WIDTH, HEIGHT = 921.0, 1280, 720
#: Width of the band along silhouettes, of the captures [px].
BAND = 20
#: Depth up to which the background is compared [m]: the captures' reaches to 1.05 m.
FARTHEST = 1.05
#: Clear plastics and glass, as the captured objects are made of.
CLEAR = ("PET=2", "acrylic=1", "polycarbonate=1", "soda-lime glass=1")
#: Illuminance of the tables [klx]: that of offices (EN 12464-1). Drawn rooms have up to 5, where the sun shines in.
OFFICE = 0.5
#: Difference that has its full colour in pictures [m].
SHOWN = 0.05
#: Unit of the captures' depth [m] (their camera's settings), and the farthest depth that 16 bits hold in it [m].
UNIT, FARTHEST_REPORTED = 1e-4, 6.5


@dataclass(frozen=True)
class Run:
    """What is compared."""

    captures: Path | None = None  #: folder of real captures
    scenes: int = 20
    seed: int = 435
    scale: float = 0.5  #: of the simulated colour camera's picture over the captures'
    pictures: Path | None = None  #: folder for a picture of each simulated view


@dataclass
class Figures:
    """Numbers of objects, and of what is off the glass."""

    objects: list[DepthErrors] = field(default_factory=list)
    bands: list[tuple[float, float]] = field(default_factory=list)  #: `right_by_band` of each object
    background_missing: list[float] = field(default_factory=list)
    background_error: list[float] = field(default_factory=list)  #: [m]

    def add(
        self, reported: np.ndarray, Z: np.ndarray, again: np.ndarray, masks: list[np.ndarray], glass: np.ndarray
    ) -> None:
        """Add a view; `reported`, `Z` and a second report of the same view, `again`, in metres, NaN for none.

        In the captures the opaque twin is the second report: what both have wrong does not show.
        """
        self.objects += [depth_errors(reported, Z, mask) for mask in masks]
        band = BAND * Z.shape[1] / WIDTH
        self.bands += [right_by_band(reported, Z, mask, band) for mask in masks]
        away = cv2.dilate(glass.astype(np.uint8), np.ones((21, 21), np.uint8)) == 0
        known = away & (again < FARTHEST)
        self.background_missing.append(float(np.isnan(reported[known]).mean()))
        self.background_error.append(float(np.nanmedian(np.abs(reported - again)[known])))


def right_by_band(reported: np.ndarray, Z: np.ndarray, mask: np.ndarray, band: float) -> tuple[float, float]:
    """Return the part of an object's depths within 10 mm: in a band [px] along its silhouette, and further inside."""
    inside = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5) > band
    known, right = mask & np.isfinite(reported - Z), np.abs(reported - Z) < 0.01
    near, far = (float(right[part].mean()) if part.any() else np.nan for part in (known & ~inside, known & inside))
    return near, far


def captured(folder: Path) -> Figures:
    """Return the figures of real captures."""
    found = Figures()
    for path in sorted(folder.glob("*-transparent-depth-img.exr")):
        name = path.name.split("-")[0]
        depth, truth = (
            read_exr(folder / f"{name}-{kind}-depth-img.exr")["R"].astype(np.float32)
            for kind in ("transparent", "opaque")
        )
        depth, truth = (np.where(one > 0.0, one, np.nan) for one in (depth, truth))
        mask = np.array(cv2.imread(str(folder / f"{name}-mask.png"), cv2.IMREAD_GRAYSCALE)) > 127
        count, labels = cv2.connectedComponents(mask.astype(np.uint8))
        masks = [labels == number for number in range(1, count)]
        found.add(depth, truth, truth, [one for one in masks if one.sum() >= FEWEST], mask)
    if not found.objects:
        raise InputError(folder, "captures, such as 000000000-transparent-depth-img.exr", "none")
    return found


def settings(run: Run) -> SceneSettings:
    """Return what the simulated scenes are drawn from."""
    width, height = round(WIDTH * run.scale), round(HEIGHT * run.scale)
    return SceneSettings.model_validate(
        {
            "vessel_count": (3, 5),
            "prop_count": (0, 0),
            "vessels": {"glasses": CLEAR, "fill_probability": 0.0, "rough_probability": 0.0},
            "cameras": {
                "views": 1,
                "width": width,
                "height": height,
                "fx": FOCAL * run.scale,
                "distance": (0.5, 0.7),
                "elevation": (0.7, 1.2),
            },
            "environment": {"shipped_share": 0.0, "room_share": 1.0},  # indoors, as the captures are
            "picture": {"spp": 8, "light": "path", "refraction": False, "layers": 0},
            "sensors": {"depth": "d435"},
        }
    )


def simulated(run: Run, console: Console) -> Figures:
    """Return the figures of simulated views."""
    found, wanted = Figures(), settings(run)
    for number, scene in enumerate(drawn(wanted, run)):
        begun = process_time()
        renderer = Renderer(scene)
        infrared, geometry = renderer.infrared(0), renderer.geometry(0)
        assert isinstance(scene.depth_camera, DepthCamera)
        sensor, again = (
            measured(scene.depth_camera, infrared, scene.cameras[0], geometry.Z, (seed, scene.scene_id, 0))
            for seed in (scene.seed, scene.seed + 1)
        )
        Z = np.where(np.isfinite(geometry.Z), geometry.Z, np.nan)
        glass = np.isin(geometry.id, [body.id for body in scene.vessels])
        masks = [geometry.id == body.id for body in scene.vessels]
        # Not those that the sensor's picture ends in.
        masks = [one for one in masks if one.sum() >= FEWEST * run.scale**2 and not touches_border(one)]
        found.add(sensor.metres, Z, again.metres, masks, glass)
        console.print(
            f"scene {number}: {process_time() - begun:.1f} s of processor, {(sensor.reason == MEASURED).mean():.0%} "
            f"measured, {np.isnan(sensor.metres[glass]).mean():.0%} of the glass missing"
        )
        if run.pictures is not None:
            save(run.pictures / f"{number:02d}.png", renderer.frame(0), sensor, Z)
    return found


def drawn(wanted: SceneSettings, run: Run) -> Iterator[Scene]:
    """Yield the scenes, with the captures' light and unit."""
    for number in range(run.scenes):
        scene = as_bright_as_an_office(draw_scene(wanted, run.seed, number))
        device = scene.depth_camera
        assert isinstance(device, DepthCamera)
        device = device.model_copy(update={"unit": UNIT, "range": (device.range[0], FARTHEST_REPORTED)})
        yield scene.model_copy(update={"depth_camera": device})


def as_bright_as_an_office(scene: Scene) -> Scene:
    """Return a scene whose light is as much brighter or darker as puts `OFFICE` on the table."""
    around = scene.environment
    factor = OFFICE / float(luminance(irradiance(bake_environment(around), around.strength, scene.lights)))
    lights = [
        light.model_copy(update={"radiance": tuple(factor * value for value in light.radiance)})
        for light in scene.lights
    ]
    cameras = [one.model_copy(update={"exposure": one.exposure / factor}) for one in scene.cameras]
    environment = around.model_copy(update={"strength": factor * around.strength})
    return scene.model_copy(update={"environment": environment, "lights": tuple(lights), "cameras": tuple(cameras)})


def touches_border(mask: np.ndarray) -> bool:
    """Return whether a mask has pixels at the picture's edge."""
    return bool(mask[[0, -1]].any() or mask[:, [0, -1]].any())


def save(path: Path, frame, sensor, Z: np.ndarray) -> None:
    """Write the picture and the left infrared picture, and below the true depth, the reported one and the difference.

    The difference is red where the report lies behind the first surface, blue where it lies in front of it.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    low, high = np.nanpercentile(Z, [1, 99])
    colour = srgb8(frame.left, frame.exposure, frame.tone)
    size = colour.shape[1], colour.shape[0]
    depths = []
    for depth in (Z, sensor.metres):
        level = np.clip(np.nan_to_num((high - depth) / (high - low)), 0.0, 1.0)
        one = cv2.applyColorMap((255 * level).astype(np.uint8), cv2.COLORMAP_TURBO)[..., ::-1].copy()
        one[np.isnan(depth)] = 0
        depths.append(one)
    infrared = cv2.resize(sensor.infrared.left.astype(np.uint8), size, interpolation=cv2.INTER_AREA)
    above = np.hstack([colour, np.repeat(infrared[..., None], 3, axis=2)])
    below = np.hstack([*depths, _signed(sensor.metres - Z)])
    height = round(above.shape[1] / below.shape[1] * below.shape[0])
    below = cv2.resize(below, (above.shape[1], height), interpolation=cv2.INTER_NEAREST)
    write_png(path, np.ascontiguousarray(np.vstack([above, below])))


def _signed(error: np.ndarray) -> np.ndarray:
    """Return differences of depth as colours, (H, W, 3) uint8: red from 0 up to `SHOWN`, blue below, black for none."""
    part = np.clip(np.nan_to_num(error) / SHOWN, -1.0, 1.0)[..., None]
    colours = 255.0 * (1.0 - np.abs(part) * np.where(part > 0.0, [0.3, 0.92, 0.85], [0.9, 0.55, 0.3]))
    return np.where(np.isnan(error)[..., None], 0, colours).astype(np.uint8)


def main(run: Run) -> None:
    """Print the figures side by side."""
    console, columns = Console(width=160), {}
    if run.captures is not None:
        columns["captured"] = captured(run.captures)
    columns["simulated"] = simulated(run, console)
    table = Table("median (least to most)", *columns)
    rows = {
        "objects": lambda one: str(len(one.objects)),
        **{
            name: lambda one, k=k: spread([item[k] for item in one.objects])
            for k, name in enumerate(DepthErrors._fields)
        },
        "right near the silhouette": lambda one: spread([item[0] for item in one.bands]),
        "right further inside": lambda one: spread([item[1] for item in one.bands]),
        "background missing": lambda one: spread(one.background_missing),
        "background error (mm)": lambda one: spread([1e3 * value for value in one.background_error]),
    }
    for name, row in rows.items():
        table.add_row(name, *(row(one) for one in columns.values()))
    console.print(table)


def spread(values: list[float]) -> str:
    """Return the median of some numbers, the least and the most, and the middle half."""
    known = [value for value in values if np.isfinite(value)]
    if not known:
        return "-"
    low, first, middle, third, high = np.quantile(known, [0, 0.25, 0.5, 0.75, 1])
    return f"{middle:.3g} ({low:.3g} to {high:.3g}; half {first:.3g} to {third:.3g})"


if __name__ == "__main__":
    main(tyro.cli(Run, description=__doc__))
    sys.exit(0)
