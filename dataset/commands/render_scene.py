"""``render-scene``: one labelled scene from a seed, with its preview."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from pydantic import Field
from rich.console import Console

from ...core.exit_codes import run_command
from ...core.model import Model
from ...core.passed_over import report
from ...core.user_text import UserPath, UserText, counted
from ...procedural.scene.asset_files import asset_files
from ...procedural.scene.draw import draw_scene
from ...procedural.scene.settings import SceneSettings
from ...render.backend.variant import activate
from ...render.renderer import Renderer
from ..format import layout
from ..format.dataset_file import installed_versions, new_head, read_head, with_files
from ..format.pictures import write_png
from ..output_checks import check_output
from ..pipeline import write_scene
from ..preview.contact_sheet import chosen_views, contact_sheet
from ..settings.config import FLAT, parse_request
from ..writer import finish_dataset, start_dataset
from .progress import Stages, light_line

_DESCRIPTION = """Render one labelled scene of glass on a table.

Every setting has a dotted name; --views, --spp, --noise, --width, --height and --hdri-dir are short for longer ones.
A preset (fast, standard, syn-todd) is taken first, then a YAML file, then the command line."""


class RenderScene(Model):
    """The request: settings, seed, scene number and output folder."""

    settings: Annotated[SceneSettings, FLAT] = SceneSettings()
    seed: int = Field(default=0, ge=0, le=2**63 - 1, description="Seed of the data set, 0 to 2^63 - 1")
    scene: int = Field(default=0, ge=0, le=999_999, description="Number of the scene in the data set, 0 to 999999")
    out: UserPath = Field(default=Path("out"), description="Folder of the data set: absent, empty, or one made before")
    name: UserText = Field(default="glassware", description="Name of the data set")
    preset: str = Field(default="fast", description="Settings to start from: fast, standard or syn-todd")
    config: UserPath | None = Field(default=None, description="YAML file of settings on top of the preset")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; the exit code says how it went."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _render_scene(given))


def _render_scene(arguments: Sequence[str]) -> None:
    request = parse_request(RenderScene, arguments, "render-scene", _DESCRIPTION)
    settings = request.settings
    stages = Stages(Console())
    with stages.stopwatch.stage("backend"):
        backend = activate(spectral=settings.picture.spectral)
    config = settings.model_dump(mode="json")
    head = new_head(request.name, request.seed, config, installed_versions(), backend)
    check_output(request.out, head, [request.scene])
    with stages.stopwatch.stage("inputs"):
        files = asset_files(settings, stages.checking)
    stages.say_all(report(files.findings))
    head = with_files(head, files)
    _say_what_is_done(request, stages)
    with stages.stopwatch.stage("description"):
        scene = draw_scene(settings, request.seed, request.scene, files)
    start_dataset(request.out, head, [request.scene])
    renderer = Renderer(scene)
    if renderer.light_check is not None:
        stages.say(light_line(renderer.light_check))
    with stages.progress(len(scene.cameras)):
        shown = chosen_views(len(scene.cameras))
        written = write_scene(request.out, renderer, stages.stopwatch, stages.advance, shown)
    with stages.stopwatch.stage("preview"):
        finish_dataset(request.out, head)
        sheet = contact_sheet(f"seed {request.seed}, scene {request.scene}", written.previews)
        write_png(request.out / layout.PREVIEW, sheet)
    stages.report(f"{request.out}: scene {request.scene} of seed {request.seed}", len(scene.cameras))


def _say_what_is_done(request: RenderScene, stages: Stages) -> None:
    if request.scene in layout.scene_ids(request.out):
        stages.say(f"{request.out}: scene {request.scene} of seed {read_head(request.out).seed} will be replaced")
    views = counted(request.settings.cameras.views, "view")
    stages.say(f"drawing scene {request.scene} of seed {request.seed}, then {views}")


if __name__ == "__main__":
    sys.exit(main())
