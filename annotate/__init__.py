"""Ground-truth labels from geometry buffers and the scene description."""

if __name__ != "glassware.annotate":
    raise ImportError(f"this package is glassware.annotate, not {__name__!r}: run from an installed checkout")
