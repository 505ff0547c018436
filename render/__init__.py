"""Light: a description becomes pictures and per-pixel geometry. The only package that imports Mitsuba."""

if __name__ != "glassware.render":
    raise ImportError(f"this package is glassware.render, not {__name__!r}: run from an installed checkout")

from .backend.llvm import export_llvm_path

# Dr.Jit loads its LLVM when it is imported, so the choice has to stand before any module here imports it.
export_llvm_path()
