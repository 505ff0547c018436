"""All comparisons of one eye's geometry with the meshes of its scene, for a view that is in memory."""

from __future__ import annotations

from ...procedural.description.camera import Camera
from ...procedural.description.scene import Scene
from ...render.frame import Eye, Geometry
from . import surfaces
from .fault import Fault
from .pinhole import pinhole_of
from .triangles import triangles_of
from .truth import truth_of


def geometry_faults(scene: Scene, camera: Camera, geometry: Geometry, eye: Eye = "left") -> list[Fault]:
    """Return what is wrong with depth, ids, background, normals and silhouettes of one eye.

    Parameters
    ----------
    scene : Scene
        The description.
    camera : Camera
        One of its cameras.
    geometry : Geometry
        What is to be proved.
    eye : {"left", "right"}
        The eye that it belongs to.
    """
    triangles, pinhole = triangles_of(scene), pinhole_of(camera, eye)
    truth = truth_of(triangles, pinhole)
    return [
        *surfaces.depth_faults(truth, geometry, eye),
        *surfaces.id_faults(truth, triangles, geometry, eye),
        *surfaces.background_faults(truth, triangles, geometry, eye),
        *surfaces.normal_faults(truth, triangles, geometry, eye),
        *surfaces.mask_faults(truth, triangles, scene, geometry, eye),
        *surfaces.id_contradictions(scene, geometry, eye),
        *surfaces.background_contradictions(scene, geometry, eye),
        *surfaces.transmittance_faults(scene, geometry, eye),
        *surfaces.normal_contradictions(pinhole, geometry, eye),
        *surfaces.silhouette_contradictions(scene, geometry, eye),
    ]
