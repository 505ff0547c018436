"""The renderer: a scene description in, frames out, rendered as the description says.

`Renderer` owns all that lies between the two: the Mitsuba variant, the loaded scene, the choice between path tracing
and the irradiance cache, the cache itself and its check against path tracing.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..core.arguments import check_type, described, number, one_of, several, whole_number
from ..core.arguments import points as checked_points
from ..core.errors import InputError
from ..core.margin import NO_MARGIN, Sides
from ..core.randomness import stream_seed
from ..core.stopwatch import Stopwatch
from ..procedural.description.camera import LONGEST_SIDE
from ..procedural.description.depth_camera import DepthCamera
from ..procedural.description.scene import Scene
from ..procedural.description.time_of_flight import DepthDevice, TimeOfFlightCamera
from ..procedural.scene.validate import check_scene
from .backend.variant import SPAWN, activate, check_colours, check_process
from .frame import (
    EYES,
    Beams,
    Draft,
    Eye,
    Frame,
    Geometry,
    Infrared,
    LightCheck,
    LineOfSight,
    StokesPicture,
    SurfaceLight,
    Transmission,
)

#: Dr.Jit and the active variant belong to the whole process: one renderer works at a time.
_process_lock = threading.RLock()
#: Most threads of the processor's kernels: more than the cores of any machine that this was run on.
MOST_THREADS = 1024
#: Most surfaces of a ray that are recorded, as `Picture.layers` has it.
MAX_LAYERS = 64


class Renderer:
    """Renders the views of one scene.

    Several renderers, of any scenes and variants, may live side by side. Calls from several threads wait.

    Parameters
    ----------
    scene : Scene
        The description. It is checked (`procedural.scene.validate.check_scene`), so that a changed copy that
        contradicts itself is refused here.
    variant : str, optional
        Mitsuba variant, such as ``"llvm_ad_rgb"``; by default the best that works here and fits `scene.picture`.
    threads : int, optional
        Threads of the processor's kernels, 1 to `MOST_THREADS`; by default one per core. Pictures do not depend on it.
    on_stage : callable, optional
        Called with "loading" and, where the irradiance cache is filled, with "light", before each begins.
    on_draft : callable, optional
        Called with a `Draft` before the irradiance cache is filled, which takes most of the time to the first view.

    Attributes
    ----------
    scene : Scene
        The description.
    variant : str
        The variant that the scene was loaded in.
    light_check : LightCheck or None
        How pictures from the irradiance cache compare with path-traced ones; None where paths are traced.
    seconds : dict of str to float
        Time spent on "loading" and, where the irradiance cache was filled, on "light" [s].

    Raises
    ------
    InputError
        For a scene that cannot exist, a variant that does not exist or does not fit the scene, or a machine without a
        backend; the message says what to install. Also in a process that was forked after a renderer was made.
    """

    def __init__(
        self,
        scene: Scene,
        variant: str | None = None,
        threads: int | None = None,
        on_stage: Callable[[str], None] | None = None,
        on_draft: Callable[[Draft], None] | None = None,
    ) -> None:
        # Checked before the lock, which a forked process may have inherited locked.
        check_process()
        if threads is not None:
            threads = whole_number("Renderer: threads", threads, 1, MOST_THREADS)
        if variant is not None:
            check_type("Renderer: variant", variant, str, "the name of a variant, such as 'llvm_ad_rgb'")
        check_type("Renderer: scene", scene, Scene, "a Scene, from gw.draw or gw.load_scene")
        for name, call in (("on_stage", on_stage), ("on_draft", on_draft)):
            if call is not None and not callable(call):
                raise InputError(f"Renderer: {name}", "a function", described(call))
        check_scene(scene)
        self.scene = scene
        on_stage = on_stage or (lambda _stage: None)
        self.light_check: LightCheck | None = None
        self._process, stopwatch = os.getpid(), Stopwatch()
        with _process_lock:
            self.variant = activate(variant, spectral=scene.picture.spectral, threads=threads)
            check_colours(self.variant, scene.picture.spectral)
            # Imported here, so that importing this module loads neither Mitsuba nor the labels' and pictures' code.
            from .cache.draft import draft_picture
            from .cache.scene_cache import make_tracer, uses_cache
            from .pictures.picture import PATH_TRACER
            from .scene.loaded_scene import load

            on_stage("loading")
            cached = uses_cache(scene)
            with stopwatch.stage("loading"):
                self.loaded = load(scene, for_cache=cached)
            if cached and on_draft is not None:
                with stopwatch.stage("draft"):
                    on_draft(draft_picture(self.loaded))
            self._tracer, self._cache = PATH_TRACER, None
            self._polarised: tuple[Any, ...] = ()
            if cached:
                on_stage("light")
                with stopwatch.stage("light"):
                    self._tracer, self.light_check, self._cache = make_tracer(self.loaded)
        self.seconds = stopwatch.seconds

    def __repr__(self) -> str:
        light = "paths" if self.light_check is None or self.light_check.mode == "path" else "irradiance cache"
        return f"Renderer({self.scene!r}, {self.variant}, {light})"

    def frame(self, view: int, margin: Sides = NO_MARGIN) -> Frame:
        """Render one view: both pictures, denoised, and the geometry that labels come from.

        Parameters
        ----------
        view : int
            Number of the camera in ``scene.cameras``.
        margin : (int, int, int, int)
            Columns and rows beyond the left, top, right and bottom border that `Frame.oversize` has [px].

        Returns
        -------
        Frame
            It depends on the scene and the view alone: not on other views or what was rendered before.

        Raises
        ------
        InputError
            Where the scene has no such view, or the margin is not four whole numbers within 0 and `LONGEST_SIDE`.
        """
        sides = several("margin", margin, 4, "four whole numbers: left, top, right, bottom [px]")
        left, top, right, bottom = (whole_number("margin", side, 0, LONGEST_SIDE) for side in sides)
        with self._active():
            return self._rendered(self._view(view), (left, top, right, bottom))

    def geometry(self, view: int, eye: Eye = "left") -> Geometry:
        """Trace the straight rays through the pixel centres of one eye; that of the left one is in every frame as well.

        Parameters
        ----------
        view : int
            Number of the camera in ``scene.cameras``.
        eye : {"left", "right"}
            Which of the two cameras.

        Raises
        ------
        InputError
            Where the scene has no such view, or there is no such eye.
        """
        from .labels.geometry import trace_geometry

        camera = self.scene.cameras[self._view(view)]
        one_of("eye", eye, EYES)
        with self._active():
            return trace_geometry(self.loaded, camera, eye)

    def transmission(
        self, view: int, layers: int, shift: tuple[float, float] = (0.0, 0.0)
    ) -> tuple[Geometry, np.ndarray, Transmission]:
        """Trace the left camera's straight rays beside the pixel centres, and what each surface along them passes on.

        Parameters
        ----------
        view : int
            Number of the camera in ``scene.cameras``.
        layers : int
            Number of surfaces of each ray that are recorded, 1 to `MAX_LAYERS`.
        shift : (float, float)
            How far to the right and down of its pixel's centre each ray goes through the picture [px].

        Returns
        -------
        geometry : Geometry
            Of these rays.
        count : (H, W) int
            Surfaces along each ray, also of those that are not recorded.
        transmission : Transmission
            Of the recorded ones.

        Raises
        ------
        InputError
            Where the scene has no such view, or a number is out of range.
        """
        from .labels.geometry import trace_transmission

        camera, count = self.scene.cameras[self._view(view)], whole_number("layers", layers, 1, MAX_LAYERS)
        both = several("shift", shift, 2, "two numbers: to the right and down [px]")
        u, v = (number(f"shift {axis}", by, -1.0, 1.0) for axis, by in zip("uv", both, strict=True))
        # A ray beside the pixel's centre is the ray through it of a camera whose principal point is shifted back.
        beside = camera.model_copy(update={"centre": (camera.centre[0] - u, camera.centre[1] - v)})
        with self._active():
            return trace_transmission(self.loaded, beside, count)

    def line_of_sight(self, view: int, points: np.ndarray, eye: Eye = "left") -> LineOfSight:
        """Trace straight rays from one eye of a view towards points.

        Parameters
        ----------
        view : int
            Number of the camera in ``scene.cameras``.
        points : (n, 3) float
            Targets, world frame [m].
        eye : {"left", "right"}
            Which of the two cameras the rays start from.

        Raises
        ------
        InputError
            Where the scene has no such view, there is no such eye, or the points are not finite numbers of this shape.
        """
        from .labels.geometry import line_of_sight

        camera = self.scene.cameras[self._view(view)]
        one_of("eye", eye, EYES)
        origin = (camera.world_T_camera if eye == "left" else camera.world_T_right)[:3, 3]
        targets = checked_points("points", points)
        with self._active():
            return line_of_sight(self.loaded, origin, targets)

    def infrared(self, view: int) -> Infrared:
        """Trace what the depth camera's infrared cameras see of one view; in scenes with one, every frame has it.

        Parameters
        ----------
        view : int
            Number of the camera in ``scene.cameras``.

        Raises
        ------
        InputError
            Where the scene has no such view, or no depth camera.
        """
        from .infrared.pictures import trace_infrared

        device, number = self.scene.depth_camera, self._view(view)
        if not isinstance(device, DepthCamera):
            raise InputError("scene, depth_camera", "a stereo camera, such as sensors.depth d435", _named(device))
        with self._active():
            return trace_infrared(self.loaded, number, device, self._tracer)

    def beams(self, view: int) -> Beams:
        """Trace the beams of a time-of-flight camera in one view; in scenes with one, every frame has them.

        Parameters
        ----------
        view : int
            Number of the camera in ``scene.cameras``.

        Raises
        ------
        InputError
            Where the scene has no such view, or no time-of-flight camera.
        """
        from .infrared.beams import trace_beams

        device, number = self.scene.depth_camera, self._view(view)
        if not isinstance(device, TimeOfFlightCamera):
            raise InputError("scene, depth_camera", "a time-of-flight camera, as sensors.depth l515", _named(device))
        with self._active():
            return trace_beams(self.loaded, number, device)

    def stokes(self, view: int, samples: int | None = None) -> StokesPicture:
        """Trace the Stokes vectors that the left camera sees; with a polarisation camera, every frame has them.

        Parameters
        ----------
        view : int
            Number of the camera in ``scene.cameras``.
        samples : int, optional
            Paths of each pixel that shows glass; by default those of the polarisation camera.

        Raises
        ------
        InputError
            Where the scene has no such view, or neither `samples` nor a polarisation camera.
        """
        from .pictures.stokes import load_channels, room_light, trace_stokes_view

        device, number = self.scene.polarisation_camera, self._view(view)
        if samples is None and device is None:
            raise InputError("scene, polarisation_camera", "one, as sensors.polarisation imx250mzr, or samples", "none")
        count = whole_number("samples", device.samples if samples is None and device else samples, 1, 1 << 20)
        seed = stream_seed(self.scene.seed, self.scene.scene_id, f"render/{number}/stokes")
        polarised = f"{self.variant.split('_')[0]}_ad_{'spectral' if 'spectral' in self.variant else 'mono'}_polarized"
        with self._active():
            light = room_light(self.loaded)
            try:
                activate(polarised)
                self._polarised = self._polarised or load_channels(self.scene, light)
                return trace_stokes_view(self._polarised, self.scene.cameras[number], count, seed)
            finally:
                activate(self.variant)

    def surface_light(self) -> SurfaceLight | None:
        """Return the irradiance cache as a list of points; None where paths are traced."""
        if self._cache is None:
            return None
        from .cache.scene_cache import surface_light

        with self._active():
            return surface_light(self.loaded, self._cache)

    def _view(self, view: int) -> int:
        return whole_number("view", view, 0, len(self.scene.cameras) - 1)

    @contextmanager
    def _active(self) -> Iterator[None]:
        """Hold the process for a block in which this renderer's variant is the active one."""
        # Checked before the lock, which a forked process may have inherited locked.
        if os.getpid() != self._process:
            expected = f"to be used in the process that made it ({self._process}); {SPAWN} and make one in each"
            raise InputError("renderer", expected, f"process {os.getpid()}, forked from it")
        with _process_lock:
            activate(self.variant)
            yield

    def _rendered(self, view: int, margin: Sides) -> Frame:
        from .labels.geometry import trace_straight
        from .labels.refraction import trace_refraction
        from .oversize import trace_oversize
        from .pictures.picture import final_pictures, trace_picture

        scene, stopwatch = self.scene, Stopwatch()
        camera, picture = scene.cameras[view], scene.picture
        seeds: dict[Eye, int] = {eye: stream_seed(scene.seed, scene.scene_id, f"render/{view}/{eye}") for eye in EYES}
        with stopwatch.stage("picture"):
            eyes = [trace_picture(self.loaded, camera, eye, seed, self._tracer) for eye, seed in seeds.items()]
        with stopwatch.stage("geometry"):
            geometry, layers = trace_straight(self.loaded, camera, picture.layers)
        with stopwatch.stage("refraction"):
            refraction = trace_refraction(self.loaded, [camera])[0] if picture.refraction else None
        infrared = beams = None
        if scene.depth_camera is not None:
            with stopwatch.stage("infrared"):
                if isinstance(scene.depth_camera, DepthCamera):
                    infrared = self.infrared(view)
                else:
                    beams = self.beams(view)
        with stopwatch.stage("polarisation"):
            stokes = None if scene.polarisation_camera is None else self.stokes(view)
        with stopwatch.stage("denoise"):
            clean, raw = final_pictures(eyes, picture)
        with stopwatch.stage("margin"):
            frames = (eyes, clean, geometry.Z)
            wide = trace_oversize(self.loaded, view, margin, *frames, self._tracer, raw) if any(margin) else None
        return Frame(
            view=view,
            left=clean[0],
            right=clean[1],
            left_noisy=eyes[0].radiance if picture.denoise else None,
            right_noisy=eyes[1].radiance if picture.denoise else None,
            geometry=geometry,
            seconds=stopwatch.seconds,
            sampling=(eyes[0].sampling, eyes[1].sampling),
            layers=layers if picture.layers else None,
            refraction=refraction,
            infrared=infrared,
            beams=beams,
            stokes=stokes,
            raw=raw,
            oversize=wide,
            exposure=camera.exposure,
            tone=camera.tone,
            scene=scene,
        )


def _named(device: DepthDevice | None) -> str:
    return "none" if device is None else device.name
