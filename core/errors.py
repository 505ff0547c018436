"""The error class for invalid input."""

from __future__ import annotations


class InputError(ValueError):
    """Invalid input: one line of the form ``where: expected ..., found ...``.

    Commands print it and exit with code 2. Every other exception is a bug of ours and shows its traceback.
    """

    def __init__(self, where: object, expected: str, found: object) -> None:
        super().__init__(_printable(f"{where}: expected {expected}, found {found}"))

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle as the message alone, so that the error passes between processes."""
        return _of_text, (str(self),)


def cause_of(error: OSError) -> str:
    """Return why a file or folder cannot be used, as an error line says it."""
    if isinstance(error, FileNotFoundError):
        return "none"
    if isinstance(error, IsADirectoryError):
        return "a folder"
    if isinstance(error, NotADirectoryError):
        return "a file where a folder should be"
    return (error.strerror or str(error)).lower()


def _of_text(text: str) -> InputError:
    error = InputError.__new__(InputError)
    ValueError.__init__(error, text)
    return error


def _printable(text: str) -> str:
    """Return a text with control and unprintable characters escaped."""
    return "".join(_shown(letter) for letter in text)


def _shown(letter: str) -> str:
    return letter if letter.isprintable() else " " if letter in "\r\n\t" else ascii(letter)[1:-1]
