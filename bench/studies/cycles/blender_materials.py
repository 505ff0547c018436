"""Materials, lamps and environment as Blender's shader nodes. Runs under Blender's Python, without our code."""

from __future__ import annotations

import bpy
import numpy as np


def glass(name: str, ior: float, alpha: float) -> bpy.types.Material:
    """Return a dielectric interface.

    Cycles uses `ior` for rays that meet the front (where the normal points to) and its inverse at the back, so the
    ratio of any two media can be given. Its roughness squared is GGX's alpha.
    """
    material, nodes, links = _blank(name)
    bsdf = nodes.new("ShaderNodeBsdfGlass")
    # Keeps the light that facets send at each other, as our walk on the microsurface does; plain GGX loses it.
    bsdf.distribution = "MULTI_GGX"
    bsdf.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    bsdf.inputs["IOR"].default_value = ior
    bsdf.inputs["Roughness"].default_value = alpha**0.5
    links.new(bsdf.outputs["BSDF"], nodes["out"].inputs["Surface"])
    return material


def opaque(name: str, described: dict, texture: np.ndarray) -> bpy.types.Material:
    """Return an ideal diffuser or a principled material with a repeated texture."""
    material, nodes, links = _blank(name)
    colour = _texture(nodes, links, name, texture, described["repeats"])
    if described["kind"] == "diffuse":
        bsdf = nodes.new("ShaderNodeBsdfDiffuse")
        bsdf.inputs["Roughness"].default_value = 0.0
        links.new(colour, bsdf.inputs["Color"])
    else:
        bsdf = nodes.new("ShaderNodeBsdfPrincipled")
        bsdf.distribution = "GGX"
        bsdf.inputs["Roughness"].default_value = described["roughness"]
        bsdf.inputs["Metallic"].default_value = described["metallic"]
        # 1.5 is a reflectance of 0.04 at normal incidence.
        bsdf.inputs["IOR"].default_value = 1.5
        links.new(colour, bsdf.inputs["Base Color"])
    links.new(bsdf.outputs["BSDF"], nodes["out"].inputs["Surface"])
    return material


def lamp(name: str, radiance: tuple[float, float, float]) -> bpy.types.Material:
    """Return a surface that shines from its front with an even radiance and is black otherwise."""
    material, nodes, links = _blank(name)
    # Light is sampled towards the front only; without this the back would take half of the samples.
    material.cycles.emission_sampling = "FRONT"
    geometry, front = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeMath")
    front.operation = "SUBTRACT"
    front.inputs[0].default_value = 1.0
    emission = nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (*radiance, 1.0)
    links.new(geometry.outputs["Backfacing"], front.inputs[1])
    links.new(front.outputs[0], emission.inputs["Strength"])
    links.new(emission.outputs["Emission"], nodes["out"].inputs["Surface"])
    return material


def world(pixels: np.ndarray, rotation: float) -> bpy.types.World:
    """Return the environment of an equirectangular map.

    Parameters
    ----------
    pixels : (h, 2 * h, 3) float32
        Radiance; row 0 at +z, column c at the azimuth 2 pi (c + 1/2) / W, counter-clockwise from +x.
    rotation : float
        Turn of the map about +z [rad].
    """
    # Cycles reads the column at u = 1/2 - azimuth / (2 pi): column j shows our column W/2 - 1 - j.
    width = pixels.shape[1]
    columns = (width // 2 - 1 - np.arange(width)) % width
    made = bpy.data.worlds.new("environment")
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    coordinates, turned = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeMapping")
    turned.vector_type = "POINT"
    turned.inputs["Rotation"].default_value = (0.0, 0.0, -rotation)
    picture = nodes.new("ShaderNodeTexEnvironment")
    # Blender's rows run upwards.
    picture.image = _image("environment", pixels[::-1, columns])
    background, out = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeOutputWorld")
    links.new(coordinates.outputs["Generated"], turned.inputs["Vector"])
    links.new(turned.outputs["Vector"], picture.inputs["Vector"])
    links.new(picture.outputs["Color"], background.inputs["Color"])
    links.new(background.outputs["Background"], out.inputs["Surface"])
    return made


def _blank(name: str) -> tuple:
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    nodes.new("ShaderNodeOutputMaterial").name = "out"
    return material, nodes, material.node_tree.links


def _texture(nodes, links, name: str, texture: np.ndarray, repeats: float):
    coordinates, scaled = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeMapping")
    scaled.inputs["Scale"].default_value = (repeats, repeats, 1.0)
    picture = nodes.new("ShaderNodeTexImage")
    picture.image, picture.interpolation, picture.extension = _image(name, texture), "Linear", "REPEAT"
    links.new(coordinates.outputs["UV"], scaled.inputs["Vector"])
    links.new(scaled.outputs["Vector"], picture.inputs["Vector"])
    return picture.outputs["Color"]


def _image(name: str, pixels: np.ndarray) -> bpy.types.Image:
    """Return a float image of linear values, first row at the bottom."""
    height, width, _ = pixels.shape
    image = bpy.data.images.new(name, width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = pixels
    image.pixels.foreach_set(rgba.ravel())
    image.update()
    return image
