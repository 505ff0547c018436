"""What a build and its workers tell each other: an order once, then scene numbers; a scene's outcome comes back."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Literal

from pydantic import Field

from ...core.errors import InputError
from ...core.model import Model
from ...procedural.scene.settings import SceneSettings
from ...render.frame import LightCheck
from .manifest import Manifest

#: Errors of the output's disk, quota or permissions: no other scene could be written either.
UNWRITABLE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EPERM)


class Order(Model):
    """All that a worker needs to make any scene of a data set."""

    root: Path  #: the data set, absolute
    seed: int
    settings: SceneSettings
    manifest: Manifest  #: the files to draw from, as they must be
    threads: int = Field(ge=1)  #: of each library in the worker
    memory: float | None = None  #: most that a worker may allocate [GiB]; None is no limit


class Machine(Model):
    """Where and with what a worker works."""

    host: str
    process: int
    backend: str
    versions: dict[str, str]


class Attempt(Model):
    """One try at a scene, as it stands in the log."""

    scene: int
    state: Literal["made", "failed", "unwritable"]  #: the last: the output takes no files, so the build ends
    reason: str = ""  #: of a failure, one line
    errno: int = 0  #: of an output that takes no files
    trace: str = ""  #: of an exception
    host: str = ""
    process: int = 0
    served: int = 0  #: how many scenes the process had begun, this one included
    seconds: dict[str, float] = Field(default={})  #: by stage
    total: float = 0.0  #: [s]
    views: int = 0
    spp: float | None = None  #: samples per pixel, mean over pictures
    noise_mean: float | None = None  #: relative error before the denoiser, over the pictures where it is known
    noise_worst: float | None = None
    resident: float = 0.0  #: memory of the process after the scene [MB]
    peak: float = 0.0  #: most memory that it ever had [MB]
    light: LightCheck | None = None


class Refusal(InputError):
    """A wrong request that a worker found; it carries the worker's own line."""

    def __init__(self, line: str) -> None:
        ValueError.__init__(self, line)
