"""Training by two processes, each with half of a batch."""

from __future__ import annotations

import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
import torch
import yaml
from lightning_fabric import Fabric

from glassware.core.exit_codes import WorkFailed
from glassware.learn.data.samples import Batch
from glassware.learn.training.checkpoint import load_checkpoint
from glassware.learn.training.run import check_finite, validate
from glassware.learn.training.train_state import set_up_training


@pytest.mark.slow
def test_two_processes_train_and_validate_as_one(settings, rendered, tmp_path):
    one = settings.model_copy(update={"steps": 3, "validate_samples": 3})
    two = one.model_copy(update={"machine": one.machine.model_copy(update={"devices": "2", "strategy": "ddp"})})
    (tmp_path / "run.yaml").write_text(yaml.safe_dump(two.model_dump(mode="json", exclude_defaults=True)))
    command = [str(Path(sys.executable).with_name("glassware")), "train", str(rendered), "--out", str(tmp_path / "run")]
    done = subprocess.run(
        [*command, "--config", str(tmp_path / "run.yaml")], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("step 3: validation loss") == 1
    kept = load_checkpoint(tmp_path / "run" / "last.safetensors")
    state = set_up_training(kept.settings.model_copy(update={"machine": one.machine}), rendered, tmp_path / "again")
    # Sums of float32 losses in another order.
    assert validate(state, kept.ema) == pytest.approx(kept.best_loss, rel=1e-5)


def _looks_at_its_loss(fabric: Fabric, folder: Path) -> None:
    loss = torch.tensor(float("nan") if fabric.global_rank == 1 else 1.0)
    names = (f"sample {fabric.global_rank}",)
    batch = Batch(names, torch.zeros(1), torch.zeros(1), torch.zeros(1), {}, (None,))
    try:
        check_finite(fabric, loss, torch.tensor(2.0), {"depth": loss}, 7, batch)
    except WorkFailed as error:
        (folder / str(fabric.global_rank)).write_text(str(error))


@pytest.mark.slow
def test_a_loss_that_is_no_number_in_one_process_stops_both(tmp_path):
    fabric = Fabric(accelerator="cpu", devices=2, strategy="ddp_fork")
    fabric.launch(partial(_looks_at_its_loss, folder=tmp_path))
    first, second = ((tmp_path / str(rank)).read_text() for rank in range(2))
    assert "gradient of step 7 on sample 0: expected a finite norm, found another, of another process" in first
    assert "loss of step 7 on sample 1: expected a finite number, found nan (depth nan)" in second
