"""Find an LLVM library that works. Dr.Jit itself takes the first one it meets, good or not.

Dr.Jit loads its LLVM when `drjit` is imported (not when a variant is set) and cannot change it afterwards. So the
choice is made when `glassware.render` is imported, before any of its modules imports drjit.
"""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path

from ...core.errors import InputError
from .trial import library_passes

#: The variant on LLVM, and the reference for reproducibility.
LLVM = "llvm_ad_rgb"

#: Dr.Jit reads the path of its LLVM library from here.
LLVM_PATH = "DRJIT_LIBLLVM_PATH"

_INSTALL = "install one and run again (Debian or Ubuntu: apt-get install libllvm19)"

#: Newest and oldest major versions looked for. 14 is refused by Dr.Jit 1.5, 15 and 16 abort the process while compiling
#: (measured: "Cannot select: fminimum"); 19 and 22 are known to work. What is found is tried out before it is used.
NEWEST, OLDEST = 23, 17

#: Folders that hold shared libraries on Debian, Ubuntu, Fedora, Arch and macOS with Homebrew, after the linker's own.
STANDARD_FOLDERS = (
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/usr/lib/llvm-*/lib",
    "/usr/lib64",
    "/usr/lib64/llvm*/lib",
    "/usr/lib",
    "/usr/local/lib",
    "/opt/homebrew/opt/llvm*/lib",
    "/usr/local/opt/llvm*/lib",
    "/home/linuxbrew/.linuxbrew/opt/llvm*/lib",
)

#: File names that carry the major version, such as libLLVM.so.19.1, and libLLVM-17.so.1 or libLLVM-19.dylib.
_VERSIONED = re.compile(r"libLLVM(?:\.so\.(\d+)[.\d]*|-(\d+)[.\d]*\.(?:so[.\d]*|dylib))")

#: The linker's cache is read in milliseconds; a listing that takes longer than this [s] is stuck.
_LDCONFIG_TIMEOUT = 20


def export_llvm_path() -> None:
    """Point Dr.Jit at a library that works, unless the user has named one; `find_llvm` says later if there is none."""
    if not os.environ.get(LLVM_PATH):
        library, _ = _first_that_works()
        if library:
            os.environ[LLVM_PATH] = str(library)


def find_llvm() -> Path:
    """Return the library the user has named in ``DRJIT_LIBLLVM_PATH``, else the newest one that works.

    Raises
    ------
    InputError
        If the named library does not work, or no installed one does: the message says what to install.
    """
    named = os.environ.get(LLVM_PATH)
    if named and not Path(named).is_file():
        raise InputError(LLVM_PATH, "the path of an LLVM library", f"no file {named}; unset it, or {_INSTALL}")
    if named and not _works(Path(named)):
        expected = f"an LLVM library of version {OLDEST} or newer"
        raise InputError(LLVM_PATH, expected, f"{named}, which does not work; unset it, or {_INSTALL}")
    if named:
        return Path(named)
    library, refused = _first_that_works()
    if library is None:
        found = f"only {', '.join(map(str, refused))}, which do not work" if refused else "none"
        raise InputError("backend", f"an LLVM library of version {OLDEST} or newer", f"{found}; {_INSTALL}")
    return library


def _first_that_works() -> tuple[Path | None, list[Path]]:
    refused = []
    for library in installed_libraries():
        if _works(library):
            return library, refused
        refused.append(library)
    return None, refused


def _works(library: Path) -> bool:
    return library_passes(LLVM, library, {LLVM_PATH: str(library)})


def compiler_version() -> str:
    """Return the version of the LLVM that Dr.Jit has loaded, such as 19.1.7, or "none"."""
    import drjit as dr

    version = dr.detail.llvm_version()
    return ".".join(map(str, version)) if version[0] > 0 else "none"


def major_version(library: Path) -> int | None:
    """Return the major version that a library's file name states, or None where it states none."""
    match = _VERSIONED.fullmatch(library.name)
    return int(match[1] or match[2]) if match else None


def installed_libraries(folders: Iterable[Path] | None = None) -> list[Path]:
    """Return the LLVM libraries of versions `OLDEST` to `NEWEST`, newest first, each real file once.

    Parameters
    ----------
    folders : iterable of Path, optional
        Where to look. By default ``LD_LIBRARY_PATH``, what the dynamic linker knows, and `STANDARD_FOLDERS`.
    """
    found: dict[Path, Path] = {}
    for folder in library_folders() if folders is None else folders:
        for library in sorted(folder.glob("libLLVM*")):
            version = major_version(library)
            if version is not None and OLDEST <= version <= NEWEST and library.is_file():
                found.setdefault(library.resolve(), library)
    return sorted(found.values(), key=lambda library: -(major_version(library) or 0))


def library_folders() -> list[Path]:
    """Return the folders to search, in order, each once."""
    folders = [Path(entry) for entry in os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep) if entry]
    folders += [library.parent for library in _known_to_the_linker()]
    for pattern in STANDARD_FOLDERS:
        # Path.glob takes relative patterns only.
        folders += sorted(Path("/").glob(pattern.lstrip("/")))
    return [folder for folder in dict.fromkeys(folders) if folder.is_dir()]


def _known_to_the_linker() -> Iterator[Path]:
    # An ordinary user's PATH often lacks /sbin.
    for program in ("/sbin/ldconfig", "/usr/sbin/ldconfig"):
        if Path(program).exists():
            listing = subprocess.run(
                [program, "-p"], capture_output=True, text=True, timeout=_LDCONFIG_TIMEOUT, check=False
            )
            for line in listing.stdout.splitlines():
                name, arrow, path = line.partition(" => ")
                if arrow and name.strip().startswith("libLLVM"):
                    yield Path(path.strip())
            return
