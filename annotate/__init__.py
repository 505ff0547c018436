"""Labels computed from geometry buffers and the description, and the checks that prove them."""

if __name__ != "glassware.annotate":
    raise ImportError(f"this package is glassware.annotate, not {__name__!r}: run from an installed checkout")
