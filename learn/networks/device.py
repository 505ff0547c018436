"""Which device a command computes on."""

from __future__ import annotations

import torch

from ...core.errors import InputError


def use(device: str, threads: int | None) -> str:
    """Return torch's name of a device after setting its threads; InputError where there is no such device.

    Parameters
    ----------
    device : str
        Torch's name, or ``auto``: a CUDA device where there is one, else the processor.
    threads : int, optional
        Threads of the processor; all cores unless given.
    """
    if threads is not None:
        torch.set_num_threads(threads)
    if device == "auto":
        return "cuda" if torch.cuda.is_available() else "cpu"
    if device.partition(":")[0] == "meta":  # a device that computes nothing
        raise InputError("--device", "a device of this machine, such as cpu or cuda:0", device)
    try:
        torch.zeros(1, device=device)
    except (RuntimeError, AssertionError, ImportError) as error:  # of an unknown name, or of a device that is not there
        raise InputError("--device", "a device of this machine, such as cpu or cuda:0", device) from error
    return device
