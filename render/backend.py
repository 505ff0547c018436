"""Choose a Mitsuba variant that works on this machine, and set it. No other module sets the variant.

A wrong LLVM does not raise: it aborts the process. So each candidate is tried once in a child process
(`glassware.render.probe`), and a good result is remembered in the user's cache folder.
"""

from __future__ import annotations

import ctypes.util
import functools
import json
import os
import subprocess
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

import drjit as dr
import mitsuba as mi
from rich.console import Console

from ..procedural.errors import InputError
from .llvm import OLDEST, installed_libraries

#: The reference for reproducibility: pictures and labels are compared on this variant.
LLVM = "llvm_ad_rgb"
#: Used when the machine has a CUDA device.
CUDA = "cuda_ad_rgb"

#: Dr.Jit reads the path of its LLVM library from here, when the first LLVM variant is set.
LLVM_PATH = "DRJIT_LIBLLVM_PATH"

INSTALL_HINT = "install one and run again (Debian or Ubuntu: apt-get install libllvm19)"

#: A trial takes 0.5 s on two cores; one that takes longer than this [s] hangs.
_PROBE_TIMEOUT = 120

#: Mitsuba's EXR reader waits for a second thread, and there is none where the process may use one core: it deadlocks
#: (measured with `taskset -c 0`). Two threads on one core render at the speed of one (7.9 s against 7.8 s measured).
_LEAST_THREADS = 2


def activate(variant: str | None = None) -> str:
    """Set a Mitsuba variant that has been proven to work here; safe to call again.

    Parameters
    ----------
    variant : str, optional
        A name such as ``"llvm_ad_rgb"``. By default the one that is active already; else `CUDA` where a device works,
        else `LLVM`.

    Returns
    -------
    str
        The variant that is now active.

    Raises
    ------
    InputError
        If Mitsuba has no such variant, or the machine lacks what it needs: the message says what to install.
    """
    chosen = variant or mi.variant() or (CUDA if cuda_works() else LLVM)
    if chosen not in mi.variants():
        raise InputError("backend", "one of " + ", ".join(mi.variants()), repr(chosen))
    if chosen == mi.variant():
        return chosen
    if chosen.startswith("llvm"):
        os.environ[LLVM_PATH] = str(find_llvm())
    if chosen.startswith("cuda") and not cuda_works():
        raise InputError("backend", f"a working NVIDIA driver and device for {chosen}", "none")
    mi.set_variant(chosen)
    dr.set_thread_count(max(dr.thread_count(), _LEAST_THREADS))
    return chosen


def find_llvm() -> Path:
    """Return an LLVM library that compiles and runs a trial right.

    Raises
    ------
    InputError
        If ``DRJIT_LIBLLVM_PATH`` names a library that does not work, or no installed library does.
    """
    named = os.environ.get(LLVM_PATH)
    if named:
        if not Path(named).is_file():
            raise InputError(LLVM_PATH, "the path of an LLVM library", f"no file {named}")
        if not _llvm_works(Path(named)):
            expected = f"an LLVM library of version {OLDEST} or newer that Dr.Jit can compile with"
            raise InputError(LLVM_PATH, expected, f"{named}, which fails; unset it or {INSTALL_HINT}")
        return Path(named)
    tried = []
    for library in installed_libraries():
        if _llvm_works(library):
            return library
        tried.append(str(library))
    found = f"only {', '.join(tried)}, which fail" if tried else "none"
    raise InputError("backend", f"an LLVM library of version {OLDEST} or newer", f"{found}; {INSTALL_HINT}")


@functools.cache
def cuda_works() -> bool:
    """Tell whether a CUDA device compiles and runs a trial right.

    Devices come and go with the container and ``CUDA_VISIBLE_DEVICES``, so the answer is kept for this process only.
    """
    driver = os.environ.get("DRJIT_LIBCUDA_PATH") or ctypes.util.find_library("cuda")
    return bool(driver or Path("/usr/lib/wsl/lib/libcuda.so.1").exists()) and _trial(CUDA, {})


def cache_file() -> Path:
    """Return the file that remembers which LLVM libraries work."""
    root = os.environ.get("XDG_CACHE_HOME")
    # The XDG base directory specification: a relative path is to be ignored.
    base = Path(root) if root and Path(root).is_absolute() else Path.home() / ".cache"
    return base / "glassware" / "backend.json"


def _llvm_works(library: Path) -> bool:
    facts = _facts(library)
    known = _remembered()
    if facts in known:
        return True
    if not _trial(LLVM, {LLVM_PATH: str(library)}):
        return False
    _remember([*known, facts])
    return True


def _facts(library: Path) -> dict[str, object]:
    # What decides whether a library works: the file itself, and who compiles with it.
    status = library.stat()
    return {
        "library": str(library.resolve()),
        "mtime_ns": status.st_mtime_ns,
        "size": status.st_size,
        "drjit": version("drjit"),
        "mitsuba": version("mitsuba"),
    }


def _trial(variant: str, environment: dict[str, str]) -> bool:
    # A kernel from the disk cache runs without a compiler and would hide a bad one: the trial gets an empty cache.
    with tempfile.TemporaryDirectory(prefix="glassware-trial-") as empty:
        try:
            # -P keeps the working folder off the module path.
            finished = subprocess.run(
                [sys.executable, "-P", "-m", "glassware.render.probe", variant],
                env={**os.environ, **environment, "DRJIT_CACHE_DIR": empty},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=_PROBE_TIMEOUT,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return False
    return finished.returncode == 0


def _remembered() -> list[dict[str, object]]:
    # The file only saves a trial. Where it is missing, unreadable or of another shape, the trial is made again.
    try:
        content = json.loads(cache_file().read_text("utf-8"))
    except (OSError, ValueError):
        return []
    return content if isinstance(content, list) else []


def _remember(works: list[dict[str, object]]) -> None:
    path = cache_file()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Written beside and renamed, so that processes that start together never read half a file.
        with tempfile.NamedTemporaryFile("w", encoding="utf-8", dir=path.parent, delete=False) as file:
            json.dump(works, file, indent=2, sort_keys=True)
        Path(file.name).replace(path)
    except OSError:
        # A home that cannot be written costs a trial of half a second each time, and nothing else.
        return


def main() -> int:
    """Set the variant and say what was chosen; 2 and one line where nothing works."""
    try:
        chosen = activate()
    except InputError as error:
        Console(stderr=True).print(str(error), markup=False, highlight=False, soft_wrap=True)
        return 2
    with_llvm = f" with {os.environ[LLVM_PATH]}" if chosen.startswith("llvm") else ""
    Console().print(f"{chosen}{with_llvm}, {dr.thread_count()} threads", markup=False, highlight=False, soft_wrap=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
