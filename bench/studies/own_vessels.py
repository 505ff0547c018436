"""Vessels from files in figures: how long they take to be understood, how right volume and wall are, what they cost.

    python bench/studies/own_vessels.py [--files FOLDER] [--parts shapes,thousand,pictures]

Volumes are compared with points of which rays, cast by Mitsuba, decide whether they are in the cavity: below the brim,
not in the glass, with glass below and all around. Walls are compared with the thickness that the shape was made with.
The same scene is rendered with drawn vessels and with their meshes as vessels from files. Times are CPU times.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import mitsuba as mi
import numpy as np
import trimesh

import glassware as gw
from glassware.core.mesh import Mesh
from glassware.procedural.cavities.find import Hollow
from glassware.procedural.cavities.interior import interior_of
from glassware.procedural.description.bodies import Vessel, glass_solid
from glassware.procedural.description.mesh_vessel import mesh_vessel, refilled_mesh
from glassware.procedural.own_vessels.files import VesselFile, vessel_files
from glassware.procedural.own_vessels.shape import own_shape
from glassware.procedural.props.mesh_files import usable_meshes
from glassware.procedural.vessels.settings import VesselSettings
from glassware.render.backend.variant import activate

#: Points of the Monte Carlo volume [1]: 0.2 % of one standard deviation for a cavity that fills half of its box.
POINTS = 400_000
#: Directions around a point in which its cavity has a wall [1].
AROUND = 16


@dataclass(frozen=True)
class Shape:
    """A vessel that is made for the comparison."""

    name: str
    mesh: trimesh.Trimesh  #: [m], z up
    wall: float  #: thickness that it was made with [m]


def shapes() -> Iterator[Shape]:
    """Yield vessels of 100,000 triangles and of fewer."""
    heights = np.linspace(0.0, 1.0, 50)
    yield Shape("beaker", _revolved(heights, lambda z: np.full_like(z, 0.035), 0.09, 0.002, 500), 0.002)
    yield Shape("carafe", _revolved(heights, lambda z: 0.03 + 0.02 * np.sin(3.0 * z), 0.2, 0.0025, 500), 0.0025)
    cup = _revolved(np.linspace(0.0, 1.0, 12), lambda z: 0.025 + 0.012 * z, 0.08, 0.003, 96)
    ring = trimesh.creation.torus(0.022, 0.004, major_sections=48, minor_sections=24)
    ring.apply_transform(trimesh.transformations.rotation_matrix(0.5 * np.pi, [1, 0, 0]))
    ring.apply_translation([0.045, 0.0, 0.045])
    inside = _inside_of(np.linspace(0.0, 1.0, 12), lambda z: 0.025 + 0.012 * z, 0.08, 0.003, 96)
    handled = trimesh.boolean.difference([trimesh.boolean.union([cup, ring], engine="manifold"), inside])
    yield Shape("cup with a handle", handled, 0.003)


def _revolved(
    heights: np.ndarray, radius: Callable[[np.ndarray], np.ndarray], height: float, wall: float, sections: int
) -> trimesh.Trimesh:
    outer = np.stack([radius(heights), height * heights], 1)
    inner = _inner(heights, radius, height, wall)
    profile = np.concatenate([[[0.0, 0.0]], outer, inner[::-1], [[0.0, wall]]])
    return trimesh.creation.revolve(profile, sections=sections)


def _inner(heights: np.ndarray, radius: Callable[[np.ndarray], np.ndarray], height: float, wall: float) -> np.ndarray:
    """Return the inside at a distance across the wall, not across the axis."""
    z = wall / height + (1.0 - wall / height) * heights
    slope = np.gradient(radius(z), height * z)
    return np.stack([radius(z) - wall * np.hypot(1.0, slope), height * z], 1)


def _inside_of(
    heights: np.ndarray, radius: Callable[[np.ndarray], np.ndarray], height: float, wall: float, sections: int
) -> trimesh.Trimesh:
    inner = _inner(heights, radius, height, wall)
    profile = np.concatenate([[[0.0, wall]], inner, [[inner[-1, 0], 1.1 * height], [0.0, 1.1 * height]]])
    return trimesh.creation.revolve(profile, sections=sections)


def volume_by_rays(solid: Mesh, hollow: Hollow) -> tuple[float, float]:
    """Return the volume of a cavity [m^3], and one standard deviation of it, from points and rays."""
    mesh = mi.Mesh("solid", len(solid.vertices), len(solid.faces))
    values = mi.traverse(mesh)
    values["vertex_positions"] = np.ascontiguousarray(solid.vertices, np.float32).ravel()
    values["faces"] = np.ascontiguousarray(solid.faces, np.uint32).ravel()
    values.update()
    scene = mi.load_dict({"type": "scene", "solid": mesh})
    low, high = solid.bounds.astype(np.float64)
    low[2], high[2] = hollow.floor - 1e-3, hollow.brim
    points = low + np.random.default_rng(1).random((POINTS, 3)) * (high - low)
    sides = np.arange(AROUND) * 2.0 * np.pi / AROUND + 0.1
    directions = [[0.0, 0.0, -1.0], *np.stack([np.cos(sides), np.sin(sides), np.zeros(AROUND)], 1).tolist()]
    inside = np.ones(POINTS, bool)
    origin = mi.Point3f(*points.T.astype(np.float32))
    for number, direction in enumerate(directions):
        hit = scene.ray_intersect_preliminary(mi.Ray3f(origin, mi.Vector3f(*direction)))
        inside &= np.asarray(hit.is_valid())
        if number == 0:  # from free space the first face is seen from its front
            face = np.minimum(np.asarray(hit.prim_index), len(solid.faces) - 1)
            corners = solid.vertices[solid.faces[face]].astype(np.float64)
            normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            inside &= normal[:, 2] > 0.0
    share, box = inside.mean(), float(np.prod(high - low))
    return share * box, box * float(np.sqrt(share * (1.0 - share) / POINTS))


def understood(folder: Path) -> None:
    """Print time, volume and wall of made vessels, in each format."""
    for shape in shapes():
        for suffix in ("obj", "ply", "stl", "glb"):
            path = folder / f"{shape.name.replace(' ', '-')}.{suffix}"
            shape.mesh.export(path)
            file, settings = VesselFile(path, folder), VesselSettings(up="z")
            start = time.process_time()
            inside = interior_of(own_shape(file, settings).solid)
            say(f"{path.name}: {len(shape.mesh.faces):,} triangles, understood in {time.process_time() - start:.1f} s")
        _print_figures(shape.name, own_shape(file, settings).solid, shape.wall)
        assert inside.hollows


def _print_figures(name: str, solid: Mesh, wall: float | None) -> None:
    inside = interior_of(solid)
    for hollow in inside.hollows:
        truth, spread = volume_by_rays(solid, hollow)
        off = 100.0 * (hollow.volume / truth - 1.0)
        say(f"{name}: holds {1e6 * hollow.volume:.2f} ml, {off:+.2f} % of rays (sd {100 * spread / truth:.2f} %)")
    if wall is not None and inside.wall is not None:
        off = 100.0 * (inside.wall / wall - 1.0)
        say(f"{name}: wall {1e3 * inside.wall:.3f} mm, made with {1e3 * wall:.3f} mm ({off:+.1f} %)")


def files_of(folder: Path) -> None:
    """Print the volumes of the vessels in a folder, as they are and by rays."""
    settings = VesselSettings.model_validate({"shell": 0.003, "up": "fullest"})
    for file in vessel_files(folder):
        start = time.process_time()
        try:
            solid = own_shape(file, settings).solid
        except gw.InputError as error:
            say(f"{file.name}: {error}")
            continue
        interior_of(solid)
        say(f"{file.name}: {len(solid.faces):,} triangles, understood in {time.process_time() - start:.1f} s")
        _print_figures(file.name, solid, None)


def thousand(folder: Path) -> None:
    """Print how long a folder of a thousand files takes to open for the first and for the second time."""
    box = trimesh.creation.icosphere(subdivisions=3, radius=0.05)
    for number in range(1000):
        place = folder / f"{number:04d}"
        place.mkdir()
        box.copy().apply_translation([0.001 * number, 0.0, 0.0]).export(place / "model.obj")
    os.environ["XDG_CACHE_HOME"] = str(folder / "cache")
    for time_number in ("first", "second"):
        start = time.perf_counter()
        found, _ = usable_meshes(folder)
        say(f"{len(found):,} objects of {len(box.faces)} triangles open in {time.perf_counter() - start:.1f} s, ", "")
        say(f"the {time_number} time")


def pictures() -> None:
    """Print the CPU time of frames with drawn vessels, and with their meshes as vessels from files."""
    settings = {"vessel_count": (4, 4), "prop_count": (2, 2), "cameras": {"views": 6, "width": 320, "height": 240}}
    drawn = gw.draw(5, picture={"spp": 32}, vessels={"fill_probability": 0.75}, **settings)
    own = drawn.model_copy(update={"vessels": tuple(_as_own(item) for item in drawn.vessels)})
    times = {}
    for name, scene in (("drawn", drawn), ("from files", own)):
        renderer = gw.Renderer(scene)
        renderer.frame(0)
        start = time.process_time()
        for view in range(1, len(scene.cameras)):
            renderer.frame(view)
        times[name] = (time.process_time() - start) / (len(scene.cameras) - 1)
        triangles = sum(len(part.mesh.faces) for item in scene.vessels for part in item.interfaces)
        say(f"vessels {name}: {triangles:,} triangles, {times[name]:.2f} s of CPU time a stereo view")
    say(f"from files over drawn: {times['from files'] / times['drawn']:.2f}")


def _as_own(item: gw.GlassBody) -> gw.GlassBody:
    assert isinstance(item, Vessel)
    whole = glass_solid(item)
    solid = Mesh(f"{item.name}-solid", whole.vertices, whole.faces, whole.normals)
    fields = {"id": item.id, "name": item.name, "category": item.category, "roughness": item.roughness}
    vessel = mesh_vessel(solid, item.glass, symmetric=True, **fields)
    if item.liquid is not None:
        vessel = refilled_mesh(vessel, item.liquid.medium, item.liquid.fill)
    return vessel.model_copy(update={"world_T_object": item.world_T_object})


def say(line: str, end: str = "\n") -> None:
    """Write a line."""
    sys.stdout.write(line + end)
    sys.stdout.flush()


def main() -> int:
    """Print all figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=Path, help="folder of vessels, whose volumes are compared as well")
    parser.add_argument("--parts", default="shapes,thousand,pictures", help="what to measure")
    options = parser.parse_args()
    activate()
    parts = options.parts.split(",")
    with tempfile.TemporaryDirectory() as folder:
        if "shapes" in parts:
            understood(Path(folder))
    if options.files is not None:
        files_of(options.files)
    with tempfile.TemporaryDirectory() as folder:
        if "thousand" in parts:
            thousand(Path(folder))
    if "pictures" in parts:
        pictures()
    return 0


if __name__ == "__main__":
    sys.exit(main())
