"""``glassware predict``: objects and depth in images of your own."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import tyro
from pydantic import Field
from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import run_command
from ...core.model import Model
from ...core.user_text import UserPath
from ...dataset.settings.config import parse_request
from .extra import check_extra

_DESCRIPTION = """Find objects in pictures of your own, glass included: box, mask and pose of each, and depth.

  glassware predict out-train/best.safetensors left.png right.png --out out-predict

IMAGES are two or more views of one scene; what is predicted is that of the first. The camera of left.png is in
left.json (K and world_T_camera, as in camera.json), or in the camera.json of its folder. OUT gets prediction.json (the
objects, with masks as run lengths), prediction.png (what was found, drawn), and depth.exr [m]. Poses are in metres with
OpenCV's axes; suspicious ones are refused."""


class Predict(Model):
    """Arguments of the command."""

    checkpoint: tyro.conf.Positional[UserPath | None] = Field(default=None, description="Checkpoint of a network")
    images: tyro.conf.Positional[tuple[UserPath, ...]] = Field(
        default=(), description="Images; objects and depth of the first are predicted"
    )
    out: UserPath = Field(default=Path("out-predict"), description="Output folder")
    device: str = Field(default="auto", description="Torch's name of a device, such as cpu or cuda:0; or auto")
    threads: int | None = Field(default=None, ge=1, le=1024, description="CPU threads of torch; all cores by default")
    trust_cameras: bool = Field(
        default=False, description="Take cameras that look wrong: of another unit, other axes, or another picture's K"
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
    if request.checkpoint is None:
        raise InputError("glassware predict", "a checkpoint and pictures", "neither")
    check_extra("glassware predict")
    # Loaded here: torch is an extra, and takes longer to load than help should take.
    from ..evaluation.predict import predict
    from ..networks.build import select_device

    device = select_device(request.device, request.threads)
    found = predict(request.checkpoint, request.images, request.out, device, request.trust_cameras).objects
    console = Console()
    console.print(f"{len(found)} objects; written to {request.out}", markup=False, highlight=False, soft_wrap=True)


if __name__ == "__main__":
    sys.exit(main())
