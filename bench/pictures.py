"""Where the pictures of drawn scenes differ from converged ones: by region, with standard errors.

    python bench/pictures.py --seeds 101 102 103 --pictures .scratch/pictures
    python bench/pictures.py --seeds 101 --preset standard --assets ../shared/assets

Each seed is drawn with a preset, as `render-scene` does, and one of its views is rendered as the scene says. The
reference is path traced, in passes that are kept in a folder. Paths do not find caustics of the sun: under an open sky
the reference reads them from a photon map of its own, with eight times the photons and without a filter. Regions are
the table, its caustics, every prop and every vessel, by the geometry's ids, less the pixels at their outlines. Of each
the table shows the ratio of its light to the reference's, with its standard error.

Pixels that see the surroundings directly have no noise: there the clean picture must be the noisy one. Caustics are
blocks of the table whose light over their albedo is far above the table's median in the reference.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from time import process_time

import cv2
import mitsuba as mi
import numpy as np
from command import Output, run
from ours import Ours, our_reference
from picture import srgb_levels, write_exposed
from references import Reference
from skimage.metrics import structural_similarity
from table import Row, report

from glassware.core.images import srgb8
from glassware.core.randomness import stream_seed
from glassware.dataset.settings.draw import draw
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import TABLE_ID, GlassBody, Scene
from glassware.procedural.surroundings.colour import luminance
from glassware.procedural.surroundings.environments import bake_environment
from glassware.procedural.surroundings.file_light import is_outdoors
from glassware.render.cache.cache_points import cache_points_of
from glassware.render.cache.irradiance_cache import IrradianceCache
from glassware.render.cache.photon_map import photon_moments
from glassware.render.cache.scene_cache import make_tracer, photon_count, uses_cache
from glassware.render.cache.stored_caustics import path_tracer_with_caustics
from glassware.render.frame import LightCheck
from glassware.render.labels.geometry import trace_geometry
from glassware.render.pictures.integrator import Radiance
from glassware.render.pictures.picture import PATH_TRACER, NoisyImage, Tracer, denoise_image, trace_picture
from glassware.render.pictures.sampler import SobolSampler
from glassware.render.scene.loaded_scene import LoadedScene, load

#: Bounds: largest change of a pixel that sees the surroundings [sRGB levels]; largest error of a caustic block, of a
#: prop and of a vessel [fraction]; smallest PSNR in vessels [dB].
MAX_CHANGE, MAX_CAUSTIC, MAX_BIAS, MIN_PSNR = 0.5, 0.10, 0.02, 31.0
#: Standard errors beyond a bound that still count as noise of the reference.
STANDARD_ERRORS = 3.0
#: Side of a block [px]; light over the table's median from which a block is a caustic [1].
BLOCK, CAUSTIC = 8, 1.4
#: Regions of fewer pixels are left out.
MIN_PIXELS = 60
#: Photons of the reference over those of a picture [1].
_REFERENCE_PHOTONS = 8
#: Worst blocks that are written enlarged, and the factor.
_WORST, _ENLARGED, _AROUND = 6, 6, 16


@dataclass(frozen=True, kw_only=True)
class Options(Output):
    """What to measure."""

    seeds: tuple[int, ...] = tuple(range(101, 109))
    """Seeds that are drawn."""
    view: int = 0
    """The view of each."""
    preset: str = "fast"
    """Preset that is drawn."""
    spp: int | None = None
    """Samples per pixel instead of the preset's."""
    light: str = "auto"
    """`picture.light`."""
    assets: Path | None = None
    """Folder with `meshes`, `textures` and `hdri`; own surfaces and rooms without it."""
    shipped_share: float = 0.0
    """`environment.shipped_share`: the probability of one of the maps that ship with the package."""
    reference_spp: int = 1024
    """Samples per pixel of the references."""
    cache: Path = Path(".scratch/references")
    """Folder of the references."""
    pictures: Path | None = None
    """Folder for the worst blocks, enlarged: noisy, clean, reference."""


@dataclass(frozen=True, eq=False)
class _Made:
    """One picture with its reference."""

    seed: int
    scene: Scene
    ids: np.ndarray  #: (H, W) first surface of each pixel's centre
    image: NoisyImage
    picture: np.ndarray  #: (H, W, 3), denoised
    check: LightCheck | None
    exposure: float
    reference: Reference
    albedo: np.ndarray  #: (H, W, 3)
    light_seconds: float  #: CPU time of the irradiance cache and its check [s]
    seconds: float  #: CPU time of one picture [s]

    @property
    def clean(self) -> np.ndarray:
        """Exposed linear picture, (H, W, 3)."""
        return self.picture * self.exposure

    @property
    def noisy(self) -> np.ndarray:
        """The same before the denoiser."""
        return self.image.radiance * self.exposure

    @property
    def noise(self) -> np.ndarray:
        """Standard error of the luminance of each noisy pixel, exposed, (H, W); channels count as correlated."""
        return self.exposure * luminance(np.sqrt(self.image.variance))


def main(options: Options) -> int:
    """Measure and print; 1 where a bound is broken."""
    rows: list[Row] = []
    for seed in options.seeds:
        made = _made(seed, options)
        rows += _rows(made)
        if options.pictures is not None:
            _write_worst(options.pictures, made)
    facts = {"preset": options.preset, "light": options.light, "reference_spp": options.reference_spp}
    return report("Pictures of drawn scenes", rows, options.json_file, **facts)


def _made(seed: int, options: Options) -> _Made:
    picture: dict = {"light": options.light} | ({} if options.spp is None else {"spp": options.spp})
    groups: dict = {"environment": {"shipped_share": options.shipped_share}}
    if options.assets is not None:
        groups |= {"mesh_dir": options.assets / "meshes", "texture_dir": options.assets / "textures"}
        groups["environment"] = {"hdri_dir": options.assets / "hdri"}
    scene = draw(seed, preset=options.preset, picture=picture, **groups)
    camera, seed_of = (
        scene.cameras[options.view],
        stream_seed(scene.seed, scene.scene_id, f"render/{options.view}/left"),
    )
    cached = uses_cache(scene)
    loaded, check, tracer = load(scene, for_cache=cached), None, PATH_TRACER
    start = process_time()
    if cached:
        tracer, check, _ = make_tracer(loaded)
    light_seconds = process_time() - start
    trace_picture(loaded, camera, "left", seed_of, tracer)  # compiles
    start = process_time()
    image = trace_picture(loaded, camera, "left", seed_of, tracer)
    clean = denoise_image(image)
    seconds = process_time() - start
    one = scene.model_copy(update={"cameras": (camera,)})
    kept = _reference(one, options)
    ids = trace_geometry(loaded, camera).id
    albedo = image.guides.albedo
    return _Made(seed, scene, ids, image, clean, check, camera.exposure, kept, albedo, light_seconds, seconds)


def _reference(scene: Scene, options: Options) -> Reference:
    """Return the converged picture of a scene of one camera."""
    pixels = bake_environment(scene.environment)
    if not is_outdoors(scene.environment, pixels):
        return our_reference(Ours(load(scene), 0.0, 0.0), options.cache, options.reference_spp)
    loaded = load(scene, for_cache=True)
    return our_reference(Ours(loaded, 0.0, 0.0), options.cache, options.reference_spp, tracer=_with_photons())


def _with_photons() -> Tracer:
    """Return the path tracer that reads caustics from many photons, which are traced on its first use."""
    made: list[Tracer] = []

    def trace(
        loaded: LoadedScene, ray: mi.Ray3f, weight: mi.UnpolarizedSpectrum, sampler: SobolSampler, picture: Picture
    ) -> Radiance:
        if not made:
            made.append(_photon_tracer(loaded))
        return made[0].trace(loaded, ray, weight, sampler, picture)

    return Tracer(trace, PATH_TRACER.weights)


def _photon_tracer(loaded: LoadedScene) -> Tracer:
    points = cache_points_of(loaded)
    photons = _REFERENCE_PHOTONS * photon_count(loaded.description, points)
    caustics = np.mean(photon_moments(loaded, points, photons, 1), axis=0)
    cache = IrradianceCache(points, np.zeros_like(caustics), np.zeros(points.count), caustics=caustics)
    return path_tracer_with_caustics(loaded, cache)


def regions(scene: Scene, ids: np.ndarray) -> Iterator[tuple[str, str, np.ndarray]]:
    """Yield kind, name and pixels (H, W) bool of each region, less the pixels at outlines.

    Parameters
    ----------
    scene : Scene
        The scene.
    ids : (H, W) int
        First surface of each pixel's centre.
    """
    yield "surroundings", "surroundings", _inner(ids == 0)
    yield "table", "table", _inner(ids == TABLE_ID)
    for item in scene.objects:
        kind = "vessel" if isinstance(item, GlassBody) else "prop"
        yield kind, f"{kind} {item.id}", _inner(ids == item.id)


def _inner(mask: np.ndarray) -> np.ndarray:
    return cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=1).astype(bool)


def _rows(made: _Made) -> list[Row]:
    rows, ids, similarity = [], made.ids, _similarity(made)
    for kind, name, pixels in regions(made.scene, ids):
        title = f"{made.seed}: {name}"
        if pixels.sum() < MIN_PIXELS:
            continue
        if kind == "surroundings":
            rows.append(_change_row(made, title, pixels))
            continue
        bound = None if kind == "table" else MAX_BIAS
        rows.append(_ratio_row(made, title, pixels, bound))
        if kind == "table":
            rows += _caustic_rows(made, title, pixels)
        if kind == "vessel":
            rows.append(_psnr_row(made, title, pixels))
        rows.append(Row(f"{title}, structural similarity", float(similarity[pixels].mean())))
    rows.append(Row(f"{made.seed}: structural similarity", float(similarity.mean())))
    rows.append(Row(f"{made.seed}: CPU time of one picture", made.seconds, "s"))
    note = "" if made.check is None else f"{made.check.mode}, path traced: {made.check.traced}"
    rows.append(Row(f"{made.seed}: CPU time of the stored light", made.light_seconds, "s", note=note))
    return rows


def _similarity(made: _Made) -> np.ndarray:
    """Return the structural similarity of the sRGB pictures at each pixel, (H, W), by windows of 7 px around it.

    The reference's noise counts as a difference: of a region with much of it no picture has a high similarity.
    """
    pictures = (srgb8(picture, 1.0) for picture in (made.reference.picture, made.clean))
    return np.asarray(structural_similarity(*pictures, channel_axis=2, full=True)[1]).mean(axis=2)


def _change_row(made: _Made, title: str, pixels: np.ndarray) -> Row:
    """Compare clean and noisy pixels that have no noise."""
    change = np.abs(srgb_levels(made.clean) - srgb_levels(made.noisy)).max(axis=-1)[pixels]
    note = f"{int((change > MAX_CHANGE).sum())} of {change.size} pixels beyond the bound"
    worst = float(change.max())
    return Row(f"{title}, largest change", worst, "levels", bound=MAX_CHANGE, ok=worst <= MAX_CHANGE, note=note)


def _ratio_row(made: _Made, title: str, pixels: np.ndarray, bound: float | None) -> Row:
    ratio, error = _ratio(made, pixels)
    noisy = luminance(made.noisy)[pixels].sum() / luminance(made.reference.picture)[pixels].sum()
    ok = None if bound is None else abs(ratio - 1.0) <= max(bound, STANDARD_ERRORS * error)
    note = f"+- {error:.4f}; before the denoiser {noisy:.4f}; {int(pixels.sum())} pixels"
    return Row(f"{title}, light over the reference's", ratio, bound=bound, ok=ok, note=note)


def _ratio(made: _Made, pixels: np.ndarray) -> tuple[float, float]:
    """Return the ratio of a region's light to the reference's, and its standard error.

    The error is that of the reference, from its passes, and of the noisy picture, from its groups of samples.
    """
    reference = luminance(made.reference.picture)[pixels].sum()
    variance = _reference_variance(made)[pixels].sum() + (made.noise[pixels] ** 2).sum()
    return float(luminance(made.clean)[pixels].sum() / reference), float(np.sqrt(variance) / reference)


def _reference_variance(made: _Made) -> np.ndarray:
    """Return the variance of the reference's luminance, (H, W); channels count as correlated."""
    return luminance(np.sqrt(made.reference.variance)) ** 2


def caustic_blocks(picture: np.ndarray, albedo: np.ndarray, table: np.ndarray) -> np.ndarray:
    """Return which blocks of `BLOCK` pixels are caustics on the table, (rows, columns) bool.

    Parameters
    ----------
    picture, albedo : (H, W, 3) float
        Exposed reference, and the reflectance of what each pixel shows.
    table : (H, W) bool
        Pixels that show the table directly.
    """
    level = luminance(picture) / np.maximum(luminance(albedo), 0.02)
    whole = block_means(table.astype(np.float64)) == 1.0
    return whole & (block_means(level) > CAUSTIC * np.median(level[table]))


def block_means(values: np.ndarray) -> np.ndarray:
    """Return the means of blocks of an (H, W) array; a narrower border is left out."""
    rows, columns = values.shape[0] // BLOCK, values.shape[1] // BLOCK
    cut = values[: rows * BLOCK, : columns * BLOCK]
    return cut.reshape(rows, BLOCK, columns, BLOCK).mean(axis=(1, 3))


def _caustic_rows(made: _Made, title: str, table: np.ndarray) -> list[Row]:
    caustic = caustic_blocks(made.reference.picture, made.albedo, table)
    if not caustic.any():
        return []
    reference = block_means(luminance(made.reference.picture))[caustic]
    variance = block_means(_reference_variance(made))[caustic] / BLOCK**2
    error = np.abs(block_means(luminance(made.clean))[caustic] / reference - 1.0)
    excess = error - STANDARD_ERRORS * np.sqrt(variance) / reference
    worst = int(np.argmax(excess))
    note = f"{int((excess > MAX_CAUSTIC).sum())} of {len(error)} blocks beyond; noise of the reference there "
    note += f"{float(np.sqrt(variance[worst]) / reference[worst]):.3f}"
    ok = bool(excess[worst] <= MAX_CAUSTIC)
    return [Row(f"{title}, caustic block, largest error", float(error[worst]), bound=MAX_CAUSTIC, ok=ok, note=note)]


def _psnr_row(made: _Made, title: str, pixels: np.ndarray) -> Row:
    """Return the PSNR of the sRGB picture in a region, less the error that the reference's own noise adds."""
    reference = made.reference
    error = ((srgb_levels(made.clean) - srgb_levels(reference.picture)) ** 2)[pixels].mean()
    step = 1e-3
    slope = (srgb_levels(reference.picture + step) - srgb_levels(reference.picture - step)) / (2.0 * step)
    noise = (slope**2 * reference.variance)[pixels].mean()
    psnr = float(10.0 * np.log10(255.0**2 / max(error - noise, 1e-3)))
    note = f"noise of the reference {float(10.0 * np.log10(255.0**2 / max(noise, 1e-3))):.1f} dB"
    return Row(f"{title}, PSNR", psnr, "dB", bound=MIN_PSNR, ok=psnr >= MIN_PSNR, note=note)


def _write_worst(folder: Path, made: _Made) -> None:
    """Write the blocks with the largest relative error, enlarged, and the whole pictures."""
    stages = (made.noisy, made.clean, made.reference.picture)
    write_exposed(folder / f"{made.seed}.png", np.concatenate(stages, axis=1))
    clean, reference = (block_means(luminance(picture)) for picture in stages[1:])
    error = np.abs(clean - reference) / (reference + 0.05)
    for rank, block in enumerate(np.argsort(error, axis=None)[: -_WORST - 1 : -1]):
        row, column = (BLOCK * int(k) + BLOCK // 2 for k in np.unravel_index(block, error.shape))
        part = slice(max(row - _AROUND, 0), row + _AROUND), slice(max(column - _AROUND, 0), column + _AROUND)
        enlarged = [np.kron(stage[part], np.ones((_ENLARGED, _ENLARGED, 1))) for stage in stages]
        write_exposed(folder / f"{made.seed}-worst-{rank}.png", np.concatenate(enlarged, axis=1))


if __name__ == "__main__":
    sys.exit(run(Options, __doc__, main))
