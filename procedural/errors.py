"""The one kind of error that is the user's to mend."""

from __future__ import annotations


class InputError(ValueError):
    """A request that cannot be carried out: one line that says what, where, expected and found.

    Commands print it and exit with code 2. Anything else that goes wrong is ours and stays a traceback.
    """

    def __init__(self, where: object, expected: str, found: object) -> None:
        super().__init__(f"{where}: expected {expected}, found {found}")
