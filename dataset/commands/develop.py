"""``glassware develop``: the pictures of a data set by another camera."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from time import perf_counter
from typing import Annotated

import tyro
from pydantic import Field
from rich.console import Console

from ...core.errors import InputError
from ...core.exit_codes import run_command
from ...core.model import Model
from ...core.user_text import UserPath, counted
from ..builds.development import develop_dataset, developed_head
from ..builds.output_folder import lock_output
from ..cameras.presets import CAMERAS, colour_camera
from ..format import layout
from ..settings.config import parse_request

_DESCRIPTION = """Develop the radiance of a data set into the pictures of a colour camera.

  glassware build --scenes 0:20 --out data --write radiance
  glassware develop data --camera phone --out data-phone

The new folder is a whole data set: its pictures are developed, all other files are links (copies on another file
system). The first data set does not change. docs/cameras.md says what the cameras do."""


class Develop(Model):
    """The request: which data set, by which camera, and where to."""

    directory: Annotated[UserPath, tyro.conf.Positional] = Field(description="Folder of the data set")
    camera: str = Field(
        default="phone", description=f"One of {', '.join(CAMERAS)}; or a YAML file of your own; phone by default"
    )
    out: UserPath = Field(description="Target folder: absent, empty, or the target of an earlier run")
    seed: int | None = Field(
        default=None, ge=0, description="Seed of the camera's errors and noise; the data set's by default"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    return run_command(lambda: _develop(given))


def _develop(arguments: Sequence[str]) -> None:
    request = parse_request(Develop, arguments, "glassware develop", _DESCRIPTION)
    console = Console()

    def say(line: str) -> None:
        console.print(line, markup=False, highlight=False, soft_wrap=True)

    source, root, camera = request.directory, request.out, colour_camera(request.camera)
    if not (source / layout.DATASET).is_file():
        raise InputError(source, f"the folder of a data set, with {layout.DATASET}", "none")
    if source.resolve() == root.resolve():
        raise InputError("--out", "another folder than the data set's", source)
    head, begun = developed_head(source, root, camera, request.seed), perf_counter()
    with lock_output(root, say):
        views = develop_dataset(source, root, head, lambda _: None)
    each = (perf_counter() - begun) / max(views, 1)
    scenes = counted(len(layout.scene_ids(root)), "scene")
    say(f"{root}: {scenes}, {counted(views, 'view')} by the camera {camera.name}, {each:.2f} s each")


if __name__ == "__main__":
    sys.exit(main())
