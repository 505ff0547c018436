"""Recover index and colour of a ball of dyed liquid from one rendered picture, by gradient descent.

    python examples/recover_index.py [--out docs/recover_index.png]

The picture is path-traced, with all light transport. Derivatives come from a simpler model: for each pixel the
refracted ray, attenuated by Fresnel and absorption, and the first reflection. The model leaves out light that is
reflected inside the ball, some 4 %. That light is rendered at the current estimate every few steps and added, so that
model and picture agree at the right answer. The ball is in front of a smooth pattern, because a gradient only helps
where the pattern is monotonic. The loss is over the ball's inner part: the derivative of the refracted ray ignores
that silhouettes move.
"""

from __future__ import annotations

import sys
import tempfile
from argparse import ArgumentParser
from pathlib import Path

import matplotlib as mpl
import numpy as np
from rich.console import Console

from glassware.core.assets import asset
from glassware.dataset.format.exr import write_exr
from glassware.procedural.description.picture import Picture
from glassware.procedural.description.scene import Scene
from glassware.procedural.description.surroundings import PictureEnvironment
from glassware.procedural.optics.medium import Medium
from glassware.procedural.primitives.bodies import ball
from glassware.procedural.primitives.scenes import board, camera, scene
from glassware.render.backend.variant import activate

mpl.use("Agg")
import matplotlib.pyplot as plt

#: The index to recover, and the initial estimate.
TRUTH, START = 1.45, 1.30
#: The same for its absorption of red, green and blue [1/m].
COLOUR, COLOUR_START = (1.0, 4.0, 2.5), 2.0
STEPS, RATE, COLOUR_RATE = 120, 0.01, 0.1
#: Steps between two renderings of the light that the model leaves out.
RENEWED = 10
SIZE, RADIUS, HEIGHT = 96, 0.1, 2.0
#: Fraction of the ball's apparent radius that the loss covers.
INNER = 0.8


def main() -> int:
    """Render, fit, print and draw."""
    options = ArgumentParser(description="Recover a ball's index from one picture.")
    options.add_argument("--out", type=Path, default=Path("docs/recover_index.png"))
    given = options.parse_args()
    activate("llvm_ad_rgb")
    with tempfile.TemporaryDirectory() as folder:
        pattern = Path(folder) / "pattern.exr"
        write_pattern(pattern)
        picture, history, fitted = fit(pattern)
    Console().print(f"absorption {COLOUR}: found {np.round(history[-1][2:], 2)} from {COLOUR_START} per metre")
    Console().print(f"index {TRUTH}: found {history[-1][0]:.4f} from {START}, off by {history[-1][0] - TRUTH:+.4f}")
    draw(given.out, picture, fitted, history)
    return 0


def write_pattern(path: Path) -> None:
    """Write the environment map: waves of red, green and blue, as wide as the part that the ball shows."""
    row, column = np.mgrid[:64, :128]
    azimuth, height = 2 * np.pi * (column + 0.5) / 128, np.cos(np.pi * (row + 0.5) / 64)
    planes = [0.5 + 0.35 * np.cos(3 * azimuth), 0.5 + 0.35 * np.sin(2.0 * height), 0.5 + 0.35 * np.sin(2 * azimuth)]
    write_exr(path, {name: plane.astype(np.float32) for name, plane in zip("RGB", planes, strict=True)})


def ball_scene(index: float, colour: tuple[float, float, float], pattern: Path) -> Scene:
    """Return a ball of dyed liquid in front of a pattern; the table, which every scene has, is far below."""
    liquid = Medium(name="dyed liquid", eta=index, sigma_a=colour)
    eye = camera((0.0, -0.5, HEIGHT), (0.0, 0.0, HEIGHT), width=SIZE, height=SIZE, focal=2.0 * SIZE)
    return scene(
        (ball(RADIUS, liquid, (0.0, 0.0, HEIGHT), chord_error=2.1e-5),),
        (eye,),
        table=board((0.1, 0.1, 0.01)),
        environment=PictureEnvironment(asset=asset(pattern)),
        picture=Picture(spp=256, denoise=False),
        seed=1,
    )


def fit(pattern: Path) -> tuple[np.ndarray, list[tuple[float, ...]], np.ndarray]:
    """Return the picture, index, loss and absorption after each step, and the final picture of the model."""
    import drjit as dr
    import mitsuba as mi

    from glassware.render.pictures.picture import trace_picture
    from glassware.render.scene.loaded_scene import load
    from glassware.render.scene.rays import pinhole, pixel_rays

    truth = ball_scene(TRUTH, COLOUR, pattern)
    kernel, view = load(truth), truth.cameras[0]
    picture = trace_picture(kernel, view, "left", 1).radiance
    ray, _ = pixel_rays(pinhole(view), dr.arange(mi.UInt32, SIZE * SIZE), mi.Point2f(0.0))
    target = mi.Color3f(np.ascontiguousarray(picture.reshape(-1, 3).T))
    rows, columns = np.mgrid[:SIZE, :SIZE] - (SIZE - 1) / 2
    # The ball's outline is the cone of half angle asin(radius / distance).
    inner = np.hypot(rows, columns) < INNER * view.focal * np.tan(np.arcsin(RADIUS / 0.5))
    weight = mi.Float(inner.ravel().astype(np.float32) / inner.sum())

    optimiser = mi.ad.Adam(lr=RATE, params={"index": mi.Float(START), "colour": mi.Color3f(COLOUR_START)})
    optimiser.set_learning_rate({"colour": COLOUR_RATE})
    history, rest, shown = [], mi.Color3f(0.0), mi.Color3f(0.0)
    for step in range(STEPS + 1):
        index, colour = optimiser["index"], optimiser["colour"]
        shown = model(kernel, ray, index, colour)
        if step % RENEWED == 0:
            guess = ball_scene(float(index[0]), tuple(np.array(colour).ravel().tolist()), pattern)
            rendered = trace_picture(load(guess), view, "left", 2 + step).radiance
            rest = mi.Color3f(np.ascontiguousarray(rendered.reshape(-1, 3).T)) - dr.detach(shown)
        loss = dr.sum(weight * dr.squared_norm(shown + rest - target))
        history.append((float(index[0]), float(loss[0]), *np.array(colour).ravel().tolist()))
        dr.backward(loss)
        optimiser.step()
        optimiser["colour"] = dr.maximum(optimiser["colour"], 0.0)
    return picture, history, np.array(dr.detach(shown + rest)).T.reshape(SIZE, SIZE, 3)


def model(kernel, ray, index, colour):
    """Return the light of the refracted rays and of the first reflection, differentiable by index and colour."""
    import drjit as dr
    import mitsuba as mi

    from glassware.render.labels.refraction import refract

    eta = dr.select(dr.arange(mi.UInt32, 2) == 0, 1.0, index)  # media: air, glass
    lane = dr.arange(mi.UInt32, 6)
    sigma_a = dr.select(lane < 3, 0.0, dr.gather(mi.Float, dr.ravel(colour), lane % 3))
    end = refract(kernel, ray, eta, sigma_a, derivatives=True)
    si = kernel.mi_scene.ray_intersect(ray)
    cos = -dr.dot(si.sh_frame.n, ray.d)
    reflectance, *_ = mi.fresnel(cos, index)
    mirrored = mi.reflect(-ray.d, si.sh_frame.n)
    share = dr.select(si.is_valid(), reflectance, 0.0)
    return end.transmittance * arriving(kernel, end.direction) + share * arriving(kernel, mirrored)


def arriving(kernel, direction):
    """Return the surroundings' radiance from a direction."""
    import drjit as dr
    import mitsuba as mi

    seen = dr.zeros(mi.SurfaceInteraction3f, dr.width(direction))
    seen.wi = -direction
    return mi.Color3f(kernel.mi_scene.environment().eval(seen))


def draw(out: Path, picture: np.ndarray, fitted: np.ndarray, history: list[tuple[float, ...]]) -> None:
    """Draw the picture, the fitted model, and index and loss by step."""
    figure, axes = plt.subplots(1, 5, figsize=(15, 3), layout="constrained")
    for panel, values, title in ((axes[0], picture, "rendered picture"), (axes[1], fitted, "fitted")):
        panel.imshow(np.clip(values, 0, 1) ** (1 / 2.2))
        panel.set_title(title)
        panel.axis("off")
    index, loss, *colour = np.array(history).T
    axes[2].plot(index)
    axes[2].axhline(TRUTH, color="black", linestyle=":")
    axes[2].set(title=f"index: {index[-1]:.4f} (true {TRUTH})", xlabel="step")
    for name, found, true in zip(("red", "green", "blue"), colour, COLOUR, strict=True):
        axes[3].plot(found, color=name)
        axes[3].axhline(true, color=name, linestyle=":")
    axes[3].set(title="absorption [1/m]", xlabel="step")
    axes[4].semilogy(loss)
    axes[4].set(title="mean squared error", xlabel="step")
    figure.savefig(out, dpi=80)


if __name__ == "__main__":
    sys.exit(main())
