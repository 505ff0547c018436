"""Bodies of a scene: meshes with poses, BSDFs and surface records, and their refinement for the irradiance cache."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...core.mesh import Mesh, some_faces, turned
from ...procedural.description.material import OpaqueMaterial
from ...procedural.description.scene import TABLE_ID, GlassBody, Interface, Prop, Scene
from ...procedural.description.surroundings import Table
from ...procedural.materials.surface_maps import bake_maps, mean_metallic, mean_roughness
from ...procedural.optics.medium import AIR
from ...procedural.patterns.bake import bake_material
from ...procedural.tables.printed_top import printed_top
from .._mitsuba import mi
from .shining_surfaces import surface_emitter
from .spectrum import in_channel
from .surfaces import Surface
from .vertex_colours import coloured

#: Roughness up to which props count as polished [1]: lamps reflected in them are sharp (GGX alpha of 0.16) and noisy.
#: Mostly metallic materials count at any roughness: all their light is reflected. Tables never count: the denoiser
#: cleans reflections in their flat tops.
POLISHED = 0.4
#: Samples of emitter sampling of mostly metallic materials that the eye sees directly [1]: all their light is
#: reflected, by a lobe that meets few of the directions from which a scene is lit. With 1, 4, 8 and 16, the error on a
#: table of brushed steel (seed 204, 160x120) is 53, 43, 35 and 27 sRGB levels before the denoiser and 15.8, 12.7, 11.6
#: and 11.3 after it; tracing a picture takes 0, 2, 3 and 8 % more time.
METAL_CANDIDATES = 8
#: Longest edge of opaque meshes whose vertices are cache points of the irradiance cache [m]: as fine as contact shadows
#: of small objects and as caustics. The table's sides may have longer ones [m]; its top has a grid of its own.
MAX_EDGE, MAX_EDGE_OF_TABLE = 0.0035, 0.05
#: Meshes of more triangles are not refined further [1]: a bound on memory.
MAX_FACES = 40_000
#: Maximum number of passes: each halves the longest edges, so this many reduce an edge of 4 m below 1 mm.
_MAX_PASSES = 12


@dataclass(frozen=True, eq=False)
class Body:
    """A mesh of the scene before it is loaded."""

    mesh: Mesh
    world_T_mesh: np.ndarray  #: (4, 4) float64 [m]
    bsdf: mi.BSDF
    surface: Surface
    maps: np.ndarray | None = None  #: of roughness, metalness and normals (`surface_maps.bake_maps`)
    material: OpaqueMaterial | None = None  #: of an opaque body


def scene_bodies(scene: Scene, glass_for_mitsuba: bool, channel: int | None = None) -> list[Body]:
    """Return the bodies of a scene: the table first, then the objects in their order.

    The BSDF of interfaces is the table's unless `glass_for_mitsuba`: our integrators do not use it. With a `channel`
    colours are one of red, green and blue (`spectrum.in_channel`).
    """
    body = _table_body(scene.table, channel)
    bodies, glass = [body], None if glass_for_mitsuba else body.bsdf
    for index, item in enumerate(scene.objects):
        if isinstance(item, Prop):
            bodies += _prop_bodies(item, index, channel)
        else:
            bodies += _glass_bodies(item, index, glass, channel)
    return bodies


def _table_body(table: Table, channel: int | None) -> Body:
    """Return the table; prints on it are a part of its surface."""
    material = table.material
    surface = Surface(TABLE_ID, -1, True, AIR, AIR, 0.0, candidates=_candidates(material))
    if table.prints:
        top = printed_top(table)
        mesh, pixels, maps = top.mesh, top.colour, top.maps
    else:
        mesh, (pixels, maps) = with_repeats(table.mesh, material), bake_material(material)
    bsdf = mi.load_dict(opaque_bsdf(material, in_channel(pixels, channel), maps))
    return Body(mesh, np.eye(4), bsdf, surface, maps, material)


def _glass_bodies(body: GlassBody, index: int, glass: mi.BSDF | None, channel: int | None) -> list[Body]:
    """Return one body for each interface, with the BSDF `glass` or, if that is None, a dielectric one of its own."""
    bodies = []
    for part in body.interfaces:
        mesh, front, back = part.mesh, part.front, part.back
        if part.opaque is None:
            surface, bsdf = (
                Surface(body.id, index, False, front, back, part.roughness, part.part),
                glass or _glass_bsdf(part),
            )
        else:
            # A turbid liquid: its surface shows from the other medium, which is its front here.
            if part.seen_from_back:
                mesh, front, back = turned(mesh), back, front
            polished, count = _is_polished(part.opaque), _candidates(part.opaque)
            surface = Surface(body.id, index, True, front, back, 0.0, part.part, polished, count)
            pixels = in_channel(bake_material(part.opaque)[0], channel)
            bsdf = mi.load_dict(opaque_bsdf(part.opaque, pixels))
        bodies.append(Body(mesh, body.world_T_object, bsdf, surface, material=part.opaque))
    return bodies


def _glass_bsdf(interface: Interface) -> mi.BSDF:
    bsdf = {"type": "roughdielectric", "alpha": interface.roughness, "distribution": "ggx"}
    bsdf = bsdf if interface.roughness > 0 else {"type": "dielectric"}
    return mi.load_dict(bsdf | {"int_ior": interface.back.eta, "ext_ior": interface.front.eta})


def _prop_bodies(prop: Prop, index: int, channel: int | None) -> list[Body]:
    """Return one body for each part of a prop."""
    bodies, start = [], 0
    for number, piece in enumerate(prop.pieces):
        material, end = piece.material, start + piece.faces
        mesh = some_faces(prop.mesh, slice(start, end), f"{prop.mesh.name}-{number}") if prop.parts else prop.mesh
        front = piece.surrounding or AIR
        surface = Surface(
            prop.id,
            index,
            True,
            front,
            AIR,
            0.0,
            polished=_is_polished(material),
            candidates=_candidates(material),
            piece=number,
        )
        if material.base_colour.kind == "vertices":
            mesh, pixels = coloured(mesh)
            maps = bake_maps(material) if material.is_mapped else None
        else:
            pixels, maps = bake_material(material)
        bsdf = mi.load_dict(opaque_bsdf(material, in_channel(pixels, channel), maps))
        bodies.append(Body(with_repeats(mesh, material), prop.world_T_object, bsdf, surface, maps, material))
        start = end
    return bodies


def _is_polished(material: OpaqueMaterial) -> bool:
    """Return whether pixels that show a prop of the material need more samples."""
    return mean_roughness(material) <= POLISHED or _is_metal(material)


def _is_metal(material: OpaqueMaterial) -> bool:
    return mean_metallic(material) >= 0.5


def _candidates(material: OpaqueMaterial) -> int:
    return METAL_CANDIDATES if _is_metal(material) else 1


def opaque_bsdf(material: OpaqueMaterial, pixels: np.ndarray | None = None, maps: np.ndarray | None = None) -> dict:
    """Return the Mitsuba dictionary of a principled BSDF, one-sided; the ray loop flips the frame to the ray's side.

    Every material has a bitmap texture, even a plain colour: all opaque surfaces then share one kernel, and a new scene
    with other values compiles nothing. For the same reason the texture repeats are not in the bitmap's transform: see
    `with_repeats`. The colours are the material's texture, or `pixels` as `bake` returns them. Materials with `maps`
    have a second kernel; the normals in them tilt the frame before the BSDF is asked (`surface_maps`).
    """
    pixels = bake_material(material)[0] if pixels is None else pixels
    # Reflectance, for spectral variants too; a float bitmap counts as linear.
    colour = _bitmap(pixels, raw=False)
    if maps is not None:
        roughness, metallic = (_bitmap(maps[..., k : k + 1], raw=True) for k in (2, 3))
        return {"type": "principled", "base_color": colour, "roughness": roughness, "metallic": metallic}
    return {
        "type": "principled",
        "base_color": colour,
        "roughness": material.roughness,
        # As a texture: Mitsuba compiles another BSDF for the number 0 than for others.
        "metallic": {"type": "uniform", "value": material.metallic},
    }


def _bitmap(pixels: np.ndarray, raw: bool) -> dict:
    bitmap = mi.Bitmap(np.array(pixels, np.float32, order="C"))  # a copy: no read-only arrays
    return {"type": "bitmap", "bitmap": bitmap, "raw": raw, "filter_type": "bilinear", "wrap_mode": "repeat"}


def with_repeats(mesh: Mesh, material: OpaqueMaterial) -> Mesh:
    """Return the mesh with texture coordinates scaled by the material's number of repeats.

    Mitsuba's own transform of texture coordinates would be compiled into the kernel as a literal.
    """
    across, up = material.repeats, material.repeats if material.repeats_v is None else material.repeats_v
    if mesh.uv is None or across == up == 1.0:
        return mesh
    return replace(mesh, uv=mesh.uv * (across if across == up else np.array([across, up], mesh.uv.dtype)))


def mitsuba_mesh(body: Body, channel: int | None = None) -> mi.Mesh:
    """Return the mesh in the world frame. Equal positions in two meshes of one object stay equal to the last bit."""
    mesh, world_T_mesh = body.mesh, body.world_T_mesh
    properties = mi.Properties()
    properties["mesh_bsdf"] = body.bsdf
    properties["face_normals"] = mesh.normals is None
    if body.material is not None and body.material.emission is not None:
        properties["mesh_emitter"] = surface_emitter(body.material.emission, channel)
    shape = mi.Mesh(
        mesh.name,
        len(mesh.vertices),
        len(mesh.faces),
        props=properties,
        has_vertex_normals=mesh.normals is not None,
        has_vertex_texcoords=mesh.uv is not None,
    )
    parameters = mi.traverse(shape)
    # Flat arrays: converting Dr.Jit's vectors would compile a kernel for every mesh size.
    parameters["vertex_positions"] = mi.Float(to_world(mesh.vertices, world_T_mesh).ravel())
    parameters["faces"] = mi.UInt32(mesh.faces.astype(np.uint32).ravel())
    if mesh.normals is not None:
        rotated = (mesh.normals @ world_T_mesh[:3, :3].T).astype(np.float32)
        parameters["vertex_normals"] = mi.Float(rotated.ravel())
    if mesh.uv is not None:
        parameters["vertex_texcoords"] = mi.Float(mesh.uv.astype(np.float32).ravel())
    parameters.update()
    return shape


def to_world(points: np.ndarray, world_T_mesh: np.ndarray) -> np.ndarray:
    """Return mesh points (n, 3) in the world frame, float32 [m]."""
    # Element by element in float64: the same point gives the same bits in every mesh that contains it (a matrix product
    # may round differently depending on a row's position in the array).
    x, y, z = points.astype(np.float64).T
    rows = [a * x + b * y + c * z + t for a, b, c, t in world_T_mesh[:3]]
    return np.stack(rows, axis=1).astype(np.float32)


def refined_for_cache(body: Body) -> Body:
    """Return an opaque body with short edges; faces of a flat-shaded mesh get separate vertices first."""
    if not body.surface.opaque:
        return body
    max_edge = MAX_EDGE_OF_TABLE if body.surface.instance == TABLE_ID else MAX_EDGE
    mesh = body.mesh if body.mesh.normals is not None else unwelded(body.mesh)
    return replace(body, mesh=refined(mesh, max_edge, MAX_FACES))


def refined(mesh: Mesh, max_edge: float, max_faces: int) -> Mesh:
    """Return the mesh with edges of at most `max_edge`, or as fine as `max_faces` allows.

    A face is split at the midpoints of its long edges, and its neighbour at the same points, so no cracks appear.
    Normals at new vertices are means of their neighbours, not normalised: interpolated normals stay the same.

    Parameters
    ----------
    mesh : Mesh
        The mesh, in metres.
    max_edge : float
        Maximum edge length [m].
    max_faces : int
        Number of faces above which no further pass is made.
    """
    columns = [mesh.vertices, *(x for x in (mesh.normals, mesh.uv) if x is not None)]
    values, faces = np.concatenate(columns, axis=1).astype(np.float64), mesh.faces.astype(np.int64)
    for _ in range(_MAX_PASSES):
        if len(faces) > max_faces:
            break
        values, faces, changed = _split_long_edges(values, faces, max_edge)
        if not changed:
            break
    normals = values[:, 3:6] if mesh.normals is not None else None
    uv = values[:, -2:] if mesh.uv is not None else None
    return Mesh(mesh.name, values[:, :3], faces, normals, uv)


def unwelded(mesh: Mesh) -> Mesh:
    """Return the mesh with three separate vertices for every face."""
    index = mesh.faces.ravel()
    normals, uv = (None if x is None else x[index] for x in (mesh.normals, mesh.uv))
    return Mesh(mesh.name, mesh.vertices[index], np.arange(len(index)).reshape(-1, 3), normals, uv)


def _split_long_edges(values: np.ndarray, faces: np.ndarray, max_edge: float) -> tuple[np.ndarray, np.ndarray, bool]:
    """Split every long edge once; return vertices, faces and whether any edge was split."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)  # edge k runs from corner k
    lengths = np.linalg.norm(values[ends[:, 0], :3] - values[ends[:, 1], :3], axis=1)
    # Edges by position, not by vertex: on both sides of a seam the same edge is split at the same point.
    cut = lengths > max_edge
    if not cut.any():
        return values, faces, False
    edges, which = np.unique(np.sort(ends[cut], axis=1), axis=0, return_inverse=True)
    middles = 0.5 * (values[edges[:, 0]] + values[edges[:, 1]])
    middle = np.full(len(ends), -1)
    middle[cut] = len(values) + which.reshape(-1)
    return np.concatenate([values, middles]), _split_faces(faces, middle.reshape(-1, 3)), True


def _split_faces(faces: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Return the faces split at the midpoints of their edges (-1: not split); edge k runs from corner k to k + 1."""
    cut = middle >= 0
    number, pieces = cut.sum(1), [faces[~cut.any(1)]]
    # Corners are rotated so that the first edge is split, and with two split edges so that the third is not.
    turn = np.where(number == 2, (np.argmin(cut, 1) + 1) % 3, np.argmax(cut, 1))
    order = (turn[:, None] + np.arange(3)) % 3
    (a, b, c), (ab, bc, ca) = (np.take_along_axis(x, order, 1).T for x in (faces, middle))
    one, two, three = (number == k for k in (1, 2, 3))
    pieces += [np.stack(corners, 1)[one] for corners in ((a, ab, c), (ab, b, c))]
    pieces += [np.stack(corners, 1)[two] for corners in ((ab, b, bc), (a, ab, bc), (a, bc, c))]
    pieces += [np.stack(corners, 1)[three] for corners in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    return np.concatenate(pieces)
