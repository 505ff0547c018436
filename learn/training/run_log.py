"""The log of a run: lines on the console, and curves and images for TensorBoard."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from time import perf_counter

from lightning_fabric import Fabric
from torch import Tensor
from torch.utils.tensorboard.writer import SummaryWriter

from ..data.samples import Batch
from ..data.visualise import sample_picture
from .settings import TrainSettings


class RunLog:
    """Writes the log of a run; only the first of several processes writes."""

    def __init__(
        self, out: Path, start: int, settings: TrainSettings, fabric: Fabric, say: Callable[[str], None]
    ) -> None:
        self._settings, self._say = settings, say
        # Entries of steps after the checkpoint are dropped: those steps are taken again.
        purge = start + 1 if start else None
        self._writer = SummaryWriter(str(out), purge_step=purge) if fabric.is_global_zero else None
        self._since, self._step = perf_counter(), start

    def log_step(
        self,
        step: int,
        total: Tensor,
        terms: Mapping[str, Tensor],
        learning_rate: float,
        norm: Tensor | None,
        batch: Batch,
        outputs: Mapping[str, Tensor],
    ) -> None:
        """Log a step every `log_every` steps, and an image every `pictures_every`.

        The norm of the gradient is that before clipping: where it always is above `optimiser.clip`, the clip sets the
        length of every step.
        """
        if self._writer is None:
            return
        if step % self._settings.log_every == 0 or step == self._settings.steps:
            for name, value in {"total": total, **terms}.items():
                self._writer.add_scalar(f"loss/{name}", float(value.detach()), step)
            self._writer.add_scalar("learning_rate", learning_rate, step)
            if norm is not None:
                self._writer.add_scalar("gradient_norm", float(norm), step)
            seconds = (perf_counter() - self._since) / max(step - self._step, 1)
            self._since, self._step = perf_counter(), step
            left = seconds * (self._settings.steps - step)
            line = f"step {step}/{self._settings.steps}: loss {float(total.detach()):.4g}"
            line += "" if norm is None else f", gradient {float(norm):.3g}"
            self._say(f"{line}, {seconds:.2f} s a step, {left / 60.0:.0f} min left")
        if step % self._settings.pictures_every == 0:
            picture = sample_picture(batch, outputs, self._settings.network)
            self._writer.add_image("sample", picture, step, dataformats="HWC")

    def log_validation(self, step: int, loss: float) -> None:
        """Log the validation loss after a step."""
        if self._writer is not None:
            self._writer.add_scalar("loss/validation", loss, step)
            self._say(f"step {step}: validation loss {loss:.4g}")

    def close(self) -> None:
        """Flush and close the files of TensorBoard."""
        if self._writer is not None:
            self._writer.close()
