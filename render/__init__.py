"""Light: a description becomes pictures and per-pixel geometry. The only package that uses Mitsuba."""

if __name__ != "glassware.render":
    raise ImportError(f"this package is glassware.render, not {__name__!r}: run from an installed checkout")
