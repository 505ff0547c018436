"""Description -> loaded Mitsuba scene, with the table of its surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.mesh import Mesh, as_trimesh
from ...procedural.description.material import OpaqueMaterial
from ...procedural.description.scene import TABLE_ID, GlassBody, Interface, Prop, Scene
from ...procedural.optics.medium import AIR
from .._mitsuba import mi
from .lighting import area_light, envmap, keep_numbers_out_of_kernels
from .opaque import opaque_bsdf, repeated
from .refinement import refined, unwelded
from .spectrum import check_variant
from .surfaces import Surface, SurfaceTable, registry_id, surface_table

#: Rays start this share of the scene's largest coordinate off the surface that they leave, along its geometric normal.
#: A float32 coordinate has 24 bits; barycentric interpolation and the intersection lose up to three, and one is margin.
#: (Mitsuba's own offset of 1e-4 (1 + |p|) is 0.1 mm here, a tenth of a glass wall.)
RAY_OFFSET = 2.0**-20
#: Roughness up to which props count as polished: lamps in them are sharp (GGX alpha of 0.16) and noisy. What is mostly
#: metal does at any roughness: its light is mirrored. Tables never do: the denoiser cleans what their flat tops mirror.
POLISHED = 0.4


#: Longest edge of opaque meshes at whose vertices light is stored [m], and the most triangles that are still cut.
#: The table's top has a grid of its own.
LONGEST_EDGE, LONGEST_OF_TABLE, MOST_FACES = 0.005, 0.05, 40_000


@dataclass(frozen=True, eq=False)
class OpaqueBody:
    """An opaque mesh as it was loaded, in the world frame."""

    row: int  #: registry id of its shape
    positions: np.ndarray  #: (n, 3) float32 [m]
    normals: np.ndarray  #: (n, 3) float32, of the shading, towards the front; not of unit length
    faces: np.ndarray  #: (m, 3) int64
    closed: bool  #: whether its back can never be seen
    roughness: float  #: of the principled material
    metallic: float


@dataclass(frozen=True, eq=False)
class LoadedScene:
    """A scene ready for rays."""

    description: Scene
    mi_scene: mi.Scene
    surfaces: SurfaceTable
    offset: float  #: distance that rays start off a surface [m]
    opaque_bodies: tuple[OpaqueBody, ...] = ()  #: filled in where light is to be stored on them


def load(scene: Scene, glass_for_mitsuba: bool = False, cut: bool = False) -> LoadedScene:
    """Load a scene into Mitsuba (the variant must be active: `render.backend.variant.activate`).

    Parameters
    ----------
    scene : Scene
        The description.
    glass_for_mitsuba : bool
        Give glass the BSDFs that Mitsuba's own integrators need to draw it. Ours refracts by the surface table, and
        every such BSDF would be compiled into its kernel, index and all, for nothing.
    cut : bool
        Cut opaque meshes fine enough to store light at their vertices, and list them in `LoadedScene.opaque_bodies`.
    """
    check_variant(scene.picture.dispersion)
    table = mi.load_dict(opaque_bsdf(scene.table.material))
    bodies = [*_table_bodies(scene, table), *_object_bodies(scene, None if glass_for_mitsuba else table)]
    if cut:
        bodies = [(_cut(mesh, surface), *rest, surface) for mesh, *rest, surface in bodies]
    shapes = {f"body{i}": _mi_mesh(mesh, world_T, bsdf) for i, (mesh, world_T, bsdf, _) in enumerate(bodies)}
    lights = {f"light{i}": area_light(light) for i, light in enumerate(scene.lights)}
    contents = {"type": "scene", "environment": envmap(scene.environment), **shapes, **lights}
    # Merging shapes would lose the identity that ids and media hang on.
    mi_scene = mi.load_dict(contents, optimize=False)
    keep_numbers_out_of_kernels(mi_scene)
    records = {f"body{i}": surface for i, (*_, surface) in enumerate(bodies)}
    light = Surface(0, -1, True, AIR, AIR, 0.0)
    by_id = {_registry_id(shape): records.get(shape.id(), light) for shape in mi_scene.shapes()}
    reach = max(float(np.abs(_in_world(mesh.vertices, world_T)).max()) for mesh, world_T, *_ in bodies)
    opaque = ()
    if cut:
        rows = {shape.id(): _registry_id(shape) for shape in mi_scene.shapes()}
        opaque = tuple(
            _opaque_body(scene, rows[f"body{i}"], mesh, world_T, surface)
            for i, (mesh, world_T, _, surface) in enumerate(bodies)
            if surface.opaque
        )
    return LoadedScene(scene, mi_scene, surface_table(by_id, scene.picture.dispersion), RAY_OFFSET * reach, opaque)


def _cut(mesh: Mesh, surface: Surface) -> Mesh:
    """Return an opaque mesh with short edges; what is flat shaded gets vertices of its own for every face first."""
    if not surface.opaque:
        return mesh
    longest = LONGEST_OF_TABLE if surface.instance == TABLE_ID else LONGEST_EDGE
    return refined(mesh if mesh.normals is not None else unwelded(mesh), longest, MOST_FACES)


def _opaque_body(scene: Scene, row: int, mesh: Mesh, world_T_mesh: np.ndarray, surface: Surface) -> OpaqueBody:
    positions, faces = _in_world(mesh.vertices, world_T_mesh), mesh.faces.astype(np.int64)
    if mesh.normals is not None:
        normals = mesh.normals @ world_T_mesh[:3, :3].T
    else:
        a, b, c = (positions[faces[:, k]].astype(np.float64) for k in range(3))
        normals = np.empty((len(positions), 3))
        normals[faces] = np.cross(b - a, c - a)[:, None]
    closed = as_trimesh(mesh).is_watertight
    materials = {TABLE_ID: scene.table.material, **{prop.id: prop.material for prop in scene.props}}
    material = materials[surface.instance]
    return OpaqueBody(row, positions, normals, faces, closed, material.roughness, material.metallic)


def _table_bodies(scene: Scene, bsdf: mi.BSDF) -> list[tuple]:
    surface = Surface(TABLE_ID, -1, True, AIR, AIR, 0.0)
    return [(repeated(scene.table.mesh, scene.table.material), np.eye(4), bsdf, surface)]


def _object_bodies(scene: Scene, glass: mi.BSDF | None) -> list[tuple]:
    bodies = []
    for index, item in enumerate(scene.objects):
        bodies += [_prop_body(item, index)] if isinstance(item, Prop) else _glass_bodies(item, index, glass)
    return bodies


def _polished(material: OpaqueMaterial) -> bool:
    """Return whether pixels that show a prop of the material need more samples."""
    return material.roughness <= POLISHED or material.metallic >= 0.5


def _glass_bodies(body: GlassBody, index: int, glass: mi.BSDF | None) -> list[tuple]:
    """Return the interfaces; `glass` stands in for their BSDFs, which are made where there is none."""
    bodies = []
    for interface in body.interfaces:
        media = interface.front, interface.back
        surface = Surface(body.id, index, False, *media, interface.roughness, interface.part)
        bodies.append((interface.mesh, body.world_T_object, glass or _glass_bsdf(interface), surface))
    return bodies


def _glass_bsdf(interface: Interface) -> mi.BSDF:
    bsdf = {"type": "roughdielectric", "alpha": interface.roughness, "distribution": "ggx"}
    bsdf = bsdf if interface.roughness > 0 else {"type": "dielectric"}
    return mi.load_dict(bsdf | {"int_ior": interface.back.eta, "ext_ior": interface.front.eta})


def _prop_body(prop: Prop, index: int) -> tuple:
    surface = Surface(prop.id, index, True, AIR, AIR, 0.0, polished=_polished(prop.material))
    bsdf = mi.load_dict(opaque_bsdf(prop.material))
    return repeated(prop.mesh, prop.material), prop.world_T_object, bsdf, surface


def _mi_mesh(mesh: Mesh, world_T_mesh: np.ndarray, bsdf: mi.BSDF) -> mi.Mesh:
    """Return the mesh in the world frame. Equal positions in two meshes of one object stay equal to the last bit."""
    properties = mi.Properties()
    properties["mesh_bsdf"] = bsdf
    properties["face_normals"] = mesh.normals is None
    shape = mi.Mesh(
        mesh.name,
        len(mesh.vertices),
        len(mesh.faces),
        props=properties,
        has_vertex_normals=mesh.normals is not None,
        has_vertex_texcoords=mesh.uv is not None,
    )
    parameters = mi.traverse(shape)
    # Flat arrays as they lie: Dr.Jit's vectors would be turned by a kernel that is compiled anew for every mesh size.
    parameters["vertex_positions"] = mi.Float(_in_world(mesh.vertices, world_T_mesh).ravel())
    parameters["faces"] = mi.UInt32(mesh.faces.astype(np.uint32).ravel())
    if mesh.normals is not None:
        turned = (mesh.normals @ world_T_mesh[:3, :3].T).astype(np.float32)
        parameters["vertex_normals"] = mi.Float(turned.ravel())
    if mesh.uv is not None:
        parameters["vertex_texcoords"] = mi.Float(mesh.uv.astype(np.float32).ravel())
    parameters.update()
    return shape


def _in_world(points: np.ndarray, world_T_mesh: np.ndarray) -> np.ndarray:
    # Element by element in float64: the same point gives the same bits whichever mesh it stands in (a matrix product
    # may round differently by a row's place in the array).
    x, y, z = points.astype(np.float64).T
    rows = [a * x + b * y + c * z + t for a, b, c, t in world_T_mesh[:3]]
    return np.stack(rows, axis=1).astype(np.float32)


def _registry_id(shape: mi.Shape) -> int:
    return int(registry_id(mi.ShapePtr(shape))[0])
