"""Soft mattes: how much of each pixel an object covers, and how much of the light behind it passes it.

Masks know pixels' centres alone, so their edges are steps. Here each pixel has `SAMPLES` straight rays, stratified over
its area, and every ray counts the same: the pictures' own reconstruction filter, a box of one pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..procedural.description.material_list import materials_of
from ..procedural.description.scene import Prop, Scene, SceneObject
from ..render.frame import Geometry, Transmission
from ..render.renderer import MAX_LAYERS, Renderer

#: Rays of a pixel [1], a power of two. Of an edge along rows or columns they tell positions 1/16 px apart.
SAMPLES = 16


@dataclass(frozen=True, eq=False)
class Mattes:
    """Soft mattes of the n objects of a scene in one picture, in the order of their ids."""

    ids: tuple[int, ...]
    first: dict[int, np.ndarray]  #: (H, W) float32 by instance id: fraction of the pixel where it is the first surface
    coverage: np.ndarray  #: (n, H, W) float32, fraction of the pixel where no opaque surface hides the object
    #: (n, H, W, 3) float32, mean over that part of the pixel of the light that the object passes on along straight
    #: rays, linear Rec.709; 1 where it covers nothing, 0 for opaque objects
    transmittance: np.ndarray


def soft_mattes(renderer: Renderer, view: int, samples: int = SAMPLES) -> Mattes:
    """Return the soft mattes of the left camera of a view.

    Parameters
    ----------
    renderer : Renderer
        It traces the rays.
    view : int
        Number of the camera in ``scene.cameras``.
    samples : int
        Rays of a pixel.

    Notes
    -----
    On a ray s the object i passes on t_i(s), the product over its own surfaces and media up to the first opaque surface
    of 1 minus the Fresnel reflectance and of exp(-sigma_a l). Over all objects their product is ``transmittance`` of
    `Geometry`. Surfaces beyond the 64th of a ray pass on everything.
    """
    scene, camera = renderer.scene, renderer.scene.cameras[view]
    shape, owners = (camera.height, camera.width), _Owners.of(scene)
    items = [item.id for item in scene.objects]
    first: dict[int, np.ndarray] = {}
    covered = np.zeros((len(items), shape[0] * shape[1]), np.int32)
    passed = np.zeros((*covered.shape, 3))
    layers = int(np.clip(renderer.transmission(view, 1)[1].max(), 1, MAX_LAYERS))
    for shift in sample_places(samples):
        geometry, _, rays = renderer.transmission(view, layers, (float(shift[0]), float(shift[1])))
        for number in np.unique(geometry.id).tolist():
            first.setdefault(number, np.zeros(shape, np.float32))[geometry.id == number] += 1.0 / samples
        reached = geometry.reached.reshape(len(items), -1)
        covered += reached
        passed += np.where(reached[..., None], _passed_by_object(rays, owners, geometry), 0.0)
    first.pop(0, None)
    fraction = (covered / np.float32(samples)).astype(np.float32)
    mean = np.where(covered[..., None] > 0, passed / np.maximum(covered, 1)[..., None], 1.0)
    count = len(items)
    return Mattes(
        tuple(items), first, fraction.reshape(count, *shape), mean.astype(np.float32).reshape(count, *shape, 3)
    )


def sample_places(count: int) -> np.ndarray:
    """Return places within a pixel, (count, 2) float64, from its centre [px].

    The first points of Sobol's sequence in two dimensions, each in the middle of its cell: of 16, every row and every
    column of a 16 x 16 grid, and every cell of a 4 x 4 grid, holds one.

    Parameters
    ----------
    count : int
        A power of two up to 256.
    """
    bits = (count - 1).bit_length()
    if count != 1 << bits or bits > 8:
        raise ValueError(f"expected a power of two up to 256, got {count}")
    index = np.arange(count)
    # Direction numbers of the first two dimensions (Bratley and Fox 1988, "Algorithm 659"): bit reversal, and the
    # polynomial x + 1, whose direction numbers are rows of Pascal's triangle modulo 2.
    directions, second = [1 << (bits - 1 - i) for i in range(bits)], [1 << (bits - 1)] if bits else []
    for _ in range(1, bits):
        second.append(second[-1] ^ (second[-1] >> 1))
    places = [np.zeros(count, np.int64), np.zeros(count, np.int64)]
    for bit in range(bits):
        for axis, numbers in enumerate((directions, second)):
            places[axis] ^= np.where(index >> bit & 1, numbers[bit], 0)
    return (np.stack(places, axis=1) + 0.5) / count - 0.5


@dataclass(frozen=True, eq=False)
class _Owners:
    """Which object a medium belongs to."""

    place: np.ndarray  #: by instance id: number of the object, -1 for the table and surroundings
    held: np.ndarray  #: (n + 1, materials) bool, by number of the object: whether it holds that medium; last for none

    @classmethod
    def of(cls, scene: Scene) -> _Owners:
        """Return the owners of a scene's media."""
        materials = materials_of(scene)
        place = np.full(1 << 16, -1)
        held = np.zeros((len(scene.objects) + 1, len(materials)), bool)
        for number, item in enumerate(scene.objects):
            place[item.id] = number
            held[number, [materials.index(medium) for medium in _media(item)]] = True
        return cls(place, held)


def _media(item: SceneObject) -> list:
    """Return the media inside an object: its glass, its liquids, and what floats or lies in them."""
    if isinstance(item, Prop):
        return []
    inside = [content.medium for content in item.contents]
    return [item.glass, *(liquid.medium for liquid in item.liquids), *inside]


def _passed_by_object(rays: Transmission, owners: _Owners, geometry: Geometry) -> np.ndarray:
    """Return what each object passes on of each ray, (n, N, 3)."""
    count = len(geometry.crossed)
    passed = np.ones((count + 1, rays.id.shape[1], 3))  # the last one: what belongs to no object
    before, medium = np.full(rays.id.shape[1], -1), np.zeros(rays.id.shape[1], np.int64)
    clear = np.ones(rays.id.shape[1], bool)  # of opaque surfaces
    for ids, material, surface, segment in zip(rays.id, rays.material, rays.surface, rays.segment, strict=True):
        at = np.flatnonzero(clear & (ids > 0))
        here, last = owners.place[ids[at]], before[at]
        # A segment belongs to the one of the two bodies at its ends that holds its medium: a rod in a liquid does not.
        owner = np.where(owners.held[last, medium[at]], last, here)
        passed[owner, at] *= segment[at]
        passed[here, at] *= surface[at, None]
        clear[at] &= surface[at] > 0.0
        before[at], medium[at] = here, material[at]
    return passed[:count]
