"""What scenes are drawn: time by part, failures, faults of bodies, counts and piles, for many seeds of a preset.

``python bench/world.py 1000 standard keypose``: for each preset a table in Markdown; nothing is rendered. With
``--records DIR`` each scene is a line of a file there, and scenes that are in it already are not drawn again. With
``--load`` the scene is also loaded into the renderer. Times are processor time, so that a busy machine changes little.
The presets fast, standard, syn-todd and train draw the same objects and tables, before other cameras and, for train,
other lamps and prints on tables: with ``--also syn-todd train`` surroundings are drawn around the objects of each scene
as well, to see that they can be.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import wraps
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / ".ci" / "packages"))

from world_checks import checked, kinds_in, leaning
from world_tables import figures, times

from glassware.core.errors import InputError
from glassware.dataset.settings.config import preset, validated
from glassware.procedural.description.scene import GlassBody, Scene
from glassware.procedural.physics import piles
from glassware.procedural.scene import arrange, draw
from glassware.procedural.scene.asset_files import asset_files
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.draw_surroundings import draw_surroundings
from glassware.procedural.scene.settings import SceneSettings

#: Parts of drawing a scene whose processor time is measured, none within another: what it is, and its function.
PARTS = (
    ("vessels", draw, "draw_vessels"),
    ("props", draw, "_props"),
    ("places of what stands apart", arrange, "_apart"),
    ("convex parts of what piles", piles, "_case"),
    ("falling, coming to rest, checks", piles, "_settled"),
)
#: Tilt from the vertical beyond which an object leans or lies [rad].
TILTED = np.radians(5.0)


def main() -> None:
    """Print the tables that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, help="seeds of each preset; 0 for what the records have")
    parser.add_argument("presets", nargs="+", help="names of presets")
    parser.add_argument("--first", type=int, default=0, help="number of the first scene")
    parser.add_argument("--load", action="store_true", help="load scenes into the renderer as well")
    parser.add_argument("--also", nargs="*", default=[], help="presets whose surroundings and cameras are drawn too")
    parser.add_argument("--records", type=Path, help="folder of a file of records for each preset")
    request = parser.parse_args()
    for name in request.presets:
        scenes = range(request.first, request.first + request.count)
        path = request.records and request.records / f"{name}.jsonl"
        records = recorded(name, scenes, request.load, request.also, path)
        sys.stdout.write(f"\n{name}, {len(records)} scenes of seed 1\n\n| figure | value |\n|---|---|\n")
        sys.stdout.write("".join(f"| {what} | {value} |\n" for what, value in figures(records)))
        sys.stdout.write("\n| processor time [s] | mean | 99 % below | longest | in scene |\n|---|---|---|---|---|\n")
        sys.stdout.write("".join(f"| {row} |\n" for row in times(records)))
        sys.stdout.flush()


def recorded(name: str, scenes: range, load: bool, also: list[str], path: Path | None) -> list[dict[str, Any]]:
    """Return the records of a preset's scenes, in their order; those that a file has are taken from it."""
    settings, *others = [validated(SceneSettings, preset(one), "preset") for one in (name, *also)]
    lines = path.read_text("utf-8").splitlines() if path is not None and path.exists() else []
    known = {record["scene"]: record for record in map(json.loads, lines)}
    for number in scenes:
        if number not in known:
            try:
                known[number] = record_of(settings, number, load, others)
            except Exception as error:  # a fault of ours, counted: the scenes after it are still drawn
                known[number] = {"scene": number, "failure": f"{type(error).__name__}: {error}"}
            if path is not None:
                path.parent.mkdir(parents=True, exist_ok=True)
                with path.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(known[number]) + "\n")
    return [known[number] for number in (scenes or sorted(known)) if number in known]


def record_of(settings: SceneSettings, number: int, load: bool, others: list[SceneSettings]) -> dict[str, Any]:
    """Return what a scene is and what is wrong with it, as plain data: its failure alone where it cannot be drawn."""
    parts: dict[str, float] = defaultdict(float)
    start = process_time()
    try:
        with ExitStack() as stack:
            for what, module, function in PARTS:
                stack.enter_context(timed(parts, module, function, what))
            scene = draw_scene(settings, 1, number)
        surrounded = process_time()
        for other in others:
            draw_surroundings(other, 1, number, asset_files(other), scene.table, scene.objects)
        start += process_time() - surrounded
    except InputError as error:
        return {"scene": number, "failure": str(error)}
    parts["surroundings, light, cameras, and the rest"] = process_time() - start - sum(parts.values())
    if load:
        start_load = process_time()
        _load(scene)
        parts["loading into the renderer"] = process_time() - start_load
    parts["all"] = process_time() - start
    ordered = {what: parts.get(what, 0.0) for what in dict.fromkeys([*(what for what, *_ in PARTS), *parts])}
    return {"scene": number, "times": ordered} | _described(scene) | checked(scene)


def _described(scene: Scene) -> dict[str, Any]:
    counts = {"vessels": len(scene.vessels), "props": len(scene.props), "objects": len(scene.objects)}
    rest, upon = None, 0
    if scene.rest is not None:
        names = ("attempt", "given_up", "fell_again", "seconds", "moved")
        rest = {name: getattr(scene.rest, name) for name in names}
        standing = {pair[1] for pair in scene.rest.contacts if pair[0] == 1}
        upon = 0 if scene.rest.given_up else sum(item.id not in standing for item in scene.objects)
    tilted = sum(bool(leaning(item) > TILTED) for item in scene.vessels)
    hosts = [item for item in scene.objects if item.part_of is None and item.within is None]
    ours = {"vessels": sum(isinstance(item, GlassBody) for item in hosts)}
    return {
        "counts": ours | {"props": len(hosts) - ours["vessels"], "objects": len(hosts)},
        "all": counts | {"upon": upon, "tilted": tilted},
        "rest": rest,
        "kinds": kinds_in(scene),
    }


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


if __name__ == "__main__":
    main()
