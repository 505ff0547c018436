"""Trials of a Mitsuba variant in a child process, each made once and remembered in the user's cache folder.

A bad LLVM does not raise: it aborts the process that compiles with it. Only a child can find out.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

from ...core.cache_folder import cache_folder

#: The child's program. It is run by its path, so that it imports nothing of this package.
PROBE = Path(__file__).with_name("probe.py")

#: A trial takes 0.5 s on two cores, on a GPU a few seconds; one that takes longer than this [s] hangs.
_TIMEOUT = 120


def passes(variant: str, environment: Mapping[str, str]) -> bool:
    """Tell whether a child process with these environment variables added compiles and runs the variant right."""
    # A kernel from the disk cache runs without a compiler and would hide a bad one: the trial gets an empty cache.
    with tempfile.TemporaryDirectory(prefix="glassware-trial-") as empty:
        try:
            # -P keeps the program's folder off the module path: it holds modules of ours with common names.
            finished = subprocess.run(
                [sys.executable, "-P", str(PROBE), variant],
                env={**os.environ, **environment, "DRJIT_CACHE_DIR": empty},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=_TIMEOUT,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return False
    return finished.returncode == 0


def library_passes(variant: str, library: Path, environment: Mapping[str, str]) -> bool:
    """Tell the same of a variant that leans on one library file, and remember it if the answer is yes.

    A remembered answer holds for the same file (path, time and size) under the same versions of Dr.Jit and Mitsuba. A
    no is never remembered: what is missing today may be mended tomorrow.
    """
    facts = _facts(variant, library)
    known = _remembered()
    if facts in known:
        return True
    if not passes(variant, environment):
        return False
    _remember([*known, facts])
    return True


def memory_file() -> Path:
    """Return the file that remembers what passed."""
    return cache_folder() / "backend.json"


def _facts(variant: str, library: Path) -> dict[str, object]:
    status = library.stat()
    return {
        "variant": variant,
        "library": str(library.resolve()),
        "mtime_ns": status.st_mtime_ns,
        "size": status.st_size,
        "drjit": version("drjit"),
        "mitsuba": version("mitsuba"),
    }


def _remembered() -> list[object]:
    # The file only saves a trial. Where it is missing, unreadable or of another shape, or there is no home to hold it
    # (RuntimeError), the trial is made again.
    try:
        content = json.loads(memory_file().read_text("utf-8"))
    except (OSError, ValueError, RuntimeError):
        return []
    return content if isinstance(content, list) else []


def _remember(facts: list[object]) -> None:
    try:
        path = memory_file()
        path.parent.mkdir(parents=True, exist_ok=True)
        # Written beside and renamed, so that processes that start together never read half a file.
        with tempfile.NamedTemporaryFile("w", encoding="utf-8", dir=path.parent, delete=False) as file:
            json.dump(facts, file, indent=2, sort_keys=True)
        Path(file.name).replace(path)
    except (OSError, RuntimeError):
        # No home, or one that cannot be written, costs a trial of half a second in each process, and nothing else.
        return
