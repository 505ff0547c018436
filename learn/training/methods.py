"""What differs between the networks in a run: their samples, what follows from the data, their outputs and losses."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from ...core.errors import InputError
from ...core.model import Model
from ..data.densefusion_samples import DenseFusionSamples, DepthSource, raw_depth, true_depth
from ..data.joined import JoinedSamples
from ..data.keypose_samples import KeyPoseSamples
from ..data.object_cases import Findings, Location
from ..data.samples import Batch, LoadedViews, SampleDataset, Samples, image_tensor
from ..data.settings import AugmentSettings
from ..data.splits import SplitName
from ..networks.settings import NetworkSettings
from ..networks.weights_file import is_safetensors
from ..targets.encoding import encoding_of
from .checkpoint import load_network
from .losses import losses
from .object_losses import densefusion_losses, keypose_losses
from .settings import TrainSettings

#: How far the planes, and the nearest disparity, reach beyond the depths of the training data, as a fraction: other
#: scenes are a little larger.
_DEPTH_MARGIN = 0.1
#: Quarter-size pixels: the step between two disparities [px].
_QUARTER = 4.0


def with_own_views(settings: TrainSettings) -> TrainSettings:
    """Return settings with the views of their network: the eyes of a stereo pair for all but MVTrans.

    Their samples are not mirrored: the mirror image of a pair has its eyes exchanged, and labels are of the left one.
    Nor are windows of them taken where a network sees windows around objects.

    Raises
    ------
    InputError
        Where other views are asked for.
    """
    if settings.network.name == "mvtrans":
        return settings
    if settings.views.rule == "grid" or settings.views.count != 2:
        found = f"{settings.views.count} by the rule {settings.views.rule}"
        raise InputError("views", f"the two eyes of a stereo pair, which {settings.network.name} takes", found)
    if settings.views.convergence is not None:
        expected = f"none: {settings.network.name} takes whole pictures"
        raise InputError("views.convergence", expected, settings.views.convergence)
    views = settings.views.model_copy(update={"rule": "stereo"})
    augment = settings.augment.model_copy(update={"flip": 0.0})
    if settings.network.name != "simnet":
        augment = augment.model_copy(update={"zoom": (1.0, 1.0)})
    return settings.model_copy(update={"views": views, "augment": augment})


def samples_of(
    settings: TrainSettings,
    data: Path,
    split: SplitName,
    *,
    augment: AugmentSettings | None = None,
    seed: int = 0,
    ground_truth: bool = False,
    location: Location = "truth",
    findings: Findings | None = None,
) -> Samples:
    """Return the samples of a network: of a view each, or of an object each.

    Parameters
    ----------
    settings : TrainSettings
        Network and views.
    data, split : Path, str
        Data set and part of it.
    augment : AugmentSettings, optional
        Given in training alone.
    seed, ground_truth : int, bool
        As in `SampleDataset`.
    location, findings : str, mapping
        Where objects are said to be, for the networks that are told (`data.object_cases`).
    """
    network, encoding = settings.network, encoding_of(settings.network)
    training, released = augment is not None, network.variant == "reference"
    if network.name in ("mvtrans", "simnet"):
        return SampleDataset(
            data, split, settings.views, encoding, augment=augment, seed=seed, ground_truth=ground_truth
        )
    common = augment if network.name == "keypose" and network.keypose.augment == "common" else None
    # The loss of DenseFusion needs points of the surface, which come with the ground truth.
    base = SampleDataset(
        data,
        split,
        settings.views,
        encoding,
        augment=common,
        seed=seed,
        ground_truth=True,
        sensor_depth=network.name == "densefusion",
    )
    options = {"released": released, "training": training, "seed": seed, "location": location, "findings": findings}
    if network.name == "keypose":
        return KeyPoseSamples(base, network.keypose, **options)
    return DenseFusionSamples(base, network.densefusion, _depth_source(network), **options)


def training_samples(settings: TrainSettings, data: Path) -> Samples:
    """Return the samples that a run trains on: those of its data set, and of others that are mixed with them."""
    options = {"augment": settings.augment, "seed": settings.seed}
    first = samples_of(settings, data, settings.train_split, **options)
    if not settings.also:
        return first
    if not isinstance(first, SampleDataset):
        raise InputError("also", f"no further data sets for the network {settings.network.name}", len(settings.also))
    others = [samples_of(settings, other, settings.train_split, **options) for other in settings.also]
    return JoinedSamples([part for part in (first, *others) if isinstance(part, SampleDataset)])


def with_data(settings: TrainSettings, train: Samples) -> tuple[TrainSettings, Samples]:
    """Return settings with what follows from the training data where they leave it open, and samples that have it.

    These are planes, disparities, the number of keypoints, categories.
    """
    network = settings.network
    if network.name == "densefusion" and isinstance(train, DenseFusionSamples):
        categories = network.densefusion.categories or train.categories()
        train = train.with_categories(categories)
        return _with_network(settings, densefusion=_changed(network.densefusion, categories=categories)), train
    if network.name == "keypose" and isinstance(train, KeyPoseSamples):
        count = network.keypose.count or train.keypoint_count()
        return _with_network(settings, keypose=_changed(network.keypose, count=count)), train
    assert isinstance(train, SampleDataset | JoinedSamples)
    if network.name == "simnet" and network.simnet.bins is None and network.variant == "corrected":
        nearest = (1.0 - _DEPTH_MARGIN) * train.depth_range()[0]
        zoom = settings.augment.zoom[1] if settings.augment.probability else 1.0
        bins = math.ceil(zoom * train.focal_baseline() / nearest / _QUARTER) + 1
        return _with_network(settings, simnet=_changed(network.simnet, bins=bins)), train
    if network.name == "mvtrans" and network.variant == "corrected" and network.depth_range is None:
        near, far = train.depth_range()
        return _with_network(settings, depth_range=((1.0 - _DEPTH_MARGIN) * near, (1.0 + _DEPTH_MARGIN) * far)), train
    return settings, train


def outputs_of(
    network: nn.Module, batch: Batch, settings: NetworkSettings, progress: float | None = None
) -> dict[str, Tensor]:
    """Return the outputs of a network for a batch.

    Parameters
    ----------
    network : Module
        Of the settings.
    batch : Batch
        Of `samples_of`.
    settings : NetworkSettings
        The network's.
    progress : float, optional
        Fraction of the run that is done, in training: late in it DenseFusion trains its refiner.
    """
    if settings.name == "keypose":
        return network(batch.images)
    if settings.name == "densefusion":
        targets = batch.targets
        refine = None if progress is None else progress >= settings.densefusion.refine_after
        sizes = targets["sizes"] if settings.variant == "reference" else None
        return network(batch.images[:, 0], targets["cloud"], targets["pixels"], targets["category"], sizes, refine)
    return network(batch.images, batch.world_T_camera, batch.K)


def losses_of(
    outputs: Mapping[str, Tensor], batch: Batch, settings: TrainSettings, progress: float = 1.0
) -> dict[str, Tensor]:
    """Return each loss of a network, unweighted, by the names of `LossWeights`.

    Parameters
    ----------
    outputs, batch : mapping of Tensor, Batch
        Of `outputs_of`, and the batch that it took.
    settings : TrainSettings
        Network and losses.
    progress : float
        Fraction of the run that is done: some losses of KeyPose set in late.
    """
    network = settings.network
    if network.name == "keypose":
        size = (batch.images.shape[-2], batch.images.shape[-1])
        options = {"disparity": settings.losses.keypoint_disparity, "released": network.variant == "reference"}
        return keypose_losses(outputs, batch.targets, batch.K, size, progress, **options)
    if network.name == "densefusion":
        return densefusion_losses(outputs, batch.targets, network.densefusion.confidence)
    return losses(outputs, batch.targets, network, settings.losses.huber, settings.losses.object_pixels)


def note_step(network: nn.Module, outputs: Mapping[str, Tensor]) -> None:
    """Count a training step of the refiner, which is used once it has been trained."""
    if "refined" in outputs:
        network.get_buffer("refiner_steps").add_(1)


def _depth_source(network: NetworkSettings) -> DepthSource:
    settings = network.densefusion
    if settings.depth == "true":
        return true_depth
    if settings.depth == "raw":
        return raw_depth
    if settings.completion is None or not is_safetensors(settings.completion):
        found = "none" if settings.completion is None else "another file"
        raise InputError("network.densefusion.completion", "a checkpoint of mvtrans or simnet", found)
    completing, theirs = load_network(settings.completion)
    if theirs.network.name not in ("mvtrans", "simnet"):
        raise InputError(settings.completion, "a checkpoint of mvtrans or simnet", theirs.network.name)
    completing.requires_grad_(False)
    return lambda loaded: _predicted_depth(completing, theirs.network, loaded)


def _predicted_depth(network: nn.Module, settings: NetworkSettings, loaded: LoadedViews) -> np.ndarray:
    images = image_tensor(np.stack([view.picture for view in loaded.views]), encoding_of(settings))[None]
    poses = torch.from_numpy(np.stack([view.world_T_camera for view in loaded.views])).float()[None]
    K = torch.from_numpy(np.stack([view.K for view in loaded.views])).float()[None]
    with torch.inference_mode():
        return network(images, poses, K)["depth"][0].float().numpy().copy()


def _changed(settings: Model, **changes: object) -> dict[str, object]:
    return settings.model_dump() | changes


def _with_network(settings: TrainSettings, **changes: object) -> TrainSettings:
    network = NetworkSettings.model_validate(settings.network.model_dump() | changes)
    return settings.model_copy(update={"network": network})
