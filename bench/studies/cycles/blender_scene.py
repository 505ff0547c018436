"""From the exchange folder to a Blender scene ready for Cycles. Runs under Blender's Python, without our code."""

from __future__ import annotations

import json
from pathlib import Path

import blender_materials
import bpy
import numpy as np
from mathutils import Matrix

#: Width that Blender's focal length is given for [mm]; any will do.
_SENSOR = 36.0


def build(folder: Path, threads: int) -> None:
    """Replace the open file by the scene of the folder.

    Parameters
    ----------
    folder : Path
        What `exchange.write_exchange` wrote.
    threads : int
        Threads to render with.
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    described = json.loads((folder / "scene.json").read_text("utf-8"))
    with np.load(folder / "arrays.npz", allow_pickle=False) as file:
        arrays = dict(file)
    for body in described["bodies"]:
        _add_body(body, arrays)
    for number, light in enumerate(described["lights"]):
        _add_light(f"light{number}", light)
    environment = described["environment"]
    bpy.context.scene.world = blender_materials.world(arrays[environment["pixels"]], environment["rotation"])
    _add_camera(described["camera"])
    _set_up(bpy.context.scene, described["max_depth"], threads)


def _add_body(body: dict, arrays: dict[str, np.ndarray]) -> None:
    described, name = body["material"], body["name"]
    if described["kind"] == "glass":
        material = blender_materials.glass(name, described["ior"], described["alpha"])
    else:
        material = blender_materials.opaque(name, described, arrays[described["texture"]])
    normals, uv = (arrays[body[key]] if key in body else None for key in ("normals", "uv"))
    _add_object(_mesh(name, arrays[body["vertices"]], arrays[body["faces"]], normals, uv), material)


def _mesh(
    name: str, vertices: np.ndarray, faces: np.ndarray, normals: np.ndarray | None, uv: np.ndarray | None
) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(vertices, np.float32).ravel())
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(faces, np.int32).ravel())
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 3, dtype=np.int32))
    if uv is not None:
        layer = mesh.uv_layers.new(name="uv")
        layer.uv.foreach_set("vector", np.ascontiguousarray(uv[faces.ravel()], np.float32).ravel())
    mesh.update(calc_edges=True)
    mesh.polygons.foreach_set("use_smooth", np.full(len(faces), normals is not None))
    if normals is not None:
        # Free normals (since 4.5) are kept as they are; those of `normals_split_custom_set` are rounded to 16 bits.
        kept = mesh.attributes.new("custom_normal", "FLOAT_VECTOR", "POINT")
        kept.data.foreach_set("vector", np.ascontiguousarray(normals, np.float32).ravel())
    if len(mesh.polygons) != len(faces):
        raise RuntimeError(f"mesh {name}: Blender keeps {len(mesh.polygons)} of {len(faces)} triangles")
    return mesh


def _add_light(name: str, light: dict) -> None:
    pose, (x, y) = np.array(light["world_T_light"]), (0.5 * side for side in light["size"])
    corners = np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]]) @ pose[:3, :3].T + pose[:3, 3]
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    _add_object(_mesh(name, corners, faces, None, None), blender_materials.lamp(name, light["radiance"]))


def _add_object(mesh: bpy.types.Mesh, material: bpy.types.Material) -> None:
    mesh.materials.append(material)
    thing = bpy.data.objects.new(mesh.name, mesh)
    # Both soften shadows near the terminator of coarse meshes: they are not physics.
    thing.cycles.shadow_terminator_geometry_offset = 0.0
    thing.cycles.shadow_terminator_offset = 0.0
    bpy.context.scene.collection.objects.link(thing)


def _add_camera(camera: dict) -> None:
    """Add the pinhole. Our pixel centres are at whole coordinates, so the picture's middle is Blender's as well."""
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit, lens.sensor_width = "HORIZONTAL", _SENSOR
    lens.lens = camera["focal"] * _SENSOR / camera["width"]
    lens.clip_start, lens.clip_end = 1e-3, 1e3
    thing = bpy.data.objects.new("camera", lens)
    # Blender's cameras look along -z with y up; ours along +z with y down.
    thing.matrix_world = Matrix((np.array(camera["world_T_camera"]) @ np.diag([1.0, -1.0, -1.0, 1.0])).tolist())
    bpy.context.scene.collection.objects.link(thing)
    scene = bpy.context.scene
    scene.camera = thing
    scene.render.resolution_x, scene.render.resolution_y = camera["width"], camera["height"]
    scene.render.resolution_percentage = 100


def _set_up(scene: bpy.types.Scene, max_depth: int, threads: int) -> None:
    """Set what decides the converged picture, and the denoiser at its best."""
    scene.render.engine = "CYCLES"
    scene.render.threads_mode, scene.render.threads = "FIXED", threads
    scene.render.use_persistent_data = True  # the tree of triangles is built once
    scene.render.use_compositing = scene.render.use_sequencer = False
    scene.render.film_transparent = False
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.exr_codec = "ZIP"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = False
    for kind in ("max", "diffuse", "glossy", "transmission", "transparent_max"):
        setattr(cycles, f"{kind}_bounces", max_depth)
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.blur_glossy = cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.use_fast_gi = False
    cycles.pixel_filter_type = "BOX"
    cycles.film_exposure = 1.0
    cycles.denoiser = "OPENIMAGEDENOISE"
    cycles.denoising_input_passes = "RGB_ALBEDO_NORMAL"
    cycles.denoising_prefilter = "ACCURATE"
    cycles.denoising_quality = "HIGH"
    # Stores the picture before the denoiser beside the denoised one.
    scene.view_layers[0].cycles.denoising_store_passes = True
