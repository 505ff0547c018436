"""Files of a user's folders that are not used, or not as they are: the record, its lines, and how it ends a run.

One bad file does not end a run. `checked_files` looks at each file of a folder once, remembers the outcome between
runs (`remembered`), and returns the usable ones with a `Finding` for each of the others. Findings are shown by
`report` and stored in ``dataset.json``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TypeVar

from pydantic import Field

from .errors import InputError
from .model import Model
from .remembered import Checked, Remembered
from .user_text import counted

#: Most lines that a report has about one folder [1]; ``dataset.json`` has them all.
MOST_LINES = 40

F = TypeVar("F")
#: Is told what is checked, how many files are done and how many there are.
Progress = Callable[[str, int, int], None]


class Finding(Model):
    """What was found about a file of a user's folder: why it is not used, or what of it is not as the file says."""

    folder: str = Field(description="Setting that names the folder, such as mesh_dir")
    path: str = Field(description="Below the folder, with forward slashes")
    reason: str = Field(description="What was expected and found, in one line")
    used: bool = Field(default=False, description="Whether the file is used all the same")

    def __str__(self) -> str:
        """Return one line."""
        return f"{self.folder}: {self.path}: {self.reason}"


def checked_files(
    files: Sequence[F],
    path_of: Callable[[F], Path],
    check: Callable[[F], Checked],
    *,
    folder: str,
    root: Path,
    content: str,
    version: int,
    progress: Progress | None = None,
) -> tuple[tuple[tuple[F, Checked], ...], tuple[Finding, ...]]:
    """Return the files that can be used with what is known of them, and the findings about all files, in their order.

    Parameters
    ----------
    files : sequence
        All files of a kind in a folder.
    path_of : callable
        File -> its path.
    check : callable
        File -> outcome; an InputError that it raises refuses the file. It is called once for each state of a file and
        of the others that the outcome names, also over several runs.
    folder, root : str, Path
        The setting that names the folder, and the folder.
    content : str
        What the folder holds, such as "meshes".
    version : int
        Number of the check; another one forgets what was remembered.
    progress : callable, optional
        See `Progress`.

    Raises
    ------
    InputError
        Where no file can be used.
    """
    memory = Remembered(f"{content}-{version}")
    good, findings = [], []
    for number, file in enumerate(files):
        path = path_of(file)
        outcome = memory.outcome(path, lambda file=file: _outcome(file, check))
        name = path.relative_to(root).as_posix()
        remarks = (_short(text, path, root) for text in outcome.remarks)
        findings += [Finding(folder=folder, path=name, reason=text, used=True) for text in remarks]
        if outcome.refused is None:
            good.append((file, outcome))
        else:
            findings.append(Finding(folder=folder, path=name, reason=_short(outcome.refused, path, root)))
        if progress is not None:
            progress(content, number + 1, len(files))
    memory.save()
    if files and not good:
        first = next(item for item in findings if not item.used)
        raise InputError(root, f"{content} that can be used", f"none in {counted(len(files), 'file')}; {first}")
    return tuple(good), tuple(findings)


def report(findings: Iterable[Finding]) -> list[str]:
    """Return the lines that tell a user about findings: for each folder how many files, then each with its reason."""
    lines = []
    listed = tuple(findings)
    for folder in dict.fromkeys(item.folder for item in listed):
        here = [item for item in listed if item.folder == folder]
        for used, what in ((False, "passed over"), (True, "used with a remark")):
            some = [item for item in here if item.used == used]
            if not some:
                continue
            lines.append(f"{folder}: {counted(len({item.path for item in some}), 'file')} {what}")
            lines += [f"  {item.path}: {item.reason}" for item in some[:MOST_LINES]]
            if len(some) > MOST_LINES:
                lines.append(f"  and {len(some) - MOST_LINES} more, all listed in dataset.json")
    return lines


def check_strict(findings: Iterable[Finding]) -> None:
    """Refuse a run in which a file was passed over; InputError names the first and counts the rest."""
    refused = [item for item in findings if not item.used]
    if refused:
        rest = f" (and {counted(len(refused) - 1, 'more file')})" if len(refused) > 1 else ""
        raise InputError("--strict", "folders of usable files alone", f"{refused[0]}{rest}")


def _outcome(file: F, check: Callable[[F], Checked]) -> Checked:
    try:
        return check(file)
    except InputError as error:
        return Checked(refused=str(error))


def _short(text: str, path: Path, root: Path) -> str:
    """Return a reason without the file's own path, and with other paths below the folder."""
    return text.removeprefix(f"{path}: ").replace(f"{root.absolute()}/", "").replace(f"{root}/", "")
