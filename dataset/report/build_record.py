"""What the log of a build says: attempts, failures, and the time of each stage."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ..builds.build_log import attempts
from ..builds.messages import Attempt


@dataclass(frozen=True)
class BuildRecord:
    """The attempts at the scenes of a data set."""

    attempts: int  #: all of them
    made: int  #: scenes whose last attempt made them
    again: int  #: of these, those that an earlier attempt had failed
    failed: Mapping[int, str]  #: reason by scene, where the last attempt failed
    stages: Mapping[str, float]  #: seconds by stage, over the scenes that were made
    seconds: tuple[float, ...]  #: of each scene that was made
    peak: float  #: highest memory of a process [MB]
    hosts: int  #: machines


@dataclass(frozen=True)
class _Last:
    """The last attempt at a scene, without what would fill memory: traces, and the check of its irradiance cache."""

    number: int
    state: str
    reason: str
    total: float
    seconds: Mapping[str, float]


def build_record(root: Path) -> BuildRecord | None:
    """Return what the log says, read line by line; None where no attempt is in it, as `render-scene` writes none."""
    last: dict[int, _Last] = {}
    count, peak, hosts = 0, 0.0, set()
    for attempt in attempts(root):
        last[attempt.scene] = _kept(attempt, last.get(attempt.scene))
        count, peak = count + 1, max(peak, attempt.peak)
        hosts.add(attempt.host)
    if not last:
        return None
    made = [one for one in last.values() if one.state == "made"]
    stages: dict[str, float] = defaultdict(float)
    for one in made:
        for stage, seconds in one.seconds.items():
            stages[stage] += seconds
    return BuildRecord(
        attempts=count,
        made=len(made),
        again=sum(one.number > 1 for one in made),
        failed={scene: one.reason for scene, one in sorted(last.items()) if one.state != "made"},
        stages=dict(stages),
        seconds=tuple(one.total for one in made),
        peak=peak,
        hosts=len(hosts),
    )


def _kept(attempt: Attempt, before: _Last | None) -> _Last:
    number = before.number + 1 if before is not None and before.state != "made" else 1
    return _Last(number, attempt.state, attempt.reason, attempt.total, attempt.seconds)
