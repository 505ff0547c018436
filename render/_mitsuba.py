"""The one door to Mitsuba and Dr.Jit: `dr` and `mi` load on first use, after a working LLVM was chosen.

Dr.Jit loads its LLVM when it is imported and cannot change it afterwards, and a bad LLVM aborts the process. So no
module of ours imports either package itself. Importing a module of `render` loads nothing; the first attribute of `dr`
or `mi` that is used does.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

from ..core.errors import InputError
from .backend.llvm import export_llvm_path

F = TypeVar("F", bound=Callable[..., Any])


class _LazyModule:
    """A module that is imported when its first attribute is used."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        module = _loaded(self._name)
        try:
            return getattr(module, attribute)
        except (AttributeError, RuntimeError):
            require_variant()  # types such as `mi.Float` exist once one is set
            raise


def require_variant() -> None:
    """Raise InputError where no variant of Mitsuba is set."""
    if _loaded("mitsuba").variant() is None:
        expected = "a variant that is set: make a glassware.Renderer, or call render.backend.variant.activate()"
        raise InputError("backend", expected, "none")


@functools.cache
def _loaded(name: str) -> ModuleType:
    export_llvm_path()
    return import_module(name)


if TYPE_CHECKING:
    import drjit as dr
    import mitsuba as mi
else:
    dr, mi = _LazyModule("drjit"), _LazyModule("mitsuba")


def syntax(function: F) -> F:
    """Return the function with Dr.Jit's loops and conditions (`drjit.syntax`), transformed when it is first called."""

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        return _transformed(function)(*args, **kwargs)

    return call  # pyright: ignore[reportReturnType]


@functools.cache
def _transformed(function: Callable[..., Any]) -> Callable[..., Any]:
    return dr.syntax(function)
