"""The scenes that pictures are measured on, as our own descriptions.

All media are clear, so that a renderer without absorption draws the same physics.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from glassware.core.assets import asset
from glassware.core.errors import InputError
from glassware.core.mesh import Mesh
from glassware.procedural.description.scene import GlassBody, Interface, Prop, Scene
from glassware.procedural.description.surroundings import PictureEnvironment
from glassware.procedural.optics.medium import Medium
from glassware.procedural.scene.draw import draw_scene
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.surroundings.camera_settings import CameraSettings
from glassware.procedural.surroundings.environments import bake_environment
from glassware.procedural.surroundings.metering import exposure, irradiance
from glassware.procedural.surroundings.settings import EnvironmentSettings, LightSettings
from glassware.procedural.vessels.settings import VesselSettings

#: Real environment maps, beside the checkout and never committed.
HDRI_DIR = Path(__file__).resolve().parents[2] / "shared" / "assets" / "hdri"
#: Seed of all.
SEED = 20230213


@dataclass(frozen=True)
class _Recipe:
    """What sets one scene apart."""

    scene_id: int
    vessels: int
    props: int
    fill: float  #: probability that a vessel holds a liquid
    rough: float  #: probability that the glass is rough
    lights: int  #: most area lights
    grid_index: int  #: which view of the 57-view grid
    hdri: str | None = None
    shiny: bool = False  #: whether its props are polished, every other one of metal


_RECIPES = {
    "empty": _Recipe(1, vessels=4, props=0, fill=0.0, rough=0.0, lights=3, grid_index=32),
    "filled": _Recipe(2, vessels=4, props=0, fill=1.0, rough=0.0, lights=3, grid_index=30),
    "rough": _Recipe(3, vessels=3, props=1, fill=0.5, rough=1.0, lights=3, grid_index=35),
    "clutter": _Recipe(4, vessels=6, props=6, fill=0.6, rough=0.1, lights=3, grid_index=20),
    "hdri": _Recipe(5, vessels=4, props=1, fill=0.6, rough=0.0, lights=0, grid_index=38, hdri="lobby.exr"),
    "shiny": _Recipe(6, vessels=3, props=8, fill=0.6, rough=0.0, lights=3, grid_index=25, shiny=True),
}
#: The five that other renderers draw too; the sixth is for stored light, which has to mirror what it stored.
NAMES = ("empty", "filled", "rough", "clutter", "hdri")
ALL_NAMES = tuple(_RECIPES)
#: Roughness of polished props, in turn: GGX alpha from 0.01 to 0.09.
_POLISHED = (0.1, 0.2, 0.3)


def bench_scene(name: str, width: int, height: int) -> Scene:
    """Return one of the scenes with one camera.

    Parameters
    ----------
    name : str
        One of `ALL_NAMES`.
    width, height : int
        Size of the picture [px].

    Raises
    ------
    InputError
        For another name, or where the environment map of ``"hdri"`` is not there.
    """
    if name not in _RECIPES:
        raise InputError("scene", "one of " + ", ".join(ALL_NAMES), name)
    recipe = _RECIPES[name]
    settings = SceneSettings(
        vessel_count=(recipe.vessels, recipe.vessels),
        prop_count=(recipe.props, recipe.props),
        vessels=VesselSettings(fill_probability=recipe.fill, rough_probability=recipe.rough),
        environment=EnvironmentSettings(room_share=1.0, shipped_share=0.0),
        lights=LightSettings(max_count=recipe.lights),
        cameras=CameraSettings(views=57, width=width, height=height, slack=(1.0, 1.0)),
    )
    scene = draw_scene(settings, SEED, recipe.scene_id)
    camera = next(view for view in scene.cameras if view.grid_index == recipe.grid_index)
    vessels = tuple(_clear_vessel(vessel) for vessel in scene.vessels)
    props = tuple(_polished(prop, i) for i, prop in enumerate(scene.props)) if recipe.shiny else scene.props
    scene = scene.model_copy(update={"cameras": (camera,), "vessels": vessels, "props": props})
    return scene if recipe.hdri is None else _lit_by(scene, HDRI_DIR / recipe.hdri)


def digest(scene: Scene) -> str:
    """Return a digest of all that decides the converged picture: not the number of samples, nor who traces them."""
    text = f"{scene.picture.max_depth} {scene.model_dump_json(exclude={'seed', 'scene_id', 'picture'})}"
    whole = hashlib.sha256(text.encode())
    meshes = [scene.table.mesh, *(prop.mesh for prop in scene.props)]
    meshes += [interface.mesh for vessel in scene.vessels for interface in vessel.interfaces]
    for mesh in meshes:
        whole.update(_mesh_bytes(mesh))
    return whole.hexdigest()[:16]


def _mesh_bytes(mesh: Mesh) -> bytes:
    arrays = (mesh.vertices, mesh.faces, mesh.normals, mesh.uv)
    return b"".join(b"none" if array is None else array.tobytes() for array in arrays)


def _lit_by(scene: Scene, path: Path) -> Scene:
    """Return the scene under an environment map from a file, metered anew."""
    environment = PictureEnvironment(asset=asset(path))
    exposed = exposure(irradiance(bake_environment(environment), environment.strength, scene.lights))
    cameras = tuple(camera.model_copy(update={"exposure": exposed}) for camera in scene.cameras)
    return scene.model_copy(update={"environment": environment, "cameras": cameras})


def _polished(prop: Prop, number: int) -> Prop:
    look = {"roughness": _POLISHED[number % len(_POLISHED)], "metallic": float(number % 2)}
    return prop.model_copy(update={"material": prop.material.model_copy(update=look)})


def _clear_vessel(vessel: GlassBody) -> GlassBody:
    liquid = vessel.liquid and vessel.liquid.model_copy(update={"medium": _clear(vessel.liquid.medium)})
    interfaces = tuple(_clear_interface(interface) for interface in vessel.interfaces)
    return vessel.model_copy(update={"glass": _clear(vessel.glass), "liquid": liquid, "interfaces": interfaces})


def _clear_interface(interface: Interface) -> Interface:
    return interface.model_copy(update={"front": _clear(interface.front), "back": _clear(interface.back)})


def _clear(medium: Medium) -> Medium:
    return medium.model_copy(update={"sigma_a": (0.0, 0.0, 0.0), "absorbers": ()})
