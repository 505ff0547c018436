"""Files: the on-disk contract, its writer and reader, and the commands that make data."""

if __name__ != "glassware.dataset":
    raise ImportError(f"this package is glassware.dataset, not {__name__!r}: run from an installed checkout")
