"""Set up the environment ``.venv``: ``python3 .ci/set_up.py pictures`` or ``everything``.

Run by `make`, with the standard library alone. Each step is a line on the terminal, each package of more than a
megabyte another; what pip says goes to ``.venv/set-up.log``. A run that was stopped goes on when it is started again.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter

REPOSITORY = Path(__file__).resolve().parents[1]
VENV = REPOSITORY / ".venv"
PYTHON = VENV / "bin" / "python"
LOG = VENV / "set-up.log"
#: There while packages are written: a run that finds it was preceded by one that was stopped.
UNFINISHED = VENV / ".unfinished"
#: Stamp file of each environment. `make` compares their times with those of pyproject.toml and constraints.txt.
STAMPS = {"pictures": VENV / ".pictures", "everything": VENV / ".installed"}

#: What each environment holds: requirement and words. Sizes were measured on Linux x86-64 with Python 3.11.
CONTENTS = {
    "pictures": (
        ".",
        "what pictures need (mitsuba, pyoidn, pyarrow, scipy, opencv, numpy): 0.36 GB of downloads, 1.1 GB on disk",
    ),
    "everything": (
        ".[dev]",
        "what pictures, networks (torch), clusters (ray) and tests need: 0.75 GB of downloads, 2.5 GB on disk in all",
    ),
}
#: What a build of torch for CUDA makes of it.
CUDA_SIZE = "CUDA's libraries: 6 GB on disk in all"
#: Packages that a build of torch for CUDA requires.
CUDA = re.compile(r"^(nvidia-|cuda-|triton)", re.MULTILINE)
#: A package on its way, as pip prints it: its file and its size.
FETCHED = re.compile(
    r"\s+(?:Downloading|Using cached) ([^\s/]+?)-(\d[^-\s]*)[^\s]*\.(?:whl|tar\.gz) \(([\d.]+) ([kMG])B\)"
)
#: Units of such a size [MB].
SIZES = {"k": 1e-3, "M": 1.0, "G": 1e3}
#: Smallest package that gets a line of its own [MB].
SMALLEST = 1.0
#: Lines of pip that are printed where it fails.
SHOWN = 15


def main() -> int:
    """Set up the environment that the first argument names; return 0, or 1 where pip failed."""
    name = sys.argv[1]
    start = perf_counter()
    requirement, contents = CONTENTS[name]
    say(f"[1/3] {environment()}")
    say(f"[2/3] fetching {contents}")
    remove_unfinished()
    UNFINISHED.touch()
    if name == "everything":
        torch = torch_requirement()
        index = os.environ.get("TORCH_INDEX", "")
        if index:
            pip("install", "--index-url", index, torch)
        elif brings_cuda(torch) and not shutil.which("nvidia-smi"):
            say(f"      torch comes with {CUDA_SIZE}. No CUDA device is here: for the build of torch for processors,")
            say("      stop this (Ctrl-C) and run it again with TORCH_INDEX=ADDRESS, where ADDRESS is the index that")
            say('      PyTorch\'s page "Get started" shows behind --index-url for the platform CPU')
    pip("install", "--editable", requirement)
    UNFINISHED.unlink()
    STAMPS["pictures"].touch()
    STAMPS[name].touch()
    say(f"      .venv is ready after {perf_counter() - start:.0f} s, {size(VENV) / 1e9:.2f} GB")
    return 0


def environment() -> str:
    """Make the virtual environment unless it is there and whole; return what was done."""
    version = ".".join(map(str, sys.version_info[:3]))
    if PYTHON.exists():
        works = subprocess.run([PYTHON, "-m", "pip", "--version"], capture_output=True, check=False).returncode == 0
        if works:
            return ".venv is there"
    subprocess.run([sys.executable, "-m", "venv", "--clear", VENV], check=True)
    return f".venv made for Python {version}"


def remove_unfinished() -> None:
    """Remove the records of packages that a stopped run left incomplete, so that pip writes them again."""
    if not UNFINISHED.exists():
        return
    for site in VENV.glob("lib/python*/site-packages"):
        for record in site.glob("*.dist-info"):
            if not (record / "RECORD").is_file():  # pip writes it last
                shutil.rmtree(record)
        for leftover in site.glob("~*"):  # pip renames what it is about to replace
            shutil.rmtree(leftover, ignore_errors=True)
    say("      an earlier run was stopped: going on with what is there")


def torch_requirement() -> str:
    """Return the exact version of torch that pyproject.toml has."""
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["project"]
    return next(item for item in project["optional-dependencies"]["learn"] if item.startswith("torch=="))


def brings_cuda(torch: str) -> bool:
    """Return whether pip would install a build of torch for CUDA; False where it cannot say."""
    command = [PYTHON, "-m", "pip", "install", "--dry-run", "--quiet", "--report", "-", *COMMON, torch]
    found = subprocess.run(command, capture_output=True, text=True, check=False, cwd=REPOSITORY)
    names = re.findall(r'"name": "([^"]+)"', found.stdout)
    return bool(CUDA.search("\n".join(names)))


COMMON = ("--disable-pip-version-check", "--no-input", "--constraint", "constraints.txt")


def pip(*arguments: str) -> None:
    """Run pip, with a line for each package on its way; exit with its last lines where it fails."""
    command = [PYTHON, "-m", "pip", arguments[0], "--progress-bar", "off", *COMMON, *arguments[1:]]
    last: deque[str] = deque(maxlen=SHOWN)
    with (
        LOG.open("a", encoding="utf-8") as log,
        subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", cwd=REPOSITORY
        ) as process,
    ):
        assert process.stdout is not None
        for line in process.stdout:
            log.write(line)
            last.append(line.rstrip())
            for shown in progress(line):
                say(shown)
    if process.returncode:
        errors = [line for line in last if "WARNING: Location" not in line]
        say("\n".join(["pip failed; run the same command again to go on. Its last lines:", *errors]))
        sys.exit(1)


def progress(line: str) -> Iterator[str]:
    """Yield what a line of pip means for the terminal, if anything."""
    match = FETCHED.match(line)
    if match and float(match[3]) * SIZES[match[4]] >= SMALLEST:
        yield f"      {match[1]} {match[2]} ({match[3]} {match[4]}B)"
    elif line.startswith("Installing collected packages:"):
        yield f"[3/3] writing {line.count(',') + 1} packages into .venv, about half a minute"


def size(folder: Path) -> int:
    """Return what the files of a folder take [bytes]."""
    return sum(path.lstat().st_size for path in folder.rglob("*"))


def say(line: str) -> None:
    """Print a line at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        say("stopped; the same command goes on from here")
        sys.exit(130)
