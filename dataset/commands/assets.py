"""``glassware assets``: what is in a folder of meshes, as props or as vessels, and what of it cannot be used."""

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
from ...core.folders import listed_in
from ...core.images import srgb8
from ...core.model import Model
from ...core.passed_over import report
from ...core.randomness import stream
from ...core.remembered import Checked
from ...core.units import volume_text
from ...core.user_text import UserPath, counted
from ...procedural.description.scene import FIRST_OBJECT_ID, SceneObject
from ...procedural.mesh_files.layouts import UNREAD_SUFFIXES, Listing, Place
from ...procedural.own_vessels.draw import draw_own_vessel
from ...procedural.own_vessels.files import VesselFile, vessel_listing
from ...procedural.own_vessels.usable import checked_vessels
from ...procedural.primitives.display import display
from ...procedural.props.draw import PropSettings, drawn_size
from ...procedural.props.from_file import prop_from_file
from ...procedural.props.mesh_files import MeshFile, checked_meshes, mesh_listing, metres_per_unit
from ...procedural.vessels.media import own_media
from ...procedural.vessels.settings import VesselSettings
from ...render.backend.variant import activate
from ...render.renderer import Renderer
from ..format.pictures import write_png
from ..preview.asset_sheet import asset_sheet
from ..settings.config import parse_request
from .progress import SceneProgress

_DESCRIPTION = """List the meshes of a folder as render-scene and build-dataset would use them: layout, categories,
sizes, parts, materials and licences, what is left out and what is refused, with a contact sheet of renders. With
--glass they are vessels: what they hold, how thick their walls are, and renders of them filled."""

#: Letters of a caption below a picture of the sheet [1].
LETTERS = 32


class Assets(Model):
    """The request: the folder, what is stated about its meshes, and the contact sheet."""

    folder: Annotated[UserPath, tyro.conf.Positional] = Field(description="Folder of meshes, or one mesh file")
    glass: bool = Field(default=False, description="Take the meshes as vessels (--vessel-dir), not as props")
    props: PropSettings = PropSettings()
    vessels: VesselSettings = VesselSettings()
    sheet: UserPath = Field(default=Path("assets.png"), description="PNG file of the contact sheet")
    most: int = Field(default=24, ge=0, le=400, description="Most objects on the contact sheet; 0 makes none")
    picture_width: int = Field(default=240, ge=60, le=2000, description="Width of each picture of the sheet [px]")
    samples: int = Field(default=16, ge=1, le=4096, description="Samples per pixel of the sheet")
    rows: int = Field(default=60, ge=0, description="Most objects in the list on the terminal")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _assets(given))


def _assets(arguments: Sequence[str]) -> None:
    request = parse_request(Assets, arguments, "glassware assets", _DESCRIPTION)
    stages = SceneProgress(Console())
    objects, names = (_vessels if request.glass else _props)(request, stages)
    if request.most:
        _write_sheet(request, objects, names, stages)


def _props(request: Assets, stages: SceneProgress) -> tuple[list[SceneObject], list[str]]:
    """List a folder of props, and return those of the sheet with their names."""
    listed = mesh_listing(request.folder, request.props.choice)
    checked, findings = checked_meshes(request.folder, stages.checking, choice=request.props.choice)
    files = [file for file, _ in checked]
    further = f", {counted(len(listed.left_out), 'further file')} of these"
    stages.say_all(_summary(request, [file.place for file in files], further))
    stages.say_all(_listed([_line(request, file, outcome) for file, outcome in checked], request.rows))
    _say_left_out(request, listed, stages)
    stages.say_all(report(findings))
    rng = stream(0, 0, "props/0")  # of what files do not state
    objects: list[SceneObject] = [
        prop_from_file(rng, file, drawn_size(file, request.props), id=FIRST_OBJECT_ID + i, name=f"prop-{i:03d}")
        for i, file in enumerate(files[: request.most])
    ]
    return objects, [file.name for file in files]


def _say_left_out(request: Assets, listed: Listing, stages: SceneProgress) -> None:
    if listed.left_out:
        stages.say(f"left out: {counted(len(listed.left_out), 'further file')} of objects that are used")
        left_out = [(path.relative_to(request.folder).as_posix(), why) for path, why in listed.left_out]
        stages.say_all(f"  {name}: {why}" for name, why in left_out[: request.rows])
    unread = listed_in(request.folder, UNREAD_SUFFIXES)
    if unread:
        kinds = " ".join(sorted({path.suffix.lower() for path in unread}))
        stages.say(f"not read: {counted(len(unread), 'file')} ({kinds}); Blender and others write them as GLB")
        stages.say_all(f"  {path.relative_to(request.folder).as_posix()}" for path in unread[: request.rows])


def _vessels(request: Assets, stages: SceneProgress) -> tuple[list[SceneObject], list[str]]:
    """List a folder of vessels, and return those of the sheet with their names, filled where they hold something."""
    listed = vessel_listing(request.folder)
    checked, findings = checked_vessels(request.folder, request.vessels, stages.checking)
    files = [file for file, _ in checked]
    further = f", {counted(len(listed.left_out), 'further file')} of these"
    stages.say_all(_summary(request, [file.place for file in files], further))
    stages.say_all(_listed([vessel_line(file, outcome) for file, outcome in checked], request.rows))
    _say_left_out(request, listed, stages)
    stages.say_all(report(findings))
    settings = request.vessels.model_copy(update={"fill_probability": 1.0})
    objects: list[SceneObject] = [
        draw_own_vessel(
            stream(0, i, "vessels/0"),
            stream(0, i, "media/0"),
            settings,
            file,
            id=FIRST_OBJECT_ID + i,
            name=f"vessel-{i:03d}",
            own=own_media(settings),
        )
        for i, file in enumerate(files[: request.most])
    ]
    return objects, [file.name for file in files]


def vessel_line(file: VesselFile, outcome: Checked) -> str:
    """Return a line about a vessel: size, wall, what it holds, what it is made of, licence."""
    facts = outcome.facts
    volumes = facts["volumes"]
    holds = " and ".join(volume_text(volume) for volume in volumes)
    parts = [
        " x ".join(f"{1e3 * side:.0f}" for side in facts["size"]) + " mm",
        f"{facts['faces']:,} faces",
        f"holds {holds}, wall {1e3 * facts['wall']:.1f} mm" if volumes else "solid",
        "a solid of revolution" if facts["symmetric"] else "",
        facts["glass"] or "",
        f"category {file.place.category}" if file.place.category else "",
        f"licence {file.place.licence}",
    ]
    return f"  {file.name}: " + ", ".join(part for part in parts if part)


def _listed(lines: list[str], most: int) -> list[str]:
    if len(lines) <= most:
        return lines
    return [*lines[:most], f"and {counted(len(lines) - most, 'more object')} (--rows lists more)"]


def _summary(request: Assets, places: Sequence[Place], further: str) -> list[str]:
    """Return lines of counts: by layout, category and licence."""
    lines = [f"{request.folder}: {counted(len(places), 'object')}{further}"]
    for title, values in (
        ("layout", [place.layout for place in places]),
        ("category", [place.category or "none stated" for place in places]),
        ("licence", [place.licence for place in places]),
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


def _write_sheet(request: Assets, objects: Sequence[SceneObject], names: Sequence[str], stages: SceneProgress) -> None:
    activate()
    scene = display(objects, width=request.picture_width, height=request.picture_width * 5 // 6, spp=request.samples)
    renderer = Renderer(scene)
    pictures = []
    with stages.display():
        stages.begin_views(len(objects))
        for view in range(len(objects)):
            pictures.append(srgb8(renderer.frame(view).left, scene.cameras[view].exposure, scene.cameras[view].tone))
            stages.advance(view)
    sizes = (" x ".join(f"{1e3 * side:.0f}" for side in item.size) + " mm" for item in objects)
    captions = [(_end_of(name), size) for name, size in zip(names, sizes, strict=False)]
    write_png(request.sheet, asset_sheet(pictures, captions))
    stages.say(f"{request.sheet}: {counted(len(objects), 'object')}")


def _end_of(name: str) -> str:
    """Return the end of a long name, which is what files of one folder differ in."""
    return name if len(name) <= LETTERS else f"..{name[2 - LETTERS :]}"


if __name__ == "__main__":
    sys.exit(main())
