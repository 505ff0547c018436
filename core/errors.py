"""The one kind of error that is the user's to mend."""

from __future__ import annotations


class InputError(ValueError):
    """A request that cannot be carried out: one line that says what, where, expected and found.

    Commands print it and exit with code 2. Anything else that goes wrong is ours and stays a traceback.
    """

    def __init__(self, where: object, expected: str, found: object) -> None:
        super().__init__(_printable(f"{where}: expected {expected}, found {found}"))

    def __reduce__(self) -> tuple[object, ...]:
        """Tell how another process makes the same error of its text."""
        return _of_text, (str(self),)


def _of_text(text: str) -> InputError:
    error = InputError.__new__(InputError)
    ValueError.__init__(error, text)
    return error


def _printable(text: str) -> str:
    """Return a text with escapes for what a terminal would obey or could not show."""
    return "".join(_shown(letter) for letter in text)


def _shown(letter: str) -> str:
    return letter if letter.isprintable() else " " if letter in "\r\n\t" else ascii(letter)[1:-1]
