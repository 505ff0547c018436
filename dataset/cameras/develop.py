"""From radiance to the pictures of a camera: the steps, in the order in which light takes them.

Lens: defocus, distortion, fall-off. Sensor: exposure, filters and mosaic, shot and read noise, converter. Processing:
demosaicing, shading correction, white balance, colour matrix, tone curve, 8 bits, JPEG. Rectification is last.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from ...core.images import LINEAR, Tone, common_tone, srgb8
from ...core.margin import NO_MARGIN, Sides, in_frame
from ...core.randomness import stream
from .colour import balance, balanced_matrix, encoded, to_sensor
from .defocus import circle, defocused, focused_at, right_depth
from .lens import Lens, Warps, falloff, margins, warps
from .model import ColourCamera, SensorColour
from .sensor import demosaiced, exposed, mosaic, summed_pixels

#: Light is cut here, in units of saturation: no noise brings it back below 1.
_BRIGHTEST = 4.0


@dataclass(frozen=True, eq=False)
class PairLight:
    """What a stereo pair sees, and its geometry; the three arrays have the margin around the frame of H x W pixels."""

    left: np.ndarray  #: (H, W, 3) float32, linear Rec.709 radiance, or the raw response of `sensor`
    right: np.ndarray  #: the same of the right camera
    Z: np.ndarray  #: (H, W) float32, planar depth of the first surface of the left camera [m]; +inf without one
    optics: Lens  #: fx, fy, cx, cy of both cameras, in the frame's pixels [px]
    baseline: float  #: [m]
    exposure: float  #: factor from radiance to the linear value that saturates at 1
    tone: Tone = LINEAR  #: of the ideal camera; others have their own white balance and tone curve
    margin: Sides = NO_MARGIN  #: rendered beyond the frame for the distortion of the lens (`lens.margins`)
    sensor: SensorColour | None = None  #: whose raw response both pictures are; None: they are linear Rec.709

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the frame [px]."""
        height, width = in_frame(self.left, self.margin).shape[:2]
        return width, height


@dataclass(frozen=True)
class Control:
    """What a camera sets for one view; both eyes have the same."""

    exposure: float  #: factor from radiance to the light of the sensor, error included
    gain: float  #: analogue gain
    focus: float  #: distance in focus [m]


def develop(
    camera: ColourCamera, light: PairLight, seed: int, scene_id: int, view: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the pictures of the left and the right eye, (H, W, 3) uint8 each, sRGB.

    Exposure, gain, focus and white balance are those of the left picture for both. Each eye has its own noise.

    Parameters
    ----------
    camera : ColourCamera
        The camera; the ideal one gives `core.images.srgb8`, bit for bit; of raw responses by their matrix in daylight.
    light : PairLight
        The rendered pair.
    seed, scene_id, view : int
        Of the random streams: ``camera/<view>`` and ``camera/<view>/<eye>``.
    """
    if camera.ideal:
        left, right = (_rec709(in_frame(one, light.margin), light.sensor) for one in (light.left, light.right))
        tone = common_tone(light.tone, left, light.exposure)
        return srgb8(left, light.exposure, tone), srgb8(right, light.exposure, tone)
    rng = stream(seed, scene_id, f"camera/{view}")
    control = _control(camera, light, rng)
    signals = []
    for eye, picture in (("left", light.left), ("right", light.right)):
        seen = _through_lens(camera, light, control, picture, eye == "left")
        signals.append(_sensed(camera, light, control, seen, stream(seed, scene_id, f"camera/{view}/{eye}")))
    gains = balance(camera, signals[0], rng, light.sensor)
    left, right = (_processed(camera, light, gains, signal) for signal in signals)
    return left, right


def _rec709(picture: np.ndarray, sensor: SensorColour | None) -> np.ndarray:
    """Return a picture in linear Rec.709: of raw responses by the colour matrix for daylight."""
    return picture if sensor is None else cv2.transform(picture, np.array(sensor.matrix, np.float32))


def lost_pixels(
    camera: ColourCamera, optics: Lens, width: int, height: int, margin: Sides = NO_MARGIN
) -> np.ndarray | None:
    """Return the pixels of a camera's picture that the rendered one cannot fill, (H, W) bool; None without any.

    `margin` is what was rendered beyond the frame of `width` x `height` pixels.
    """
    if camera.distortion.absent:
        return None
    maps = warps(
        camera.distortion, optics, width, height, margin, _sensed_margin(camera, optics, width, height, margin)
    )
    lost = maps.lost if camera.rectified else maps.outside
    return lost if lost.any() else None


def rendered_margin(camera: ColourCamera, optics: Lens, width: int, height: int) -> Sides:
    """Return what has to be rendered beyond the frame so that none of a camera's pixels is lost."""
    return margins(camera.distortion, camera.rectified, optics, width, height)[0]


def _sensed_margin(camera: ColourCamera, optics: Lens, width: int, height: int, margin: Sides) -> Sides:
    """Return the margin of the lens' picture: what its frame's pixels need, or none where none was rendered."""
    if margin == NO_MARGIN:
        return NO_MARGIN
    return margins(camera.distortion, camera.rectified, optics, width, height)[1]


def _warps(camera: ColourCamera, light: PairLight) -> Warps:
    sensed = _sensed_margin(camera, light.optics, *light.size, light.margin)
    return warps(camera.distortion, light.optics, *light.size, light.margin, sensed)


def _falloff(camera: ColourCamera, light: PairLight) -> np.ndarray:
    sensed = _sensed_margin(camera, light.optics, *light.size, light.margin)
    return falloff(camera.distortion, light.optics, *light.size, sensed)


def _control(camera: ColourCamera, light: PairLight, rng: np.random.Generator) -> Control:
    stops = camera.exposure_error * rng.standard_normal()
    low, high = camera.sensor.gain if camera.sensor else (1.0, 1.0)
    return Control(
        exposure=_metered(camera, light) * 2**stops,
        gain=float(low * (high / low) ** rng.random()),
        focus=camera.focus or focused_at(in_frame(light.Z, light.margin)),
    )


def _metered(camera: ColourCamera, light: PairLight) -> float:
    """Return the view's exposure before its error: the scene's, or less where the left picture would be too bright.

    The exposure of a scene is right for its table; a view that is full of a window or of a bright wall needs less.
    """
    if camera.brightest_median is None:
        return light.exposure
    median = light.exposure * float(np.median(in_frame(light.left, light.margin).max(axis=2)))
    return light.exposure * min(1.0, camera.brightest_median / max(median, 1e-9))


def _through_lens(
    camera: ColourCamera, light: PairLight, control: Control, picture: np.ndarray, left: bool
) -> np.ndarray:
    """Return the light that the lens puts on the sensor, (H, W, 3) float32, with the margin of the lens' picture."""
    fx = light.optics[0]
    if camera.aperture:
        Z = light.Z if left else right_depth(light.Z, fx * light.baseline)
        picture = defocused(picture, circle(Z, camera.aperture, control.focus, fx))
    if camera.distortion.absent:
        picture = in_frame(picture, light.margin)
    else:
        picture = _warps(camera, light).distort.applied(picture)
    if camera.falloff:
        picture = picture * _falloff(camera, light) ** np.float32(camera.falloff)
    return picture


def _sensed(
    camera: ColourCamera, light: PairLight, control: Control, picture: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """Return the colours of the sensor, demosaiced and corrected for shading, (H, W, 3) float32."""
    signal = cv2.transform(picture, (to_sensor(camera, light.sensor) * control.exposure).astype(np.float32))
    if camera.sensor is None:
        signal = np.clip(signal, 0, 1)
    else:
        signal = np.minimum(signal, _BRIGHTEST)
        pixels = summed_pixels(camera.sensor, light.size[0])
        if pixels is None:
            signal = demosaiced(exposed(mosaic(signal), camera.sensor, control.gain, rng))
        else:
            signal = exposed(signal, camera.sensor, control.gain, rng, pixels)
    if camera.falloff and camera.shading_correction:
        power = np.float32(-camera.falloff * camera.shading_correction)
        signal = signal * _falloff(camera, light) ** power
    return signal


def _processed(camera: ColourCamera, light: PairLight, gains: np.ndarray, signal: np.ndarray) -> np.ndarray:
    """Return the 8-bit picture of demosaiced colours, (H, W, 3) uint8, the frame."""
    top = min(1.0, float(gains.min()))  # where the first channel saturates: brighter light is white
    balanced = np.clip(signal * (gains / top).astype(np.float32), 0, 1)
    matrix = balanced_matrix(camera, gains, light.sensor).astype(np.float32)
    picture = encoded(cv2.transform(balanced, matrix), camera.contrast)
    if camera.jpeg_quality is not None:
        picture = _compressed(picture, camera.jpeg_quality)
    if camera.rectified and not camera.distortion.absent:
        picture = _warps(camera, light).rectify.applied(picture)
    lost = lost_pixels(camera, light.optics, *light.size, light.margin)
    if lost is not None:
        picture = np.where(lost[..., None], np.uint8(0), picture)
    return picture


def _compressed(picture: np.ndarray, quality: int) -> np.ndarray:
    """Return a picture after JPEG with chroma at half the resolution."""
    done, data = cv2.imencode(".jpg", np.ascontiguousarray(picture[..., ::-1]), [cv2.IMWRITE_JPEG_QUALITY, quality])
    if not done:
        raise ValueError(f"a picture of shape {picture.shape} could not be compressed")
    return np.ascontiguousarray(np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR))[..., ::-1])
