"""Tables of what `world.py` found, in Markdown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from world_checks import VOLUME, WALL

from glassware.procedural.contents.settings import STANDING
from glassware.procedural.optics.draw import LIQUID_WEIGHTS, glass_names
from glassware.procedural.optics.turbid import TURBID
from glassware.procedural.props.kinds import DEFAULT_KINDS
from glassware.procedural.props.shapes import SHAPES
from glassware.procedural.tables.kinds import DEFAULT_TABLES
from glassware.procedural.vessels.settings import CATEGORIES

#: Numbers of objects in a scene of the paper (Syn-TODD): fewest and most.
PAPER = {"objects": "3 to 15", "vessels": "up to 7", "props": "up to 8"}
#: Every name that has to be there among many scenes, by what it names.
EXPECTED: dict[str, Sequence[str]] = {
    "families": CATEGORIES,
    "parts": ("cap", "cork", "lid", "stopper", "label", "print", "rack", "ring"),
    "contents": ("ice cube", "beads", "bubbles", "layers", "turbid", *STANDING),
    "glasses": tuple(glass_names()),
    "liquids": (*(name for name in LIQUID_WEIGHTS if not name.startswith("dyed") and "sugar" not in name), *TURBID),
    "props": (*(name.partition("=")[0] for name in DEFAULT_KINDS if not name.startswith("shape")), *SHAPES),
    "tables": tuple(name.partition("=")[0] for name in DEFAULT_TABLES),
}
#: What a scene's record is, as `world.py` writes it.
Record = Mapping[str, Any]


def figures(records: Sequence[Record]) -> list[tuple[str, str]]:
    """Return the rows about what was drawn and what is wrong with it."""
    drawn = [record for record in records if "failure" not in record]
    failures = [f"{record['scene']}: {record['failure']}" for record in records if "failure" in record]
    faults = [f"{record['scene']}: {fault}" for record in drawn for fault in record["faults"]]
    overlaps = [f"{record['scene']}: {a} and {b}" for record in drawn for a, b in record["overlaps"]]
    pairs = sum(record["pairs"] for record in drawn)
    return [
        ("failures", _listed(failures)),
        ("surfaces of glass, liquids and contents that are not closed", _listed(faults)),
        ("pairs of objects that overlap by more than 0.5 mm", f"{_listed(overlaps)}, of {pairs}"),
        ("thinnest wall over the one asked for", _ratios(drawn, "walls", WALL)),
        ("volume over that of the profile below the level", _ratios(drawn, "closed_forms", VOLUME)),
        ("volume over a Monte Carlo integral", _ratios(drawn, "volumes", VOLUME)),
        ("vessels that are alike", _alike(drawn)),
        *[
            (f"{what} in a scene: mean, range, the paper's", f"{_span([r['counts'][what] for r in drawn])}, {paper}")
            for what, paper in PAPER.items()
        ],
        *[(f"{what}: how many kinds, which are missing", _kinds(drawn, what)) for what in EXPECTED],
        *_piles(drawn),
    ]


def _piles(drawn: Sequence[Record]) -> list[tuple[str, str]]:
    rests = [record["rest"] for record in drawn if record["rest"]]
    piles = [rest for rest in rests if not rest["given_up"]]
    objects, vessels = (sum(record["all"][what] for record in drawn) for what in ("objects", "vessels"))
    upon, tilted = (sum(record["all"][what] for record in drawn) for what in ("upon", "tilted"))
    again = f"{sum(rest['attempt'] - 1 for rest in piles)}; {sum(rest['fell_again'] for rest in piles)}"
    seconds = [rest["seconds"] for rest in piles]
    moved = max((rest["moved"] for rest in piles), default=0.0)
    return [
        ("scenes with a pile; piles that were given up", f"{_part(len(piles), len(drawn))}; {len(rests) - len(piles)}"),
        ("piles drawn again; falls drawn again", again),
        ("simulated time of a pile: mean, longest [s]", f"{_mean(seconds):.2f}, {max(seconds, default=0.0):.2f}"),
        ("largest movement in the last second [mm]", f"{1e3 * moved:.2f}"),
        ("objects on another one; leaning or lying vessels", f"{_part(upon, objects)}; {_part(tilted, vessels)}"),
    ]


def times(records: Sequence[Record]) -> list[str]:
    """Return a row for each part of the work and one for all: mean, 99th percentile, longest, and its scene."""
    drawn = [record for record in records if "failure" not in record]
    rows = []
    for what in drawn[0]["times"] if drawn else ():
        values = np.array([record["times"].get(what, 0.0) for record in drawn])
        longest = int(values.argmax())
        figures = f"{values.mean():.2f} | {np.quantile(values, 0.99):.2f} | {values[longest]:.2f}"
        rows.append(f"{what} | {figures} | {drawn[longest]['scene']}")
    return rows


def _ratios(drawn: Sequence[Record], what: str, allowed: float) -> str:
    """Return the range of a ratio over all vessels, and which vessels are beyond what is allowed."""
    values = [(record["scene"], name, *pair) for record in drawn for name, pair in record[what].items()]
    if not values:
        return "none"
    ratios = [ratio for *_, ratio in values]
    beyond = [
        f"{scene} {name} ({family}): {ratio:.3f}" for scene, name, family, ratio in values if _off(ratio, allowed)
    ]
    return f"{min(ratios):.4f} to {max(ratios):.4f} of {len(ratios)}; beyond {100 * allowed:g} %: {_listed(beyond)}"


def _off(ratio: float, allowed: float) -> bool:
    return not abs(ratio - 1.0) <= allowed


def _alike(drawn: Sequence[Record]) -> str:
    """Return how many vessels have the same surface as another one, and how near extents of one family come."""
    shapes = [shape for record in drawn for shape in record["shapes"]]
    same = len(shapes) - len({digest for _, digest, _ in shapes})
    nearest = np.inf
    for family in {category for category, *_ in shapes}:
        sizes = np.array([size for category, _, size in shapes if category == family])
        if len(sizes) > 1:
            apart = np.abs(sizes[:, None] - sizes[None]).max(2)
            nearest = min(nearest, float(apart[np.triu_indices(len(sizes), 1)].min()))
    return f"{same} of {len(shapes)}; nearest extents of a family {nearest:.3f} mm apart"


def _kinds(drawn: Sequence[Record], what: str) -> str:
    counts: Counter[str] = Counter()
    for record in drawn:
        counts.update(record["kinds"][what])
    if not counts:
        return "none is drawn"
    missing = [name for name in EXPECTED[what] if not counts[name]]
    rarest = min((counts[name], name) for name in EXPECTED[what])
    return f"{len(counts)}, {_listed(missing)}; rarest: {rarest[1]} ({rarest[0]})"


def _span(values: Sequence[int]) -> str:
    return f"{np.mean(values):.1f}, {min(values)} to {max(values)}" if values else "none"


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if len(values) else 0.0


def _part(part: int, whole: int) -> str:
    return f"{part} of {whole} ({100.0 * part / max(whole, 1):.1f} %)"


def _listed(lines: Iterable[str], most: int = 20) -> str:
    found = list(lines)
    more = f"; and {len(found) - most} more" if len(found) > most else ""
    return ("; ".join(found[:most]) + more) or "none"
