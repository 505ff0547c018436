"""Write the model cards in the pages on weights from the records of these: run it after they have changed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from glassware.core.json_file import read_json
from glassware.learn.training.weights import SHIPPED

#: The page of each file of weights that comes with glassware.
PAGES = {"base": Path(__file__).with_name("pretrained.md"), "large": Path(__file__).with_name("large_pairs.md")}
#: Lines of a page between which the card stands.
BEGIN, END = "<!-- made by docs/model_card.py -->\n", "<!-- end of what it makes -->\n"
#: Columns of depth: name, key of the report, factor, digits.
_DEPTH = (
    ("MAE [mm]", "mae", 1e3, 0),
    ("RMSE [mm]", "rmse", 1e3, 0),
    ("REL", "rel", 1.0, 3),
    ("within 5 %", "delta_105", 1.0, 3),
)
#: Other figures: words, path in the report, factor, digits, unit.
_FIGURES = (
    ("objects found (boxes overlap by 0.25)", ("pose", "found"), 1.0, 3, ""),
    ("3D AP25", ("boxes", "ap25"), 1.0, 3, ""),
    ("3D AP50", ("boxes", "ap50"), 1.0, 3, ""),
    ("mask AP50", ("masks", "ap50"), 1.0, 3, ""),
    ("mask IoU of all objects", ("masks", "iou_all"), 1.0, 3, ""),
    ("translation error of found objects, median", ("pose", "translation_median"), 1e3, 0, " mm"),
    ("the same, mean", ("pose", "translation"), 1e3, 0, " mm"),
    ("AUC of keypoints, 0 to 10 cm", ("pose", "auc"), 1.0, 3, ""),
)
#: Parts of pictures with a depth error of their own, and words for them.
_PARTS = {"full": "", "overlap": ", seen by both eyes", "outside": ", outside the right picture"}
#: Columns of real pictures.
_REAL = (("", "mask_iou", 1.0, 2), ("", "centre_error", 1e3, 0), ("", "box_iou", 1.0, 2), ("", "depth_mae", 1e3, 0))


def with_card(text: str, record: Mapping[str, Any] | None) -> str:
    """Return the page with the card of a record; as it is without one."""
    if record is None:
        return text
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    assert begin, "no place for the card"
    assert end, "no end of the card"
    return before + begin + "\n" + "\n".join(card(record)) + "\n\n" + end + after


def card(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a card."""
    weights, network = record["weights"], record["weights"]["network"]
    size = weights["views"]["size"]
    yield f"`{record['name']}`: {record['parameters'] / 1e6:.1f} million parameters, {record['bytes'] / 1e6:.1f} MB."
    yield ""
    yield "| | |"
    yield "|---|---|"
    yield f"| network | MVTrans, corrected; context {network['context']}, matching {network['matching']} |"
    yield f"| planes | {network['planes']}, {network['spacing']}, from {_planes(network)} m |"
    if size:
        yield f"| size of pictures | {size[1]} x {size[0]} px{_at_half(network)} |"
    if convergence := weights["views"].get("convergence"):
        yield f"| pairs are cut to what both eyes see at | {convergence:.2f} m |"
    if weights["focal"] is not None:
        median = f"{weights['focal']:.0f} px, {_mm(weights['baseline'])}"
        yield f"| focal length and baseline in training, medians | {median} |"
    yield f"| steps and samples of a step | {weights['step']}, {record['settings']['batch']} |"
    mean = record.get("interpolated")
    if mean is not None:
        yield f"| weights | {mean['alpha']:g} of those after these steps, the rest of those before, `{mean['with']}` |"
    for heading, text in sorted(record["notes"].items()):
        yield f"| {heading} | {text} |"
    for words, report in record["reports"].items():
        yield from _real(words, report) if "ways" in report else _figures(words, report)


def _figures(words: str, report: Mapping[str, Any]) -> Iterator[str]:
    yield ""
    yield f"On `{words}`, {report['samples']} samples (depth at full size):"
    yield ""
    yield "| pixels | " + " | ".join(name for name, *_ in _DEPTH) + " | best constant, MAE [mm] |"
    yield "|---|" + "---|" * (len(_DEPTH) + 1)
    floors = report.get("floors", {}).get("full", {})
    for part, suffix in _PARTS.items():
        for kind, errors in report["depth"].get(part, {}).items():
            if part != "full" and kind not in ("opaque", "transparent"):
                continue
            cells = [_cell(errors and errors[key], factor, digits) for _, key, factor, digits in _DEPTH]
            constant = (floors.get(kind) or {}).get("constant") or {}
            of_part = constant.get("mae") if part == "full" else None
            yield f"| {kind}{suffix} | " + " | ".join([*cells, _cell(of_part, 1e3, 0)]) + " |"
    yield ""
    yield "| | |"
    yield "|---|---|"
    for name, (group, key), factor, digits, unit in _FIGURES:
        yield f"| {name} | {_cell(report[group].get(key), factor, digits)}{unit} |"
    for name, row in report.get("by_thickness", {}).items():
        yield f"| found of the {row['objects']} whose least side is {name} | {_cell(row['found'], 1.0, 3)} |"


def _real(words: str, report: Mapping[str, Any]) -> Iterator[str]:
    """Yield the table of a report of ``bench/real_pictures.py``."""
    yield ""
    yield f"On `{words}`, by `bench/real_pictures.py` (the object whose mask overlaps most with the true one):"
    yield ""
    yield "| shown | frame | objects found | mask IoU | centre off [mm] | box IoU | depth off [mm] |"
    yield "|---|---|---|---|---|---|---|"
    for way, frames in report["ways"].items():
        for frame, scores in frames.items():
            cells = [_cell(scores.get(key), factor, digits) for _, key, factor, digits in _REAL]
            yield f"| {way} | {frame} | {scores['found']} | " + " | ".join(cells) + " |"


def _cell(value: float | None, factor: float, digits: int) -> str:
    return "-" if value is None else f"{factor * value:.{digits}f}"


def _planes(network: Mapping[str, Any]) -> str:
    near, far = network["depth_range"]
    return f"{near:.2f} to {far:.2f}"


def _at_half(network: Mapping[str, Any]) -> str:
    return "; objects are found at half of it" if network.get("objects_at") == "half" else ""


def _mm(metres: float | None) -> str:
    return "-" if metres is None else f"{1e3 * metres:.0f} mm"


def record(name: str) -> dict[str, Any] | None:
    """Return the record of weights that come with glassware; None where there are none of that name."""
    path = SHIPPED / f"{name}.json"
    return read_json(path) if path.is_file() else None


if __name__ == "__main__":
    for weights, page in PAGES.items():
        page.write_text(with_card(page.read_text("utf-8"), record(weights)), "utf-8")
