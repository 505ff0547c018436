"""What scenes are drawn: time by part, failures, overlaps, counts and piles, for many seeds of a preset.

``python bench/world.py 1000 standard fast``: for each preset a table in Markdown; nothing is rendered. With ``--load``
the scene is also loaded into the renderer. Times are processor time, so that a busy machine changes little.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import wraps
from itertools import combinations
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / ".ci" / "packages"))

from glassware.core.errors import InputError
from glassware.dataset.settings.config import preset, validated
from glassware.procedural.description.edits import solid_of
from glassware.procedural.description.scene import GlassBody, Prop, Scene
from glassware.procedural.physics import piles
from glassware.procedural.placement.overlap import overlap
from glassware.procedural.scene import arrange, draw
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings

#: Numbers of objects in a scene of the paper (Syn-TODD): fewest and most.
PAPER = {"objects": "3 to 15", "vessels": "up to 7", "props": "up to 8"}
#: Parts of drawing a scene whose processor time is measured, none within another: what it is, and its function.
PARTS = (
    ("vessels", draw, "draw_vessels"),
    ("props", draw, "_props"),
    ("places of what stands apart", arrange, "_apart"),
    ("convex parts of what piles", piles, "_case"),
    ("falling, coming to rest, checks", piles, "_settled"),
)
_NAMES = frozenset(what for what, *_ in PARTS)
#: Tilt from the vertical beyond which an object leans or lies [rad].
TILTED = np.radians(5.0)


def main() -> None:
    """Print the tables that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, help="seeds of each preset")
    parser.add_argument("presets", nargs="+", help="names of presets")
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--load", action="store_true", help="load scenes into the renderer as well")
    request = parser.parse_args()
    for name in request.presets:
        rows, times = tables(name, range(request.first, request.first + request.count), request.load)
        sys.stdout.write(f"\n{name}, {request.count} scenes of seed 1 from {request.first} on\n\n")
        sys.stdout.write("| figure | value |\n|---|---|\n")
        sys.stdout.write("".join(f"| {what} | {value} |\n" for what, value in rows))
        sys.stdout.write("\n| processor time [s] | mean | longest | in scene |\n|---|---|---|---|\n")
        sys.stdout.write("".join(f"| {row} |\n" for row in times))
        sys.stdout.flush()


def tables(name: str, scenes: range, load: bool) -> tuple[list[tuple[str, str]], list[str]]:
    """Return the rows of a preset's tables: what was drawn, and the processor time of each part."""
    settings = validated(SceneSettings, preset(name), "preset")
    seen, faults = Seen(), []
    times: list[dict[str, float]] = []
    for number in scenes:
        parts: dict[str, float] = defaultdict(float)
        start = process_time()
        try:
            with ExitStack() as stack:
                for what, module, function in PARTS:
                    stack.enter_context(timed(parts, module, function, what))
                scene = draw_scene(settings, 1, number)
        except InputError as error:
            faults.append(f"{number}: {error}")
            continue
        parts["surroundings, light, cameras, and the rest"] = process_time() - start - sum(parts.values())
        if load:
            start_load = process_time()
            _load(scene)
            parts["loading into the renderer"] = process_time() - start_load
        parts["all"] = process_time() - start
        times.append(parts | {"scene": number})
        seen.add(scene)
    return _figures(seen, faults), _times(times)


def _figures(seen: Seen, faults: list[str]) -> list[tuple[str, str]]:
    return [
        ("failures", "; ".join(faults) or "none"),
        ("pairs of objects that overlap by more than 0.5 mm", f"{seen.overlaps} of {seen.pairs}"),
        *[
            (f"{what} in a scene: mean, range, the paper's", f"{_span(seen.counts[what])}, {PAPER[what]}")
            for what in PAPER
        ],
        ("scenes with a pile", _share(len(seen.rests), seen.scenes)),
        ("piles drawn again; falls drawn again", _again(seen)),
        ("simulated time of a pile: mean, longest [s]", _mean([rest.seconds for rest in seen.rests])),
        (
            "largest movement in the last second [mm]",
            f"{1e3 * max([rest.moved for rest in seen.rests], default=0.0):.2f}",
        ),
        ("objects on another one; leaning or lying vessels", f"{_share(seen.upon, seen.objects)}; {_tilts(seen)}"),
    ]


def _times(times: list[dict[str, float]]) -> list[str]:
    """Return a row for each part, and for a scene as a whole: mean, longest, and the scene that took longest."""
    names = [what for what, *_ in PARTS] + [what for what in (times[0] if times else {}) if what not in _NAMES]
    rows = []
    for what in [name for name in names if name != "scene"]:
        longest = max(times, key=lambda one: one.get(what, 0.0))
        mean = sum(one.get(what, 0.0) for one in times) / len(times)
        rows.append(f"{what} | {mean:.2f} | {longest.get(what, 0.0):.2f} | {longest['scene']:.0f}")
    return rows


class Seen:
    """Sums over scenes."""

    def __init__(self) -> None:
        self.scenes = self.pairs = self.overlaps = self.upon = self.objects = self.vessels = self.tilted = 0
        self.counts: dict[str, list[int]] = {what: [] for what in PAPER}
        self.rests: list[Any] = []

    def add(self, scene: Scene) -> None:
        """Take a scene in."""
        self.scenes += 1
        counts = {"vessels": len(scene.vessels), "props": len(scene.props), "objects": len(scene.objects)}
        for what, count in counts.items():
            self.counts[what].append(count)
        solids = [solid_of(item) for item in scene.objects]
        for first, second in combinations(solids, 2):
            self.pairs += 1
            self.overlaps += overlap(first, second)
        self.objects += len(solids)
        self.vessels += len(scene.vessels)
        self.tilted += sum(_tilt(item) > TILTED for item in scene.vessels)
        if scene.rest is not None and not scene.rest.given_up:
            self.rests.append(scene.rest)
            standing = {pair[1] for pair in scene.rest.contacts if pair[0] == 1}
            self.upon += sum(item.id not in standing for item in scene.objects)


def _tilt(item: GlassBody | Prop) -> float:
    return float(np.arccos(np.clip(item.world_T_object[2, 2], -1.0, 1.0)))


def _load(scene: Scene) -> None:
    from glassware.render.backend.variant import activate
    from glassware.render.scene.loaded_scene import load

    activate()
    load(scene)


@contextmanager
def timed(times: dict[str, float], module: Any, function: str, what: str) -> Iterator[None]:
    """Add the processor time of a module's function to a sum within the block."""
    original = getattr(module, function)

    @wraps(original)
    def measured(*arguments: Any) -> Any:
        start = process_time()
        try:
            return original(*arguments)
        finally:
            times[what] += process_time() - start

    setattr(module, function, measured)
    try:
        yield
    finally:
        setattr(module, function, original)


def _span(values: list[int]) -> str:
    return f"{np.mean(values):.1f}, {min(values)} to {max(values)}" if values else "none"


def _mean(values: list[float]) -> str:
    return f"{np.mean(values):.2f}, {max(values):.2f}" if values else "none"


def _share(part: int, whole: int) -> str:
    return f"{part} of {whole} ({100.0 * part / max(whole, 1):.1f} %)"


def _again(seen: Seen) -> str:
    return f"{sum(rest.attempt - 1 for rest in seen.rests)}; {sum(rest.fell_again for rest in seen.rests)}"


def _tilts(seen: Seen) -> str:
    return _share(seen.tilted, seen.vessels)


if __name__ == "__main__":
    main()
