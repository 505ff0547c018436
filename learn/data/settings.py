"""Settings of samples: their views, and the augmentation of their images."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ...core.model import Model, Ordered
from ..networks.settings import SIZE_MULTIPLE

_Side = Annotated[int, Field(ge=SIZE_MULTIPLE, le=8192, multiple_of=SIZE_MULTIPLE)]
_Zoom = Annotated[float, Field(ge=1.0, le=8.0)]
#: Depth at which both pictures of a pair are cut to show the same [m].
Convergence = Annotated[float, Field(gt=0.0, le=1000.0)]
_Probability = Annotated[float, Field(ge=0.0, le=1.0)]


class ViewSettings(Model):
    """The views of a sample: a reference view, and source views near it."""

    count: int = Field(default=2, ge=2, le=57, description="Views of a sample, with the reference")
    rule: Literal["grid", "distance", "stereo"] = Field(
        default="distance",
        description="Source views. grid: neighbours of the reference in the 57-view grid, as in the paper; distance: "
        "of the nearest cameras; stereo: the right camera of the reference",
    )
    pool: int = Field(
        default=8, ge=1, le=56, description="With distance, how many of the nearest cameras sources are drawn from"
    )
    convergence: Convergence | None = Field(
        default=None,
        description="With stereo, the depth at which both pictures of a pair are cut to show the same, as of cameras "
        "with moved principal points [m]; null: whole pictures, of which the left part has no match",
    )
    size: tuple[_Side, _Side] | None = Field(
        default=None, description="Height and width that images are resized to, multiples of 32 [px]; null: as stored"
    )
    fit: Literal["letterbox", "stretch"] = Field(
        default="letterbox",
        description="Images of another shape than size: letterbox keeps theirs, with a grey border; stretch fills size",
    )


class AugmentSettings(Model):
    """Ranges of the image augmentation; the defaults are those of a simple camera."""

    probability: _Probability = Field(default=1.0, description="Probability that a sample is augmented")
    flip: _Probability = Field(default=0.5, description="Probability of the mirror image, with mirrored cameras")
    zoom: Annotated[tuple[_Zoom, _Zoom], Ordered] = Field(
        default=(1.0, 1.3),
        description="Range of the picture's width over that of the window that is used: other focal lengths and "
        "principal points, the same for all views of a sample",
    )
    hue: float = Field(default=0.1, ge=0.0, le=3.2, description="Greatest turn of all colours about grey [rad]")
    exposure: float = Field(default=0.7, ge=0.0, le=4.0, description="Greatest change of exposure [stops]")
    balance: float = Field(
        default=0.15, ge=0.0, le=1.0, description="Greatest change of the red and blue gain, white balance [stops]"
    )
    view_exposure: float = Field(
        default=0.1, ge=0.0, le=1.0, description="Greatest difference in exposure of each view [stops]"
    )
    shot_noise: float = Field(
        default=0.01, ge=0.0, le=0.2, description="Greatest standard deviation of shot noise at white"
    )
    read_noise: float = Field(default=0.005, ge=0.0, le=0.1, description="Greatest standard deviation of read noise")
    blur: float = Field(default=0.8, ge=0.0, le=5.0, description="Greatest standard deviation of a Gaussian blur [px]")
    jpeg: Annotated[tuple[Annotated[int, Field(ge=10, le=100)], Annotated[int, Field(ge=10, le=100)]], Ordered] = Field(
        default=(70, 100), description="Range of the JPEG quality"
    )
