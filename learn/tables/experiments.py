"""The experiments: rows that are trained, and columns that are read from their reports."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

from ..training.settings import TrainSettings
from . import published

ExperimentName = Literal["keypose", "syn-todd", "ablation"]
EXPERIMENTS: tuple[ExperimentName, ...] = get_args(ExperimentName)

#: Learning rates of the released codes, over that of MVTrans and SimNet; KeyPose's clipping and its weight decay.
_KEYPOSE = {"learning_rate": 1e-3 / 6e-4, "clip": 5.0, "weight_decay": 1e-5}
_DENSEFUSION = {"learning_rate": 1e-4 / 6e-4, "weight_decay": 0.0}
#: The row whose network says where objects are, and completes depth.
DETECTOR = "mvtrans-stereo"
#: What needs no network, by its name in reports: of depth (`evaluation.floors`), and of keypoints
#: (`evaluation.object_scores`).
_DEPTH_FLOORS = {
    "constant": "no network: one constant depth",
    "picture_median": "no network: the true median of each picture",
    "semi_global": "no network: semi-global matching of both eyes",
}
_KEYPOINT_FLOORS = {"constant": "no network: the same keypoints in every window"}
_STEREO = {"views": {"rule": "stereo", "count": 2}}


@dataclass(frozen=True)
class Row:
    """One network of a table."""

    name: str
    title: str
    changes: Mapping[str, Any]  #: of the common settings
    optimiser: Mapping[str, float] = field(default_factory=dict)  #: `learning_rate` as a factor
    views: int | None = None  #: of plots against the number of views
    needs_detector: bool = False  #: trained on what the detector's network gives


@dataclass(frozen=True)
class Column:
    """One figure of a table."""

    name: str
    title: str
    read: Callable[[Mapping[str, Any]], float | None]  #: from a report
    digits: int
    #: the figure of a floor, by its name, from a report; None: needs a network
    floor: Callable[[Mapping[str, Any], str], float | None] | None = None


@dataclass(frozen=True)
class Experiment:
    """A table."""

    name: ExperimentName
    title: str
    rows: tuple[Row, ...]
    columns: tuple[Column, ...]
    paper: Mapping[str, Mapping[str, float]]  #: by row and column, in the units of the columns
    floors: Mapping[str, str]  #: titles of what needs no network, by name in reports


def experiment(name: ExperimentName) -> Experiment:
    """Return an experiment by its name."""
    if name == "keypose":
        title = "3D keypoints of transparent objects (the paper's table I)"
        return Experiment(name, title, _keypose_rows(), _KEYPOSE_COLUMNS, published.KEYPOSE, _KEYPOINT_FLOORS)
    if name == "syn-todd":
        title = "Depth, boxes and masks of synthetic scenes (the paper's table II)"
        rows = (_simnet(), *_mvtrans())
        return Experiment(name, title, rows, _SCENE_COLUMNS, published.SYN_TODD, _DEPTH_FLOORS)
    # (No row sees the two eyes of a pair, which are matched for the third floor.)
    floors = {name: title for name, title in _DEPTH_FLOORS.items() if name != "semi_global"}
    return Experiment(name, "What each part of MVTrans is for", _ablation_rows(), _SCENE_COLUMNS, {}, floors)


def row_settings(row: Row, common: TrainSettings) -> TrainSettings:
    """Return the settings of a row: the common ones, and what makes the row."""
    data = common.model_dump()
    for group, values in row.changes.items():
        for name, value in values.items():
            nested = isinstance(value, dict)
            data[group][name] = data[group][name] | value if nested else value
    for name, value in row.optimiser.items():
        scaled = name == "learning_rate"
        data["optimiser"][name] = data["optimiser"][name] * value if scaled else value
    return TrainSettings.model_validate(data)


def equal_rows(rows: Sequence[Row], common: TrainSettings) -> dict[str, str]:
    """Return the rows that have the settings of an earlier one, by name, with its name: one run serves both.

    A switch that the common settings have already makes such a row.
    """
    first: list[tuple[TrainSettings, str]] = []
    found: dict[str, str] = {}
    for row in rows:
        settings = row_settings(row, common)
        earlier = [name for known, name in first if known == settings]
        if earlier and not row.needs_detector:
            found[row.name] = earlier[0]
        else:
            first.append((settings, row.name))
    return found


def _mvtrans() -> tuple[Row, ...]:
    return tuple(
        Row(
            f"mvtrans-{count}",
            f"MVTrans, {count} views",
            {"network": {"name": "mvtrans"}, "views": {"count": count, "rule": "distance"}},
            views=count,
        )
        for count in (2, 3, 5)
    )


def _simnet() -> Row:
    return Row("simnet", "SimNet", {"network": {"name": "simnet"}, **_STEREO})


def _keypose_rows() -> tuple[Row, ...]:
    stereo = Row(DETECTOR, "MVTrans, both eyes", {"network": {"name": "mvtrans"}, **_STEREO})
    dense = (
        Row(
            f"densefusion-{depth}",
            f"DenseFusion, {depth} depth",
            {"network": {"name": "densefusion", "densefusion": {"depth": depth}}, **_STEREO},
            _DENSEFUSION,
            needs_detector=depth == "completed",
        )
        for depth in ("true", "raw", "completed")
    )
    keypose = Row("keypose", "KeyPose", {"network": {"name": "keypose"}, **_STEREO}, _KEYPOSE)
    return (*dense, _simnet(), keypose, stereo, *_mvtrans())


def _ablation_rows() -> tuple[Row, ...]:
    switches = {
        "base": ("MVTrans, 2 views", {}),
        "released": ("as it was released", {"network": {"variant": "reference"}}),
        "concat": ("features concatenated, not correlated", {"network": {"matching": "concat"}}),
        "group": ("features correlated in groups", {"network": {"matching": "group"}}),
        "linear": ("planes at equal steps of depth", {"network": {"spacing": "linear"}}),
        "inverse": ("planes at equal steps of 1 / depth", {"network": {"spacing": "inverse"}}),
        "windowed": ("depth around the best plane", {"network": {"readout": "windowed"}}),
        "encoder": ("context by EfficientNet-Lite0, ImageNet", {"network": {"context": "efficientnet-lite0"}}),
        "visibility": ("3 views, weighted by visibility", {"network": {"fusion": "visibility"}, "views": {"count": 3}}),
        "3-views": ("3 views", {"views": {"count": 3}}),
        "5-views": ("5 views", {"views": {"count": 5}}),
    }
    views = {"base": 2, "3-views": 3, "5-views": 5}
    return tuple(
        Row(name, title, _with_mvtrans(changes), views=views.get(name)) for name, (title, changes) in switches.items()
    )


def _with_mvtrans(changes: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "network": {"name": "mvtrans", **changes.get("network", {})},
        "views": {"count": 2, "rule": "distance", **changes.get("views", {})},
    }


def _value(report: Mapping[str, Any], *path: str) -> float | None:
    found: Any = report
    for name in path:
        if not isinstance(found, Mapping) or name not in found:
            return None
        found = found[name]
    return found


def _of_keypoints(name: str, location: str = "truth") -> Callable[[Mapping[str, Any]], float | None]:
    """Return what reads a figure of keypoints; networks that find objects themselves have one for all locations."""

    def read(report: Mapping[str, Any]) -> float | None:
        if "locations" in report:
            return _value(report, "locations", location, "keypoints", name)
        return _value(report, "keypoints", name)

    return read


def _scaled(factor: float, read: Callable[[Mapping[str, Any]], float | None]) -> Callable:
    def scaled(report: Mapping[str, Any]) -> float | None:
        value = read(report)
        return None if value is None else factor * value

    return scaled


def _of(*path: str, factor: float = 1.0) -> Callable[[Mapping[str, Any]], float | None]:
    return _scaled(factor, lambda report: _value(report, *path))


def _keypoint_column(name: str, title: str, figure: str, factor: float, location: str = "truth") -> Column:
    def floor(report: Mapping[str, Any], of: str) -> float | None:
        return _of("locations", location, of, figure, factor=factor)(report)

    return Column(name, title, _scaled(factor, _of_keypoints(figure, location)), 1, floor)


def _depth_column(name: str, title: str) -> Column:
    def floor(report: Mapping[str, Any], of: str) -> float | None:
        return _value(report, "floors", *_PIXELS, of, name)

    return Column(name, title, _of("depth", *_PIXELS, name), 3, floor)


#: Size and pixels of the table's depths.
_PIXELS = ("cleargrasp", "objects")
_KEYPOSE_COLUMNS = (
    _keypoint_column("auc", "AUC [%]", "auc", 100.0),
    _keypoint_column("near", "<2 cm [%]", "near", 100.0),
    _keypoint_column("mae", "MAE [mm]", "mae", 1000.0),
    _keypoint_column("auc_jitter", "AUC, places off by 20 px [%]", "auc", 100.0, "jitter"),
    _keypoint_column("auc_detector", "AUC, places detected [%]", "auc", 100.0, "detector"),
    Column("ap25", "3D mAP [%]", _of("boxes", "ap25", factor=100.0), 1),
    Column("iou_found", "3D IoU [%]", _of("boxes", "iou_found", factor=100.0), 1),
)
_SCENE_COLUMNS = (
    _depth_column("rmse", "RMSE [m]"),
    _depth_column("mae", "MAE [m]"),
    _depth_column("rel", "REL"),
    Column("ap25", "3D mAP [%]", _of("boxes", "ap25", factor=100.0), 2),
    Column("iou_found", "3D IoU [%]", _of("boxes", "iou_found", factor=100.0), 2),
    Column("ap50", "mAP [%]", _of("masks", "ap50", factor=100.0), 2),
    Column("mask_iou", "IoU [%]", _of("masks", "iou_all", factor=100.0), 2),
)
