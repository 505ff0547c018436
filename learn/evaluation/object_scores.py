"""Scores of the networks that are told where an object is: KeyPose and DenseFusion."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from ...core.errors import InputError
from ...core.stopping import check_stop
from ..data.densefusion_samples import DenseFusionSamples
from ..data.ground_truth import GroundTruth
from ..data.keypose_samples import KeyPoseSamples
from ..data.loading import load_batches
from ..data.object_cases import Finding, Findings, Location, ObjectCase, object_of, too_small
from ..data.samples import Batch, SampleDataset
from ..data.splits import SplitName
from ..decoding.decode import decode
from ..decoding.keypoints import points_in_space
from ..metrics.pose import PoseErrors, pose_errors
from ..networks.settings import NetworkSettings
from ..targets.encoding import encoding_of
from ..targets.keypoints import keypoint_distances, object_keypoints
from ..training.checkpoint import load_network
from ..training.methods import outputs_of, samples_of
from ..training.settings import TrainSettings
from .keypoint_floor import Windows, constant_keypoints
from .report import nan_to_none, object_metrics
from .score import ObjectScore, axis_distances, check_finite, eval_mode

#: Seed and draw of the samples: the same for every network.
_SEED, _DRAW = 0, 0
#: Objects of a batch, and between two lines about the progress.
_BATCH, _PROGRESS_STEP = 8, 80


@dataclass(frozen=True, eq=False)
class Detector:
    """A network that says where objects are."""

    network: nn.Module
    settings: TrainSettings
    path: Path


def load_detector(path: Path, settings: TrainSettings) -> Detector:
    """Return the network of a checkpoint; InputError where it finds no objects or sees pictures of another size."""
    network, theirs = load_network(path)
    if theirs.network.name not in ("mvtrans", "simnet"):
        raise InputError(f"{path}: network.name", "mvtrans or simnet, which find objects", theirs.network.name)
    if (theirs.views.size, theirs.views.fit) != (settings.views.size, settings.views.fit):
        raise InputError(f"{path}: views.size", str(settings.views.size), theirs.views.size)
    if theirs.views.convergence is not None:
        raise InputError(f"{path}: views.convergence", "none: a detector of whole pictures", theirs.views.convergence)
    return Detector(eval_mode(network), theirs, path)


def evaluate_objects(
    network: nn.Module,
    settings: TrainSettings,
    data: Path,
    split: SplitName,
    say: Callable[[str], None],
    *,
    detector: Detector | None = None,
    workers: int = 0,
) -> dict[str, Any]:
    """Return the metrics of a network for each way of saying where objects are, as JSON data.

    Parameters
    ----------
    network, settings : Module, TrainSettings
        KeyPose or DenseFusion.
    data, split : Path, str
        The data set.
    say : callable
        Takes lines about the progress.
    detector : Detector, optional
        For the location ``detector``; without one only ``truth`` and ``jitter`` are measured.
    workers : int
        Worker processes of the data loader.

    Returns
    -------
    dict
        By location `report.object_metrics`, with how many objects were ``dropped`` by the border rule, ``lost``
        without a depth, ``missed`` by the detector, and of an ``unknown`` category; they are failures but in ``kept``.
        Objects that are ``too_small`` to be detected are in no figure.
    """
    eval_mode(network)
    found: dict[str, Any] = {}
    views = 0
    locations: tuple[Location, ...] = ("truth", "jitter") if detector is None else ("truth", "jitter", "detector")
    for location in locations:
        findings = None if location != "detector" or detector is None else detections(detector, data, split, workers)
        samples = samples_of(settings, data, split, seed=_SEED, ground_truth=True, location=location, findings=findings)
        assert isinstance(samples, KeyPoseSamples | DenseFusionSamples)
        say(f"location: {location}")
        views = len(samples.base)
        found[location] = _measured(network, samples, settings.network, say, workers)
    return nan_to_none({"samples": views, "locations": found})


def detections(detector: Detector, data: Path, split: SplitName, workers: int = 0) -> Findings:
    """Return what a detector finds in a split: of each object the best detection whose peak lies on it."""
    samples = samples_of(detector.settings, data, split, seed=_SEED, ground_truth=True)
    assert isinstance(samples, SampleDataset)
    encoding = encoding_of(detector.settings.network)
    device = next(detector.network.parameters()).device
    found: dict[tuple[int, int], Finding] = {}
    order = [[(index, _DRAW)] for index in range(len(samples))]
    with torch.inference_mode():
        for view, batch in enumerate(load_batches(samples, order, workers)):
            check_stop()
            outputs = outputs_of(detector.network, batch.to(device), detector.settings.network)
            fields = {name: value.float().cpu() for name, value in outputs.items()}
            (objects,) = decode(fields, batch.K[:, 0].double(), encoding)
            (labels,) = batch.ground_truths
            assert labels is not None
            for row in range(len(objects)):
                x, y = (round(float(value)) for value in objects.peak[row])
                key = (view, int(labels.instances[y, x]))
                mask = objects.mask[row].numpy()
                if key not in found and mask.any():
                    found[key] = Finding((float(x), float(y)), mask)
    return found


def _measured(
    network: nn.Module,
    samples: KeyPoseSamples | DenseFusionSamples,
    settings: NetworkSettings,
    say: Callable[[str], None],
    workers: int,
) -> dict[str, Any]:
    device = next(network.parameters()).device
    scores: list[ObjectScore] = []
    windows: list[Windows] = []
    count = len(samples)
    order = [
        [(index, _DRAW) for index in range(first, min(first + _BATCH, count))] for first in range(0, count, _BATCH)
    ]
    with torch.inference_mode():
        for batch in load_batches(samples, order, workers):
            check_stop()
            outputs = outputs_of(network, batch.to(device), settings)
            scores += _scored(batch, {name: value.float().cpu() for name, value in outputs.items()}, settings)
            if "keypoints" in batch.targets:
                windows.append(Windows(batch.targets, batch.K))
            if len(scores) % _PROGRESS_STEP == 0 or len(scores) == count:
                say(f"object {len(scores)}/{count}")
    dropped = [_failed(samples.base.labels(case.view), case, settings) for case in samples.dropped]
    missed = [_failed(samples.base.labels(case.view), case, settings) for case in samples.missed]
    cases = samples.unknown if isinstance(samples, DenseFusionSamples) else []
    unknown = [_failed(samples.base.labels(case.view), case, settings) for case in cases]
    lost = sum(score.pose is None for score in scores)
    return {
        **object_metrics([*scores, *dropped, *missed, *unknown]),
        "kept": object_metrics([score for score in scores if score.pose is not None])["keypoints"],
        "constant": constant_keypoints(windows) if windows else None,
        "dropped": len(dropped),
        "missed": len(missed),
        "lost": lost,
        "unknown": len(unknown),
        "too_small": too_small(samples.base),
    }


def _scored(batch: Batch, outputs: Mapping[str, Tensor], settings: NetworkSettings) -> list[ObjectScore]:
    check_finite(outputs, batch.names[0])
    points = None
    if "keypoints" in outputs:
        points = points_in_space(outputs["keypoints"], batch.K, batch.targets["baseline"]).double().numpy()
    scores = []
    for row, labels in enumerate(batch.ground_truths):
        assert labels is not None
        case = ObjectCase(0, int(batch.targets["object_id"][row]))
        if points is not None:
            scores.append(_of_keypoints(points[row], labels, case, settings))
        elif bool(batch.targets["lost"][row]):
            scores.append(_failed(labels, case, settings))
        else:
            scores.append(_of_pose(outputs["pose"][row].double().numpy(), labels, case))
    return scores


def _of_keypoints(points: np.ndarray, labels: GroundTruth, case: ObjectCase, settings: NetworkSettings) -> ObjectScore:
    item = object_of(labels, case, "labels")
    options = settings.keypose
    local, orders = object_keypoints(item, labels.keypoints[item.id], options.points, options.orderings)
    true = local @ item.camera_T_object[:3, :3].T + item.camera_T_object[:3, 3]
    distances = keypoint_distances(points, true, orders)
    pose = PoseErrors(
        translation=float(np.linalg.norm(points.mean(0) - true.mean(0))),
        rotation=math.nan,
        add=math.nan,
        add_s=math.nan,
        points=tuple(distances.tolist()),
    )
    return ObjectScore(item, math.nan, pose, len(local), None, tuple(distances.tolist()), len(local))


def _of_pose(pose: np.ndarray, labels: GroundTruth, case: ObjectCase) -> ObjectScore:
    item = object_of(labels, case, "labels")
    keypoints, surface = labels.keypoints[item.id], labels.surface.get(item.id)
    errors = pose_errors(pose, item.camera_T_object, keypoints, item.symmetry, surface)
    axis = axis_distances(pose, item)
    return ObjectScore(item, math.nan, errors, len(keypoints), None, axis, len(axis))


def _failed(labels: GroundTruth, case: ObjectCase, settings: NetworkSettings) -> ObjectScore:
    item = object_of(labels, case, "labels")
    stored, options = labels.keypoints[item.id], settings.keypose
    of_keypose = len(object_keypoints(item, stored, options.points, options.orderings)[0])
    axis = of_keypose if settings.name == "keypose" else 2
    points = of_keypose if settings.name == "keypose" else len(stored)
    return ObjectScore(item, 0.0, None, points, None, None, axis)
