"""The kinds of props that are drawn without files, by name, and how often each is drawn by default."""

from __future__ import annotations

from typing import Literal, get_args

#: Plain bodies of random proportions (`shapes.SHAPES`), and everyday things (`things.kinds.KINDS`).
PropKind = Literal[
    "shape",
    "book",
    "carton",
    "can",
    "fork",
    "knife",
    "spoon",
    "apple",
    "orange",
    "lemon",
    "banana",
    "plate",
    "bowl",
    "mug",
    "tray",
    "napkin",
    "sponge",
    "pen",
    "phone",
    "cable",
    "screwdriver",
    "spanner",
    "pliers",
    "test-tube rack",
    "stand",
]
PROP_KINDS: tuple[PropKind, ...] = get_args(PropKind)
#: Kinds that are not drawn with weight 1 by default: common ones, and those that are so large that the others look
#: small beside them.
_WEIGHTS = {"shape": 2.0, "book": 2.0, "carton": 2.0, "can": 2.0, "plate": 0.7, "tray": 0.4, "stand": 0.25}
DEFAULT_KINDS = tuple(f"{kind}={_WEIGHTS[kind]:g}" if kind in _WEIGHTS else kind for kind in PROP_KINDS)
