"""Whether what the commands need beyond the base install is there."""

from __future__ import annotations

from importlib.util import find_spec

from ...core.errors import InputError

#: Modules of the extra `learn` (pyproject.toml).
_MODULES = ("torch", "safetensors", "lightning_fabric", "tensorboard")


def check_extra(command: str) -> None:
    """Refuse to run a command without the libraries of the extra `learn`.

    Raises
    ------
    InputError
        Names those that are missing.
    """
    missing = [name for name in _MODULES if not _is_there(name)]
    if missing:
        raise InputError(command, "its extra, as in pip install 'glassware[learn]'", f"no {', '.join(missing)}")


def _is_there(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except ModuleNotFoundError:  # the package around it is missing
        return False
