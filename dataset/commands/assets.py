"""``glassware assets``: what is in a folder of meshes, and what of it cannot be used."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import tyro
from pydantic import Field
from rich.console import Console

from ...core.exit_codes import run_command
from ...core.images import srgb8
from ...core.model import Model
from ...core.passed_over import report
from ...core.randomness import stream
from ...core.remembered import Checked
from ...core.user_text import UserPath, counted
from ...procedural.description.scene import FIRST_OBJECT_ID
from ...procedural.primitives.display import display
from ...procedural.props.draw import PropSettings, drawn_size
from ...procedural.props.from_file import prop_from_file
from ...procedural.props.mesh_files import MeshFile, checked_meshes, mesh_listing, metres_per_unit
from ...render.backend.variant import activate
from ...render.renderer import Renderer
from ..format.pictures import write_png
from ..preview.asset_sheet import asset_sheet
from ..settings.config import parse_request
from .progress import SceneProgress

_DESCRIPTION = """List the meshes of a folder as render-scene and build-dataset would use them: layout, categories,
sizes, parts, materials and licences, what is left out and what is refused, with a contact sheet of renders."""

#: Letters of a caption below a picture of the sheet [1].
LETTERS = 32


class Assets(Model):
    """The request: the folder, what is stated about its meshes, and the contact sheet."""

    folder: Annotated[UserPath, tyro.conf.Positional] = Field(description="Folder of meshes, or one mesh file")
    props: PropSettings = PropSettings()
    sheet: UserPath = Field(default=Path("assets.png"), description="PNG file of the contact sheet")
    most: int = Field(default=24, ge=0, le=400, description="Most objects on the contact sheet; 0 makes none")
    rows: int = Field(default=60, ge=0, description="Most objects in the list on the terminal")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _assets(given))


def _assets(arguments: Sequence[str]) -> None:
    request = parse_request(Assets, arguments, "glassware assets", _DESCRIPTION)
    stages = SceneProgress(Console())
    listed = mesh_listing(request.folder, request.props.choice)
    checked, findings = checked_meshes(request.folder, stages.checking, choice=request.props.choice)
    stages.say_all(_summary(request, checked, len(listed.left_out)))
    stages.say_all(_line(request, file, outcome) for file, outcome in checked[: request.rows])
    if len(checked) > request.rows:
        stages.say(f"and {counted(len(checked) - request.rows, 'more object')} (--rows lists more)")
    if listed.left_out:
        stages.say(f"left out: {counted(len(listed.left_out), 'further file')} of objects that are used")
        left_out = [(path.relative_to(request.folder).as_posix(), why) for path, why in listed.left_out]
        stages.say_all(f"  {name}: {why}" for name, why in left_out[: request.rows])
    stages.say_all(report(findings))
    if request.most:
        _write_sheet(request, [file for file, _ in checked[: request.most]], stages)


def _summary(request: Assets, checked: Sequence[tuple[MeshFile, Checked]], left_out: int) -> list[str]:
    """Return lines of counts: by layout, category and licence."""
    lines = [f"{request.folder}: {counted(len(checked), 'object')}, {counted(left_out, 'further file')} of these"]
    for title, values in (
        ("layout", [file.place.layout for file, _ in checked]),
        ("category", [file.place.category or "none stated" for file, _ in checked]),
        ("licence", [file.place.licence for file, _ in checked]),
    ):
        counts = Counter(values).most_common()
        shown = ", ".join(f"{name} {count}" for name, count in counts[:12])
        lines.append(f"{title}: {shown}" + (f" and {len(counts) - 12} more" if len(counts) > 12 else ""))
    return lines


def _line(request: Assets, file: MeshFile, outcome: Checked) -> str:
    """Return a line about an object."""
    kinds = outcome.facts["kinds"]
    materials = ", ".join(f"{count} {kind}" for kind, count in Counter(kinds).items())
    size = _size(request, file, float(outcome.facts["longest"]))
    facts = (f"{size} mm", f"{outcome.facts['faces']:,} faces", f"{counted(len(kinds), 'part')} ({materials})")
    named = (f"category {file.place.category}",) if file.place.category else ()
    return f"  {file.name}: " + ", ".join((*facts, *named, f"licence {file.place.licence}"))


def _size(request: Assets, file: MeshFile, longest: float) -> str:
    """Return the longest side in millimetres, with a tilde where it is drawn."""
    unit = metres_per_unit(file, longest)
    return f"~{1e3 * drawn_size(file, request.props):.0f}" if unit is None else f"{1e3 * unit * longest:.3g}"


def _write_sheet(request: Assets, files: Sequence[MeshFile], stages: SceneProgress) -> None:
    activate()
    rng = stream(0, 0, "props/0")  # of what files do not state
    objects = [
        prop_from_file(rng, file, drawn_size(file, request.props), id=FIRST_OBJECT_ID + i, name=f"prop-{i:03d}")
        for i, file in enumerate(files)
    ]
    scene = display(objects)
    renderer = Renderer(scene)
    pictures = []
    with stages.display():
        stages.begin_views(len(objects))
        for view in range(len(objects)):
            pictures.append(srgb8(renderer.frame(view).left, scene.cameras[view].exposure, scene.cameras[view].tone))
            stages.advance(view)
    sizes = (" x ".join(f"{1e3 * side:.0f}" for side in item.size) + " mm" for item in objects)
    captions = [(_end_of(file.name), size) for file, size in zip(files, sizes, strict=True)]
    write_png(request.sheet, asset_sheet(pictures, captions))
    stages.say(f"{request.sheet}: {counted(len(objects), 'object')}")


def _end_of(name: str) -> str:
    """Return the end of a long name, which is what files of one folder differ in."""
    return name if len(name) <= LETTERS else f"..{name[2 - LETTERS :]}"


if __name__ == "__main__":
    sys.exit(main())
