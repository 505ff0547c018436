"""Ids of categories that are the same in every data set.

Glass and opaque objects of one name are different categories: a mug of glass is `mug`, one of stoneware `opaque mug`.
Names that are not in the table, as those of mesh files, follow from 1001 on in the order of the names.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

Supercategory = Literal["vessel", "prop"]  #: transparent, opaque
#: Id of the first category that is not in the table.
FIRST_OTHER = 1001
#: Families of vessels, bodies made by hand, and what is of glass in or on a vessel. Files refer to these ids: new
#: rows take the next free id of both tables, and no row is changed or deleted.
TRANSPARENT: dict[str, int] = {
    "tumbler": 1,
    "beaker": 2,
    "bowl": 3,
    "bottle": 4,
    "stem glass": 5,
    "flask": 6,
    "vase": 7,
    "freeform": 8,
    "faceted glass": 9,
    "fluted glass": 10,
    "ribbed glass": 11,
    "square glass": 12,
    "mug": 13,
    "cup": 14,
    "jug": 15,
    "teapot": 16,
    "double-walled glass": 17,
    "cocktail glass": 18,
    "spouted beaker": 19,
    "test tube": 20,
    "vial": 21,
    "volumetric flask": 22,
    "round flask": 23,
    "square bottle": 24,
    "oval bottle": 25,
    "jar": 26,
    "plastic bottle": 27,
    "plastic cup": 28,
    "stopper": 29,
    "lid": 30,
    "stirring rod": 31,
    "body": 32,
    "vessel": 33,
    "ball": 34,
    "slab": 35,
    "prism": 36,
}
#: Shapes, everyday things, opaque parts of vessels and what leans in them, and blocks made by hand; by the name that
#: labels have. As above.
OPAQUE: dict[str, int] = {
    "box": 37,
    "plain book": 38,
    "prism": 39,
    "cylinder": 40,
    "plain can": 41,
    "ball": 42,
    "cone": 43,
    "ring": 44,
    "capsule": 45,
    "cup": 46,
    "superellipsoid": 47,
    "stone": 48,
    "book": 49,
    "carton": 50,
    "can": 51,
    "fork": 52,
    "knife": 53,
    "spoon": 54,
    "apple": 55,
    "orange": 56,
    "lemon": 57,
    "banana": 58,
    "plate": 59,
    "bowl": 60,
    "mug": 61,
    "tray": 62,
    "napkin": 63,
    "sponge": 64,
    "pen": 65,
    "phone": 66,
    "cable": 67,
    "screwdriver": 68,
    "spanner": 69,
    "pliers": 70,
    "test-tube rack": 71,
    "stand": 72,
    "cap": 73,
    "cork": 74,
    "lid": 75,
    "label": 76,
    "print": 77,
    "rack": 78,
    "straw": 79,
    "block": 80,
}


def category_name(category: str, supercategory: Supercategory) -> str:
    """Return the name of a category in an export.

    Parameters
    ----------
    category : str
        As labels have it.
    supercategory : {'vessel', 'prop'}
        Whether the object is transparent or opaque.

    Returns
    -------
    str
        The category itself, with ``opaque`` before it where transparent objects have the same name.
    """
    return f"opaque {category}" if supercategory == "prop" and category in TRANSPARENT else category


#: All names with an id of their own.
CATEGORY_IDS: dict[str, int] = TRANSPARENT | {category_name(name, "prop"): id for name, id in OPAQUE.items()}


def category_ids(names: Iterable[str]) -> dict[str, int]:
    """Return the ids of categories, ascending.

    Parameters
    ----------
    names : iterable of str
        As `category_name` returns them.

    Returns
    -------
    dict of str to int
        Ids of the table, and from `FIRST_OTHER` on those of the names that are not in it, in the order of the names.
    """
    wanted = set(names)
    own = {name: CATEGORY_IDS[name] for name in sorted(wanted & set(CATEGORY_IDS), key=CATEGORY_IDS.__getitem__)}
    return own | {name: id for id, name in enumerate(sorted(wanted - set(CATEGORY_IDS)), start=FIRST_OTHER)}
