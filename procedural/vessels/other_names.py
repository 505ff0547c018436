"""Everyday and trade names of vessels and glasses, for hints at the names that settings take."""

from __future__ import annotations

#: Families of vessels by names that other people use.
OTHER_CATEGORIES: dict[str, str] = {
    "wine glass": "stem glass",
    "wineglass": "stem glass",
    "goblet": "stem glass",
    "champagne glass": "stem glass",
    "champagne flute": "stem glass",
    "martini glass": "cocktail glass",
    "glass": "tumbler",
    "drinking glass": "tumbler",
    "water glass": "tumbler",
    "whisky glass": "tumbler",
    "pitcher": "jug",
    "carafe": "jug",
    "erlenmeyer": "flask",
    "erlenmeyer flask": "flask",
    "conical flask": "flask",
    "wine bottle": "bottle",
    "coffee mug": "mug",
    "teacup": "cup",
}
#: Glasses and plastics by trade names and by what they are called in short.
OTHER_GLASSES: dict[str, str] = {
    "glass": "soda-lime glass",
    "window glass": "soda-lime glass",
    "pyrex": "borosilicate glass 3.3",
    "duran": "borosilicate glass 3.3",
    "borosilicate": "borosilicate glass 3.3",
    "quartz": "fused silica",
    "quartz glass": "fused silica",
    "crystal": "lead crystal",
    "plexiglass": "acrylic",
    "plexiglas": "acrylic",
    "perspex": "acrylic",
    "pmma": "acrylic",
    "plastic": "PET",
}
