"""``render-scene``: one labelled scene from a seed, with its preview."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import Field
from rich.console import Console

from ...annotate.keypoints import SceneKeypoints, scene_keypoints
from ...annotate.labels import annotate, with_noise
from ...procedural.description import Scene
from ...procedural.draw import draw_scene
from ...procedural.inputs import check_inputs
from ...procedural.sanity import check_scene
from ...procedural.settings import SceneSettings
from ...procedural.user_text import UserPath, UserText
from ...render.frame import LightCheck
from ...render.machine.backend import activate
from .. import layout
from ..config import layered, parsed
from ..dataset_file import DatasetFile, installed_versions
from ..pictures import srgb8, write_png
from ..preview import PreviewRow, chosen_views, contact_sheet
from ..writer import View, check_output, finish_dataset, read_head, start_dataset, write_scene
from .outcome import outcome
from .progress import Stages

if TYPE_CHECKING:
    from ...render.pictures.picture import Tracer
    from ...render.scene.kernel import Kernel

_DESCRIPTION = """Render one labelled scene of glass on a table.

Every setting has a dotted name; --views, --spp, --noise, --width, --height and --hdri-dir are short for longer ones.
A preset (fast, standard, syn-todd) is taken first, then a YAML file, then the command line."""


class RenderScene(SceneSettings):
    """The request: what to draw, from which seed, and where to put it."""

    seed: int = Field(default=0, ge=0, le=2**63 - 1, description="Seed of the data set, 0 to 2^63 - 1")
    scene: int = Field(default=0, ge=0, le=999_999, description="Number of the scene in the data set, 0 to 999999")
    out: UserPath = Field(default=Path("out"), description="Folder of the data set: absent, empty, or one made before")
    name: UserText = Field(default="glassware", description="Name of the data set")
    preset: str = Field(default="fast", description="Settings to start from: fast, standard or syn-todd")
    config: UserPath | None = Field(default=None, description="YAML file of settings on top of the preset")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; the exit code says how it went."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return outcome(lambda: _render_scene(given))


def _render_scene(arguments: Sequence[str]) -> None:
    request = parsed(RenderScene, layered(RenderScene, arguments), arguments, "render-scene", _DESCRIPTION)
    settings = SceneSettings.model_validate({name: getattr(request, name) for name in SceneSettings.model_fields})
    stages = Stages(Console())
    with stages.timed("backend"):
        backend = activate(spectral=settings.picture.spectral)
    head = DatasetFile(
        name=request.name,
        seed=request.seed,
        config=settings.model_dump(mode="json"),
        versions=installed_versions(),
        backend=backend,
    )
    check_output(request.out, head, [request.scene])
    with stages.timed("inputs"):
        check_inputs(settings)
    _say_what_is_done(request, stages)
    with stages.timed("description"):
        scene = draw_scene(settings, request.seed, request.scene)
        check_scene(scene)
    start_dataset(request.out, head, [request.scene])
    previews = _written(request.out, scene, stages)
    with stages.timed("preview"):
        finish_dataset(request.out, head)
        sheet = contact_sheet(f"seed {request.seed}, scene {request.scene}", previews)
        write_png(request.out / layout.PREVIEW, sheet)
    stages.report(f"{request.out}: scene {request.scene} of seed {request.seed}", len(scene.cameras))


def _say_what_is_done(request: RenderScene, stages: Stages) -> None:
    if request.scene in layout.scene_ids(request.out):
        stages.say(f"{request.out}: scene {request.scene} of seed {read_head(request.out).seed} will be replaced")
    stages.say(f"drawing scene {request.scene} of seed {request.seed}, then {request.cameras.views} views")


def _written(out: Path, scene: Scene, stages: Stages) -> list[PreviewRow]:
    """Render, label and write the scene view by view; return the views of the preview."""
    points = scene_keypoints(scene)
    kernel, tracer, check = _lit(scene, stages)
    shown, rows = set(chosen_views(len(scene.cameras))), []

    def views() -> Iterator[View]:
        for view in _views(kernel, tracer, points, stages):
            if view.number in shown:
                rows.append(_preview_row(scene, view))
            with stages.timed("writing"):
                yield view

    with stages.progress(len(scene.cameras)):
        write_scene(out, scene, points, views(), check)
    return rows


def _preview_row(scene: Scene, view: View) -> PreviewRow:
    camera = scene.cameras[view.number]
    picture = srgb8(view.frame.left, camera.exposure)
    return PreviewRow(layout.view_name(view.number), picture, camera, view.frame.geometry, view.labels)


def _lit(scene: Scene, stages: Stages) -> tuple[Kernel, Tracer, LightCheck | None]:
    """Load the scene, and store its light where that is asked for or pays."""
    # Only here: these bring Mitsuba, whose variant must be set first.
    from ...render.light.scene_light import is_shared, shared_light
    from ...render.pictures.picture import PATHS
    from ...render.scene.kernel import load

    shared = is_shared(scene)
    with stages.timed("loading"):
        kernel = load(scene, cut=shared)
    if not shared:
        return kernel, PATHS, None
    with stages.timed("light"):
        tracer, check = shared_light(kernel)
    stages.say(
        f"light of the scene stored at {check.nodes} places; pictures from it differ from path-traced ones by "
        f"{check.difference:+.2%} in the mean (standard error {check.standard_error:.2%})"
        + ("" if check.mode == "shared" else f", more than {check.bound:.0%}: paths are traced instead")
    )
    return kernel, tracer, check


def _views(kernel: Kernel, tracer: Tracer, points: SceneKeypoints, stages: Stages) -> Iterator[View]:
    from ...render.labels.sight import line_of_sight
    from ...render.view import render_view

    scene = kernel.description
    for number, camera in enumerate(scene.cameras):
        frame = render_view(kernel, number, tracer)
        stages.add(frame.seconds)
        with stages.timed("labels"):
            sight = line_of_sight(kernel, camera.world_T_camera[:3, 3], points.world.reshape(-1, 3))
            labels = with_noise(annotate(scene, camera, frame.geometry, points, sight), frame.sampling)
        stages.advance()
        yield View(number, frame, labels)


if __name__ == "__main__":
    sys.exit(main())
