"""Messages between a build and its workers: the worker's configuration, and the outcome of each scene."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Literal

from pydantic import Field

from ...core.errors import InputError
from ...core.model import Model
from ...procedural.scene.settings import SceneSettings
from ...render.frame import LightCheck
from ..format.file_kinds import KINDS, FileKinds
from .manifest import Manifest

#: Errors of the output's disk, quota or permissions: no other scene could be written either.
UNWRITABLE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EPERM)

#: Outcome of an attempt. "unwritable": the output accepts no files, so the build ends.
AttemptState = Literal["made", "failed", "unwritable"]


class WorkerConfig(Model):
    """Everything that a worker needs to render any scene of a data set."""

    root: Path  #: the data set, absolute
    seed: int
    settings: SceneSettings
    files: FileKinds = KINDS  #: of each view, beside those that every view has
    manifest: Manifest  #: the asset files, with their expected content
    threads: int = Field(ge=1)  #: of each library in the worker
    memory: float | None = None  #: limit on what a worker may allocate [GiB]; None is no limit


class WorkerInfo(Model):
    """Where a worker runs, and with which software."""

    host: str
    process: int
    backend: str
    versions: dict[str, str]


class Attempt(Model):
    """One attempt at a scene, as the log has it."""

    scene: int
    state: AttemptState
    reason: str = ""  #: of a failure, one line
    errno: int = 0  #: where the output accepts no files
    trace: str = ""  #: of an exception
    host: str = ""
    process: int = 0
    served: int = 0  #: scenes that the process had begun, this one included
    seconds: dict[str, float] = Field(default={})  #: by stage
    total: float = 0.0  #: [s]
    views: int = 0
    spp: float | None = None  #: samples per pixel, mean over pictures
    noise_mean: float | None = None  #: relative error before the denoiser, over the pictures where it is known
    noise_worst: float | None = None
    resident: float = 0.0  #: memory of the process after the scene [MB]
    peak: float = 0.0  #: peak memory of the process [MB]
    light: LightCheck | None = None


class WorkerMessage(Model):
    """One message of a worker; one of the fields is set."""

    ready: WorkerInfo | None = None  #: it can take scenes
    view: int | None = None  #: views of the current scene that are done
    attempt: Attempt | None = None  #: the outcome of the current scene
    error: str | None = None  #: an asset is missing or has changed, one line


class WorkerInputError(InputError):
    """A wrong request that a worker found; it carries the worker's own line."""

    def __init__(self, line: str) -> None:
        ValueError.__init__(self, line)
