"""Text from users, which must fit file systems and JSON files, and counts in text for them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator

#: Longest name of a file, and longest path that still leaves room for what is written below it [bytes]: Linux, macOS
#: and Windows all end names at 255, and Linux ends paths at 4096.
LONGEST_NAME, LONGEST_PATH = 255, 3584


def counted(count: int, noun: str) -> str:
    """Return a number with its noun, such as ``1 view`` or ``2 views``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def sized(count: float) -> str:
    """Return a number of bytes in words: ``2.3 MB`` or ``1.25 GB``."""
    for unit, scale in (("TB", 1e12), ("GB", 1e9)):
        if count >= scale:
            return f"{count / scale:.3g} {unit}"
    return f"{count / 1e6:.3g} MB"


def is_number(text: str) -> bool:
    """Return whether a text is a number, as Python reads it."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def usable_text(text: str) -> str:
    """Return a text that is UTF-8 without NUL; ValueError otherwise."""
    if not text:
        raise ValueError("expected some text, found ''")
    if "\0" in text:
        raise ValueError(f"expected text without NUL, found {_shown(text)}")
    try:
        text.encode("utf-8")
    except UnicodeEncodeError as error:
        # Command-line bytes that are not UTF-8 arrive as lone surrogates.
        raise ValueError(f"expected valid Unicode, found {_shown(text)}") from error
    return text


def usable_path(path: Path) -> Path:
    """Return a path that file systems and JSON files can hold; ValueError otherwise."""
    usable_text(str(path))
    longest = max((len(os.fsencode(part)) for part in path.parts), default=0)
    if longest > LONGEST_NAME:
        raise ValueError(f"expected names of at most {LONGEST_NAME} bytes, found one of {longest}")
    whole = len(os.fsencode(path))
    if whole > LONGEST_PATH:
        raise ValueError(f"expected a path of at most {LONGEST_PATH} bytes, found {whole}")
    return path


def _expanded(value: object) -> object:
    """Return a path with ``~`` and variables such as ``$HOME`` replaced, as a shell would; a YAML file has none."""
    if value == "":
        raise ValueError("expected a path, found ''")
    if not isinstance(value, str | Path):
        return value
    path = Path(os.path.expandvars(value))
    try:
        return path.expanduser()
    except RuntimeError:  # no such user, or one without a home
        return path


def _shown(text: str) -> str:
    return ascii(text if len(text) <= 80 else text[:77] + "...")


#: A path in settings, with ``~`` and ``$HOME`` replaced.
UserPath = Annotated[Path, BeforeValidator(_expanded), AfterValidator(usable_path)]
#: A text in settings.
UserText = Annotated[str, AfterValidator(usable_text)]
