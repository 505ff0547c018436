"""Optics that other renderers simplify, on request: glass without shadows, and air between glass and liquids.

They show what a picture, or a network that learns from pictures, owes to the right optics.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple, TypeAlias

from ...core.errors import InputError
from .._mitsuba import dr, mi
from ..frame import PARTS
from ..interfaces.air_film import scatter_at_film
from ..interfaces.dielectric import InterfaceHit, Scattered
from ..scene.loaded_scene import LoadedScene
from ..scene.spectrum import index_at
from ..scene.surfaces import AIR_INDEX, SurfaceMedia

#: (ray, whether rays are coherent, active, direct) -> what rays meet. `direct`: paths that have met no opaque surface.
Meet: TypeAlias = "Callable[[mi.Ray3f, mi.Bool, mi.Bool, mi.Bool], mi.PreliminaryIntersection3f]"
#: (surface, medium of the segment, direct) -> both, as they count.
MediaAt: TypeAlias = "Callable[[SurfaceMedia, mi.UInt32, mi.Bool], tuple[SurfaceMedia, mi.UInt32]]"
#: (hit, throughput) -> scattering at an interface.
InterfaceEvent: TypeAlias = "Callable[[InterfaceHit, mi.Spectrum], Scattered]"
#: (surface, hit, throughput, wavelengths) -> scattering at an interface.
SurfaceEvent: TypeAlias = "Callable[[SurfaceMedia, InterfaceHit, mi.Spectrum, Any], Scattered]"


class Optics(NamedTuple):
    """What happens to paths between and at surfaces."""

    meet: Meet
    media_at: MediaAt
    scattered: SurfaceEvent


def simplified_optics(loaded: LoadedScene, interface_event: InterfaceEvent) -> Optics:
    """Return the optics that the picture of a scene asks for: those of nature, if it asks for no other.

    Parameters
    ----------
    loaded : LoadedScene
        The scene, with its `Picture`.
    interface_event : callable
        Scattering at an interface as it is in nature.

    Raises
    ------
    InputError
        Where there is air between glass and liquids, in polarised variants.
    """
    return Optics(*_past_glass(loaded), _with_air_film(loaded, interface_event))


def _past_glass(loaded: LoadedScene) -> tuple[Meet, MediaAt]:
    """Return what rays meet: after the first opaque surface no glass, and so no medium but air, where it has no shadow.

    Shadow rays pass it as well (`Emitters.occluders`).
    """
    scene, bare = loaded.mi_scene, loaded.emitters.occluders
    if bare is None:
        return lambda ray, coherent, active, direct: scene.ray_intersect_preliminary(ray, coherent, active), _as_it_is

    def meet(ray: mi.Ray3f, coherent: mi.Bool, active: mi.Bool, direct: mi.Bool) -> mi.PreliminaryIntersection3f:
        seen = scene.ray_intersect_preliminary(ray, coherent, active & direct)
        return dr.select(direct, seen, bare.ray_intersect_preliminary(ray, False, active & ~direct))

    def media_at(surface: SurfaceMedia, medium: mi.UInt32, direct: mi.Bool) -> tuple[SurfaceMedia, mi.UInt32]:
        before = dr.select(direct, surface.before, AIR_INDEX)
        return replace(surface, before=before), dr.select(direct, medium, before)

    return meet, media_at


def _as_it_is(surface: SurfaceMedia, medium: mi.UInt32, _direct: mi.Bool) -> tuple[SurfaceMedia, mi.UInt32]:
    return surface, medium


def _with_air_film(loaded: LoadedScene, interface_event: InterfaceEvent) -> SurfaceEvent:
    """Return scattering at interfaces, with a film of air between glass and liquids where the picture has one."""
    table = loaded.surfaces
    if not loaded.description.picture.air_gap:
        return lambda surface, hit, beta, wavelengths: interface_event(hit, beta)
    if mi.is_polarized:
        raise InputError("picture.air_gap", "no in polarised pictures", "yes")

    def scattered(surface: SurfaceMedia, hit: InterfaceHit, beta: mi.Spectrum, wavelengths: Any) -> Scattered:
        before = index_at(table.eta_render, surface.before, wavelengths, mi.Bool(True))
        wet = dr.gather(mi.UInt32, table.part, surface.row) == PARTS.index("wet_wall")
        return dr.select(wet, scatter_at_film(hit, before), interface_event(hit, beta))

    return scattered
