"""``glassware predict``: objects and depth in images of your own."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro
from pydantic import Field
from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import run_command
from ...core.model import Model
from ...core.units import ANGLE, LENGTH
from ...core.user_text import UserPath, UserText, counted
from ...dataset.settings.config import parse_request
from .extra import check_extra

if TYPE_CHECKING:
    from ..prediction.predictor import Prediction

_DESCRIPTION = """Find objects in pictures of your own, glass included: box, mask and pose of each, and depth.

  glassware predict base --sample
  glassware predict base left.png right.png --camera d435
  glassware predict out-train/best.safetensors left.png right.png --baseline 65mm --fov 60deg

WEIGHTS is the name of weights that come with glassware (base), or a file: a checkpoint of train. IMAGES are a stereo
pair or more views of one scene; what is found is that of the first. Their camera is a device by its name, or a JSON
file (--camera), or stands beside the pictures: left.json, or camera.json in their folder. OUT gets prediction.png
(what was found, drawn), prediction.json (the objects, with masks as run lengths), and depth.exr [m]. Poses are in
metres with OpenCV's axes. Pictures and cameras that do not fit each other are refused."""

_Metres = Annotated[float, Field(gt=0.0, lt=10.0), LENGTH]
_Radians = Annotated[float, Field(gt=0.0, lt=3.0), ANGLE]


class Predict(Model):
    """Arguments of the command."""

    weights: tyro.conf.Positional[UserPath | None] = Field(
        default=None, description="Weights by their name (base), or a checkpoint"
    )
    images: tyro.conf.Positional[tuple[UserPath, ...]] = Field(
        default=(), description="Images; objects and depth of the first are predicted"
    )
    camera: UserText | None = Field(
        default=None,
        description="Stereo camera of a pair: d415, d435, keypose, syn-todd, zed2, or a JSON file",
    )
    baseline: _Metres | None = Field(default=None, description="Distance of the two cameras of a pair [m]")
    focal: float | None = Field(default=None, gt=0.0, description="Focal length of both cameras of a pair [px]")
    fov: _Radians | None = Field(default=None, description="Horizontal field of view of both [rad]")
    least_score: float = Field(default=0.3, ge=0.0, le=1.0, description="Least score of an object that is reported")
    sample: bool = Field(default=False, description="Take the stereo pair that comes with glassware")
    out: UserPath = Field(default=Path("out-predict"), description="Output folder")
    device: str = Field(default="auto", description="Torch's name of a device, such as cpu or cuda:0; or auto")
    threads: int | None = Field(default=None, ge=1, le=1024, description="CPU threads of torch; all cores by default")
    trust_cameras: bool = Field(
        default=False,
        description="Take cameras and pictures that look wrong: of another unit, other axes, another picture's K, "
        "swapped eyes, a pair that is not rectified",
    )
    config: UserPath | None = Field(default=None, description="YAML file of these settings")


#: For the completion of shells.
REQUEST = Predict


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _predict(given))


def _predict(arguments: Sequence[str]) -> None:
    request = parse_request(Predict, arguments, "glassware predict", _DESCRIPTION)
    if request.weights is None:
        raise InputError("glassware predict", "weights and pictures", "neither")
    check_extra("glassware predict")
    # Loaded here: torch is an extra, and takes longer to load than help should take.
    from ..networks.build import select_device
    from ..prediction.predict import predict, sample_pair
    from ..prediction.rigs import RigOptions

    images = request.images
    if request.sample:
        if images:
            raise InputError("--sample", "no pictures beside it", ", ".join(map(str, images)))
        images = sample_pair()
    device = select_device(request.device, request.threads)
    rig = RigOptions(request.camera, request.baseline, request.focal, request.fov)
    found = predict(
        request.weights,
        images,
        request.out,
        device,
        trust_cameras=request.trust_cameras,
        rig=rig,
        least_score=request.least_score,
    )
    console = Console()

    def say(line: str) -> None:
        console.print(line, markup=False, highlight=False, soft_wrap=True)

    for row in range(len(found)):
        say(_line(found, row))
    if found.left_out:
        say(f"left out: {counted(found.left_out, 'peak')} of the heat map with hardly any pixel")
    objects = counted(len(found), "object") if len(found) else "no objects found"
    say(f"{objects}; written to {request.out}")


def _line(found: Prediction, row: int) -> str:
    """Return a line about an object: what it is, where its middle is, and its sides."""
    kind = "transparent" if found.transparent[row] else "opaque"
    x, y, z = found.camera_T_object[row, :3, 3]
    sides = " x ".join(f"{1e3 * side:.0f}" for side in found.size[row])
    return f"{kind:11} {found.score[row]:.2f}  at ({x:+.3f}, {y:+.3f}, {z:.3f}) m  {sides} mm"


if __name__ == "__main__":
    sys.exit(main())
