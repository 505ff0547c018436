"""Core: what every other package stands on. It imports no other package of glassware."""

if __name__ != "glassware.core":
    raise ImportError(f"this package is glassware.core, not {__name__!r}: run from an installed checkout")
