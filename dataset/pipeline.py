"""One scene from its description to its files: loaded, lit, rendered, labelled and written, view by view.

`render-scene` and the workers of a build call the same function, so a scene is the same by either.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from ..annotate.keypoints import SceneKeypoints, scene_keypoints
from ..annotate.labels import annotate, with_noise
from ..procedural.description.scene import Scene
from ..render.frame import LightCheck, SurfaceLight
from .format import layout
from .format.pictures import srgb8
from .format.views_table import ViewRow
from .preview.contact_sheet import PreviewRow
from .writer import View, write_scene

if TYPE_CHECKING:
    from ..render.pictures.picture import Tracer
    from ..render.scene.loaded_scene import LoadedScene


class Watch(Protocol):
    """Who is told of the work: how long each stage takes, and that a view is done."""

    def say(self, line: str) -> None:
        """Take a line for people."""
        ...

    def timed(self, stage: str) -> AbstractContextManager[None]:
        """Count what happens inside towards a stage."""
        ...

    def add(self, seconds: Mapping[str, float]) -> None:
        """Add seconds to stages."""
        ...

    def advance(self) -> None:
        """Take note that a view is rendered; may raise to stop the work."""
        ...


@dataclass(frozen=True, eq=False)
class Lit:
    """A loaded scene, and how its light is found: by paths, or as stored."""

    kernel: LoadedScene
    tracer: Tracer
    check: LightCheck | None
    light: SurfaceLight | None  #: what was stored, where it is to be kept


@dataclass(frozen=True, eq=False)
class Made:
    """What became of a scene."""

    rows: list[ViewRow]  #: of the index
    previews: list[PreviewRow]  #: of the views that were asked for
    check: LightCheck | None  #: of the stored light


def make_scene(root: Path, scene: Scene, watch: Watch, shown: Collection[int] = ()) -> Made:
    """Render, label and write a scene view by view; the folder appears after the last one.

    Parameters
    ----------
    root : Path
        The data set, started (`writer.start_dataset`).
    scene : Scene
        The description; the backend is active.
    watch : Watch
        Is told of the work.
    shown : collection of int
        Views that are wanted for a contact sheet.
    """
    points = scene_keypoints(scene)
    lit = light_scene(scene, watch)
    previews = []

    def views() -> Iterator[View]:
        for number in range(len(scene.cameras)):
            view = make_view(lit, points, number, watch)
            watch.advance()
            if number in shown:
                previews.append(_preview_row(scene, view))
            with watch.timed("writing"):
                yield view

    return Made(write_scene(root, scene, points, views(), lit.check, lit.light), previews, lit.check)


def light_scene(scene: Scene, watch: Watch) -> Lit:
    """Load the scene, and store its light where that is asked for or pays."""
    # Only here: these bring Mitsuba, whose variant must be set first.
    from ..render.cache.export import surface_light
    from ..render.cache.scene_cache import is_shared, shared_light
    from ..render.pictures.picture import PATH_TRACER
    from ..render.scene.loaded_scene import load

    shared = is_shared(scene)
    with watch.timed("loading"):
        kernel = load(scene, for_cache=shared)
    if not shared:
        return Lit(kernel, PATH_TRACER, None, None)
    with watch.timed("light"):
        tracer, check, stored = shared_light(kernel)
    watch.say(
        f"light of the scene stored at {check.nodes} places; pictures from it differ from path-traced ones by "
        f"{check.difference:+.2%} in the mean (standard error {check.standard_error:.2%})"
        + ("" if check.mode == "shared" else f", more than {check.bound:.0%}: paths are traced instead")
    )
    return Lit(kernel, tracer, check, surface_light(kernel, stored) if scene.picture.keep_light else None)


def make_view(lit: Lit, points: SceneKeypoints, number: int, watch: Watch) -> View:
    """Render and label one view."""
    from ..render.labels.geometry import line_of_sight
    from ..render.view import render_view

    scene = lit.kernel.description
    camera = scene.cameras[number]
    frame = render_view(lit.kernel, number, lit.tracer)
    watch.add(frame.seconds)
    with watch.timed("labels"):
        sight = line_of_sight(lit.kernel, camera.world_T_camera[:3, 3], points.world.reshape(-1, 3))
        labels = with_noise(annotate(scene, camera, frame.geometry, points, sight), frame.sampling)
    return View(number, frame, labels)


def _preview_row(scene: Scene, view: View) -> PreviewRow:
    camera = scene.cameras[view.number]
    picture = srgb8(view.frame.left, camera.exposure)
    return PreviewRow(layout.view_name(view.number), picture, camera, view.frame.geometry, view.labels)
