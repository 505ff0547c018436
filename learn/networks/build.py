"""Build the network of given settings, and select the device that it runs on."""

from __future__ import annotations

import torch

from ...core.errors import InputError
from .baselines.densefusion import DenseFusion
from .baselines.keypose import KeyPose
from .baselines.simnet import SimNet
from .mvtrans import MVTrans
from .reference import ReferenceMVTrans
from .settings import NetworkSettings

Network = MVTrans | ReferenceMVTrans | SimNet | KeyPose | DenseFusion


def build_network(settings: NetworkSettings) -> Network:
    """Return a network with new weights, drawn from torch's global generator."""
    released = settings.variant == "reference"
    if settings.name == "simnet":
        return SimNet(settings.simnet, released=released)
    if settings.name == "keypose":
        return KeyPose(settings.keypose, released=released)
    if settings.name == "densefusion":
        return DenseFusion(settings.densefusion, released=released)
    return ReferenceMVTrans() if released else MVTrans(settings)


def select_device(device: str, threads: int | None) -> str:
    """Set the number of CPU threads and return torch's name of a device; InputError where the device is missing.

    Parameters
    ----------
    device : str
        Torch's name, or ``auto``: CUDA where available, otherwise the CPU.
    threads : int, optional
        CPU threads of torch; all cores by default.
    """
    if threads is not None:
        torch.set_num_threads(threads)
    if device == "auto":
        return "cuda" if torch.cuda.is_available() else "cpu"
    if device.partition(":")[0] == "meta":  # a device that computes nothing
        raise InputError("--device", "a device of this machine, such as cpu or cuda:0", device)
    try:
        torch.zeros(1, device=device)
    except (RuntimeError, AssertionError, ImportError) as error:  # an unknown name, or a missing device
        raise InputError("--device", "a device of this machine, such as cpu or cuda:0", device) from error
    return device
