"""The work of ``render-scene``: from its request to the files of a scene, with its steps on the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ...core.passed_over import report
from ...core.user_text import counted, sized
from ...procedural.scene.asset_files import asset_files
from ...procedural.scene.draw import draw_scene
from ...render.backend.variant import activate
from ...render.frame import Draft, LightCheck
from ...render.renderer import Renderer
from ..builds.space import folder_size
from ..format import layout
from ..format.dataset_file import installed_versions, new_head, read_head, with_files
from ..format.developed import check_camera
from ..format.pictures import write_png
from ..output_checks import check_output
from ..pipeline import write_scene
from ..preview.contact_sheet import chosen_views, contact_sheet
from ..writer import finish_dataset, start_dataset
from .progress import SceneProgress, clock, failed_lines, light_line
from .scene_request import RenderScene


def made_scene(request: RenderScene, progress: SceneProgress) -> str:
    """Draw, render and write the scene of a request; return a line that says what was made.

    Raises
    ------
    InputError
        Where the folder holds something else, a file of the settings cannot be used, or there is no backend.
    """
    settings, stopwatch = request.settings, progress.stopwatch
    with stopwatch.stage("backend"):
        backend = activate(spectral=settings.picture.spectral)
    head = new_head(
        request.name, request.seed, settings.model_dump(mode="json"), installed_versions(), backend, files=request.write
    )
    check_output(request.out, head, [request.scene])
    with stopwatch.stage("inputs"):
        check_camera(settings)
        files = asset_files(settings, progress.checking)
    progress.say_all(report(files.findings))
    head = with_files(head, files)
    if request.scene in layout.scene_ids(request.out):
        replaced = read_head(request.out).seed
        progress.say(f"{request.out}: scene {request.scene} of seed {replaced} will be replaced")
    progress.step("drawing the scene")
    with stopwatch.stage("description"):
        scene = draw_scene(settings, request.seed, request.scene, files)
    start_dataset(request.out, head, [request.scene])
    with _draft(request, progress) as show:
        renderer = Renderer(scene, on_stage=progress.on_stage, on_draft=show)
        _say_light(renderer.light_check, request.verbose, progress)
        progress.begin_views(len(scene.cameras))
        shown = chosen_views(len(scene.cameras))
        written = write_scene(request.out, renderer, stopwatch, progress.advance, shown, request.write)
        progress.step("writing the index and the contact sheet")
        with stopwatch.stage("preview"):
            finish_dataset(request.out, head)
            sheet = contact_sheet(f"seed {request.seed}, scene {request.scene}", written.previews)
            write_png(request.out / layout.PREVIEW, sheet)
    return _made(request, progress)


@contextmanager
def _draft(request: RenderScene, progress: SceneProgress) -> Iterator[Callable[[Draft], None]]:
    """Yield what writes a first picture into the folder and says so; it is there until the block ends."""
    path = request.out / layout.DRAFT

    def show(draft: Draft) -> None:
        write_png(path, draft.picture)
        what = f"a draft of the first view, noisy and without caustics, until {layout.PREVIEW} is there"
        progress.say(f"{progress.seconds:6.1f} s  {path}: {what}")

    try:
        yield show
    finally:
        path.unlink(missing_ok=True)


def _say_light(check: LightCheck | None, verbose: bool, progress: SceneProgress) -> None:
    if check is not None:
        for line in ([light_line(check)] if verbose else []) + failed_lines(check):
            progress.say(line)


def _made(request: RenderScene, progress: SceneProgress) -> str:
    """Return what was made, where, how large, and what to do next."""
    cameras, out = request.settings.cameras, request.out
    pixels = cameras.intrinsics()
    views = counted(cameras.views, "stereo view")
    size = sized(folder_size(layout.scene_folder(out, request.scene)))
    return (
        f"{out}: scene {request.scene} of seed {request.seed}, {views} of {pixels.width}x{pixels.height} px, {size}, "
        f"after {clock(progress.seconds)}. Look at {out / layout.PREVIEW} (glassware show {out})"
    )
