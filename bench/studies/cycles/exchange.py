"""Our description written out for another renderer: world-frame triangles, baked textures, numbers.

The folder holds ``arrays.npz`` and ``scene.json``; the JSON names arrays by their key. Nothing in it needs our code to
be read.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from glassware.core.mesh import Mesh
from glassware.procedural.description.camera import Camera
from glassware.procedural.description.material import OpaqueMaterial
from glassware.procedural.description.scene import GlassBody, Prop, Scene
from glassware.procedural.patterns.bake import bake_material
from glassware.procedural.surroundings.environments import bake_environment


def write_exchange(scene: Scene, folder: Path, lambertian: bool = False) -> None:
    """Write a scene for `blender_scene.build`.

    Parameters
    ----------
    scene : Scene
        Its media must be clear: nothing is written of absorption. The left eye of the first camera is used.
    folder : Path
        Where to; made where it is missing.
    lambertian : bool
        Write opaque materials as ideal diffusers of their base colour.

    Raises
    ------
    ValueError
        Where a medium absorbs.
    """
    folder.mkdir(parents=True, exist_ok=True)
    arrays: dict[str, np.ndarray] = {}
    bodies = [_opaque_body(scene.table.mesh, np.eye(4), scene.table.material, lambertian, arrays)]
    for item in scene.objects:
        if isinstance(item, Prop):
            bodies.append(_opaque_body(item.mesh, item.world_T_object, item.material, lambertian, arrays))
        else:
            bodies += _vessel_bodies(item, arrays)
    arrays["environment"] = bake_environment(scene.environment) * np.float32(scene.environment.strength)
    content = {
        "bodies": bodies,
        "environment": {"pixels": "environment", "rotation": scene.environment.rotation},
        "lights": [_light(light.world_T_light, light.size, light.radiance) for light in scene.lights],
        "camera": _camera(scene.cameras[0]),
        "max_depth": scene.picture.max_depth,
    }
    np.savez(folder / "arrays.npz", allow_pickle=False, **arrays)
    (folder / "scene.json").write_text(json.dumps(content, indent=1, sort_keys=True), "utf-8")


def _vessel_bodies(vessel: GlassBody, arrays: dict[str, np.ndarray]) -> list[dict]:
    bodies = []
    for interface in vessel.interfaces:
        for medium in (interface.front, interface.back):
            if any(medium.sigma_a):
                raise ValueError(f"medium {medium.name} of {vessel.name}: expected a clear one, it absorbs")
        material = {
            "kind": "glass",
            # The normals point into `front`: a ray that comes from there meets this ratio.
            "ior": interface.back.eta / interface.front.eta,
            "alpha": interface.roughness,
        }
        bodies.append({**_mesh(interface.mesh, vessel.world_T_object, arrays), "material": material})
    return bodies


def _opaque_body(
    mesh: Mesh, world_T_mesh: np.ndarray, material: OpaqueMaterial, lambertian: bool, arrays: dict[str, np.ndarray]
) -> dict:
    if material.repeats_v is not None:
        raise ValueError(f"{material.name}: expected a square texture, got one of another shape")
    texture = f"{mesh.name}.texture"
    arrays[texture] = bake_material(material)[0]
    written = {
        "kind": "diffuse" if lambertian else "principled",
        "texture": texture,
        "repeats": material.repeats,
        "roughness": material.roughness,
        "metallic": material.metallic,
    }
    return {**_mesh(mesh, world_T_mesh, arrays), "material": written}


def _mesh(mesh: Mesh, world_T_mesh: np.ndarray, arrays: dict[str, np.ndarray]) -> dict:
    turn, shift = world_T_mesh[:3, :3], world_T_mesh[:3, 3]
    parts = {"vertices": (mesh.vertices.astype(np.float64) @ turn.T + shift).astype(np.float32), "faces": mesh.faces}
    if mesh.normals is not None:
        parts["normals"] = (mesh.normals @ turn.T).astype(np.float32)
    if mesh.uv is not None:
        parts["uv"] = mesh.uv
    for name, array in parts.items():
        arrays[f"{mesh.name}.{name}"] = array
    return {"name": mesh.name, **{name: f"{mesh.name}.{name}" for name in parts}}


def _light(world_T_light: np.ndarray, size: tuple[float, float], radiance: tuple[float, ...]) -> dict:
    return {"world_T_light": world_T_light.tolist(), "size": size, "radiance": radiance}


def _camera(camera: Camera) -> dict:
    middle = ((camera.width - 1) / 2, (camera.height - 1) / 2)
    if camera.centre != middle:
        raise ValueError(f"camera: expected the principal point {middle}, got {camera.centre}")
    if camera.fy != camera.fx:
        raise ValueError(f"camera: expected equal focal lengths, got {camera.fx} and {camera.fy}")
    return {
        "width": camera.width,
        "height": camera.height,
        "focal": camera.focal,
        "world_T_camera": camera.world_T_camera.tolist(),
    }
