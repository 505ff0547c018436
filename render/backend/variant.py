"""Choose a Mitsuba variant that works on this machine, and set it. No other module sets the variant."""

from __future__ import annotations

import ctypes.util
import functools
import os
import sys
from pathlib import Path

from rich.console import Console

from ...core.errors import InputError
from .llvm import LLVM, LLVM_PATH, OLDEST, find_llvm
from .trial import passes

#: What a user does whose processes are forked.
SPAWN = 'start processes with the "spawn" method (multiprocessing.get_context("spawn"))'
#: Used when the machine has a CUDA device.
CUDA = "cuda_ad_rgb"

#: Mitsuba's EXR reader waits for a second thread. A process that may use one core has none, and deadlocks
#: (measured with `taskset -c 0`). Two threads on one core cost nothing there: one picture took 7.8 s with either.
_LEAST_THREADS = 2

#: The process in which `activate` started the backend; None before.
_started_in: int | None = None


def check_process() -> None:
    """Refuse a process that was forked after the backend had started: its threads are not there, so it would hang.

    Raises
    ------
    InputError
        With what to do instead.
    """
    if _started_in not in (None, os.getpid()):
        found = f"process {os.getpid()}, forked from process {_started_in} in which the backend runs"
        raise InputError("backend", f"a process of its own; {SPAWN}", found)


def check_colours(variant: str, spectral: bool) -> None:
    """Raise InputError for a variant whose colours are not those that a scene asks for; monochrome ones are taken."""
    if ("spectral" in variant) != spectral and "mono" not in variant:
        kind, state = ("a spectral", "on") if spectral else ("an RGB", "off")
        raise InputError("variant", f"{kind} variant, as picture.spectral is {state}", variant)


def activate(variant: str | None = None, spectral: bool | None = None, threads: int | None = None) -> str:
    """Set a Mitsuba variant that has been proven to work here; safe to call again.

    Parameters
    ----------
    variant : str, optional
        A name such as ``"llvm_ad_rgb"``. By default the one that is active already; else `CUDA` where a device works,
        else `LLVM`.
    spectral : bool, optional
        Whether the default is to have wavelengths instead of red, green and blue; None does not mind.
    threads : int, optional
        Threads that the processor's kernels may use; by default one a core. Pictures do not depend on it.

    Returns
    -------
    str
        The variant that is now active.

    Raises
    ------
    InputError
        If Mitsuba has no such variant, or the machine lacks what it needs: the message says what to install. Also in a
        process that was forked after the backend had started.
    """
    global _started_in
    check_process()
    chosen = variant or _coloured(_active() or (CUDA if cuda_works() else LLVM), spectral)
    if chosen == _active():
        return chosen
    # Before the imports below, so that a missing library is one clear line and not a line of Dr.Jit's as well.
    if chosen.startswith("llvm"):
        os.environ[LLVM_PATH] = str(find_llvm())
    if chosen.startswith("cuda") and not cuda_works():
        raise InputError("backend", f"an NVIDIA driver and device that work, for {chosen}", "none")

    import drjit as dr
    import mitsuba as mi

    # The ray loops are Dr.Jit kernels: Mitsuba's scalar variants have none.
    possible = [name for name in mi.variants() if not name.startswith("scalar")]
    if chosen not in possible:
        raise InputError("backend", "one of " + ", ".join(possible), repr(chosen))
    loaded = dr.detail.llvm_version()[0]
    if chosen.startswith("llvm") and loaded < OLDEST:
        found = (
            f"drjit imported before it, with LLVM {loaded}" if loaded > 0 else "drjit imported before it, without LLVM"
        )
        raise InputError("backend", f"glassware.render imported first, or {LLVM_PATH} set", found)
    mi.set_variant(chosen)
    _started_in = os.getpid()
    dr.set_thread_count(max(threads or dr.thread_count(), _LEAST_THREADS))
    return chosen


def _coloured(variant: str, spectral: bool | None) -> str:
    backend = variant.split("_")[0]
    return variant if spectral is None else f"{backend}_ad_{'spectral' if spectral else 'rgb'}"


@functools.cache
def cuda_works() -> bool:
    """Tell whether a CUDA device compiles and runs a trial right.

    Devices come and go with the container and ``CUDA_VISIBLE_DEVICES``, so the answer is kept for this process only.
    """
    # Where Dr.Jit looks: the variable, the dynamic linker, and Windows' driver under WSL.
    driver = os.environ.get("DRJIT_LIBCUDA_PATH") or ctypes.util.find_library("cuda")
    return bool(driver or Path("/usr/lib/wsl/lib/libcuda.so.1").exists()) and passes(CUDA, {})


def _active() -> str | None:
    mitsuba = sys.modules.get("mitsuba")
    return mitsuba.variant() if mitsuba else None


def main() -> int:
    """Set the variant and say what was chosen; 2 and one line where nothing works."""
    try:
        chosen = activate()
    except InputError as error:
        Console(stderr=True).print(str(error), markup=False, highlight=False, soft_wrap=True)
        return 2
    library = f" with {os.environ[LLVM_PATH]}" if chosen == LLVM else ""
    Console().print(chosen + library, markup=False, highlight=False, soft_wrap=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
