"""What exists: the description of a scene, drawn from a seed (no light transport here)."""

if __name__ != "glassware.procedural":
    raise ImportError(f"this package is glassware.procedural, not {__name__!r}: run from an installed checkout")
