"""The lock of an output folder: one process works in it at a time, and the system frees it when that one dies."""

from __future__ import annotations

import errno
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from .errors import InputError, cause_of

#: The file that is locked, while the folder is. A killed process leaves it behind, unlocked.
LOCK = ".build.lock"
#: Errors of a file system that has no locks.
_NO_LOCKS = (errno.ENOLCK, errno.ENOTSUP, errno.EINVAL, errno.ENOSYS)


@contextmanager
def locked_folder(root: Path, work: str, say: Callable[[str], None]) -> Iterator[None]:
    """Create a folder where it is absent, and lock it; one that is new and stays empty is removed in the end.

    Parameters
    ----------
    root : Path
        The folder.
    work : str
        What is done in it, for lines of text, such as ``build``.
    say : callable
        Takes a line where the file system has no locks.

    Raises
    ------
    InputError
        Where the folder cannot be created or written to, or is locked by another process.
    """
    new = not root.exists()
    # A lock by the mere existence of a file would outlive a killed process.
    lock = FileLock(root / LOCK, fallback_to_soft=False)
    try:
        root.mkdir(parents=True, exist_ok=True)
        _acquire(lock, root, work, say)
    except OSError as error:
        raise InputError(root, "a folder that can be created and written to", cause_of(error)) from error
    try:
        yield
    finally:
        (root / LOCK).unlink(missing_ok=True)
        lock.release()
        if new and not any(root.iterdir()):  # nothing was begun
            root.rmdir()


def _acquire(lock: FileLock, root: Path, work: str, say: Callable[[str], None]) -> None:
    try:
        lock.acquire(blocking=False)
    except Timeout as error:
        raise InputError(root, f"a folder that no other {work} works in", f"another {work}") from error
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise
        say(f"{root}: this file system has no locks; make sure that no other {work} writes here")
