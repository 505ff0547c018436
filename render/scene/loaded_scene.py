"""Loads a scene description into Mitsuba: shapes, BSDFs and emitters, and the table of its surfaces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...core.mesh import as_trimesh
from ...procedural.description.material import OpaqueMaterial
from ...procedural.description.scene import Scene
from .._mitsuba import mi
from .bodies import Body, mitsuba_mesh, refined_for_cache, scene_bodies, to_world
from .emitters import Emitters
from .lighting import area_light, envmap, make_literals_opaque
from .room import lamp_surface, lit_emitter, room_surfaces_of
from .room_emitter import RoomEmitter
from .sensor_response import SensorResponse, sensor_response
from .spectrum import check_variant, in_channel, unpolarised
from .surfaces import Surface, SurfaceTable, registry_id, surface_table

#: Offset of rays from the surface that they leave, along its geometric normal, over the scene's largest coordinate [1].
#: A float32 coordinate has 24 bits; barycentric interpolation and the intersection lose up to three, and one is margin.
#: (Mitsuba's own offset of 1e-4 (1 + |p|) is 0.1 mm here, a tenth of a glass wall.)
RAY_OFFSET = 2.0**-20


@dataclass(frozen=True, eq=False)
class OpaqueBody:
    """A loaded opaque mesh, in the world frame."""

    row: int  #: registry id of its shape
    positions: np.ndarray  #: (n, 3) float32 [m]
    normals: np.ndarray  #: (n, 3) float32, shading normals on the front side; not normalised
    faces: np.ndarray  #: (m, 3) int64
    closed: bool  #: whether the mesh is watertight, so that its back side is never visible
    roughness: float  #: of the principled material
    metallic: float


@dataclass(frozen=True, eq=False)
class LoadedScene:
    """A scene in Mitsuba, ready for ray tracing."""

    description: Scene
    mi_scene: mi.Scene
    robust_scene: mi.Scene  #: the shapes as they were loaded, without cracks between triangles (`rays.without_crack`)
    surfaces: SurfaceTable
    emitters: Emitters
    offset: float  #: distance at which rays start off a surface [m]
    opaque_bodies: tuple[OpaqueBody, ...] = ()  #: only where loaded for the irradiance cache
    materials: Mapping[str, OpaqueMaterial] = field(default_factory=dict)  #: of opaque shapes, by the shape's name
    sensor: SensorResponse | None = None  #: of the colour cameras; None: the standard observer alone

    @property
    def room(self) -> RoomEmitter | None:
        """The room, where it is in its place."""
        return self.emitters.room

    def raw(self, radiance: mi.Spectrum, weight: mi.UnpolarizedSpectrum, wavelengths: Any) -> mi.Color3f | None:
        """Return what the sensor makes of radiance, polarised or not, with weighted wavelengths; None without one."""
        return None if self.sensor is None else self.sensor.of(unpolarised(radiance) * weight, wavelengths)


def load(
    scene: Scene,
    glass_for_mitsuba: bool = False,
    for_cache: bool = False,
    channel: int | None = None,
    room_light: np.ndarray | None = None,
) -> LoadedScene:
    """Load a scene into Mitsuba (the variant must be active: `render.backend.variant.activate`).

    Parameters
    ----------
    scene : Scene
        The description.
    glass_for_mitsuba : bool
        Give glass the BSDFs that Mitsuba's own integrators need. Our integrators refract by the surface table; each
        such BSDF would be compiled into their kernels with its index, without use.
    for_cache : bool
        Refine opaque meshes for the irradiance cache, whose points are their vertices, and list them in
        `LoadedScene.opaque_bodies`.
    channel : int, optional
        In variants of one channel: which one of red, green and blue that is; by default their luminance.
    room_light : (n,) float32, optional
        `RoomEmitter.irradiance` of the same scene loaded in an RGB variant. With it, variants of one channel have the
        room in its place as well.

    Raises
    ------
    InputError
        If no variant is active, or the picture requires dispersion, or a sensor's sensitivities, and the active
        variant is not spectral.
    """
    check_variant(scene.picture.dispersion)
    sensor = sensor_response(scene.sensitivities)
    bodies = scene_bodies(scene, glass_for_mitsuba, channel)
    if for_cache:
        bodies = [refined_for_cache(body) for body in bodies]
    reach = max(float(np.abs(to_world(body.mesh.vertices, body.world_T_mesh)).max()) for body in bodies)
    room = room_surfaces_of(scene, room_light is not None, channel)
    bodies += [surface.body for surface in room]
    shapes = {f"body{i}": mitsuba_mesh(body, channel) for i, body in enumerate(bodies)}
    lights = {f"light{i}": area_light(light, channel) for i, light in enumerate(scene.lights)}
    contents = {"type": "scene", "environment": envmap(scene.environment, channel), **shapes, **lights}
    # Merging shapes (`optimize`) would lose their identities, which ids and media depend on.
    mi_scene = mi.load_dict(contents, optimize=False)
    make_literals_opaque(mi_scene)
    records = {f"body{i}": body.surface for i, body in enumerate(bodies)}
    light = lamp_surface(in_room=bool(room))
    by_id = {_registry_id(shape): records.get(shape.id(), light) for shape in mi_scene.shapes()}
    opaque = _opaque_bodies(mi_scene, bodies) if for_cache else ()
    ids = {shape.id(): _registry_id(shape) for shape in mi_scene.shapes()}
    maps = {ids[f"body{i}"]: body.maps for i, body in enumerate(bodies) if body.maps is not None}
    table = surface_table(by_id, scene.picture.dispersion, maps, channel, scene.picture.refractivity)
    stored = None if room_light is None else in_channel(room_light.reshape(-1, 3), channel)
    bare = None if scene.picture.glass_shadows else _without_glass(mi_scene, by_id)
    emitters = Emitters(mi_scene, lit_emitter(scene, mi_scene, room, stored, channel), bare)
    materials = {f"body{i}": body.material for i, body in enumerate(bodies) if body.material is not None}
    robust, offset = _robust(mi_scene), RAY_OFFSET * reach
    return LoadedScene(scene, mi_scene, robust, table, emitters, offset, opaque, materials, sensor)


def _robust(mi_scene: mi.Scene) -> mi.Scene:
    """Return a scene of the same shapes with Embree's robust intersection; OptiX's is watertight by itself."""
    if mi.variant().startswith("cuda"):
        return mi_scene
    shapes = {shape.id(): shape for shape in mi_scene.shapes()}  # under other names they would get new ids
    return mi.load_dict({"type": "scene", "embree_use_robust_intersections": True, **shapes}, optimize=False)


def _without_glass(mi_scene: mi.Scene, surfaces: Mapping[int, Surface]) -> mi.Scene:
    """Return a scene of the opaque shapes of a scene, lamps among them."""
    shapes = {shape.id(): shape for shape in mi_scene.shapes() if surfaces[_registry_id(shape)].opaque}
    return mi.load_dict({"type": "scene", **shapes}, optimize=False)


def _opaque_bodies(mi_scene: mi.Scene, bodies: list[Body]) -> tuple[OpaqueBody, ...]:
    rows = {shape.id(): _registry_id(shape) for shape in mi_scene.shapes()}
    return tuple(
        _opaque_body(rows[f"body{i}"], body)
        for i, body in enumerate(bodies)
        if body.surface.opaque and body.surface.instance > 0
    )


def _opaque_body(row: int, body: Body) -> OpaqueBody:
    mesh = body.mesh
    positions, faces = to_world(mesh.vertices, body.world_T_mesh), mesh.faces.astype(np.int64)
    if mesh.normals is not None:
        normals = mesh.normals @ body.world_T_mesh[:3, :3].T
    else:
        a, b, c = (positions[faces[:, k]].astype(np.float64) for k in range(3))
        of_face = np.cross(b - a, c - a)
        normals = np.empty((len(positions), 3))
        normals[faces] = (of_face / np.maximum(np.linalg.norm(of_face, axis=1, keepdims=True), 1e-30))[:, None]
    closed = as_trimesh(mesh).is_watertight
    assert body.material is not None  # every opaque body has one
    return OpaqueBody(row, positions, normals, faces, closed, body.material.roughness, body.material.metallic)


def _registry_id(shape: mi.Shape) -> int:
    return int(registry_id(mi.ShapePtr(shape))[0])
