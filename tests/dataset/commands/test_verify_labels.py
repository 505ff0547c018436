"""`glassware verify --labels` finds labels that cannot be right, which the checksums cannot."""

from __future__ import annotations

import json

import pytest

from glassware.dataset.commands.verify import main
from glassware.dataset.format.checksums import write_checksums


def test_correct_labels_pass(proven, capsys):
    assert main([str(proven), "--labels"]) == 0
    assert "1 scene, no faults, labels correct" in capsys.readouterr().out


def _masked_wrongly(label: dict) -> None:
    label["mask_seen"]["counts"] += "1"


def _shifted(label: dict) -> None:
    label["camera_T_object"][0][3] += 0.01


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (_shifted, "labels.json: poses: object 2 camera_T_object: expected"),
        (_masked_wrongly, "labels.json: object 2 mask_seen: expected a mask"),
    ],
)
def test_a_damaged_label_is_named_and_the_exit_code_is_1(copy, capsys, damage, says):
    folder = copy / "scenes/000000"
    path = folder / "000/labels.json"
    content = json.loads(path.read_text())
    damage(content["objects"][0])
    path.write_text(json.dumps(content))
    (folder / "checksums.json").unlink()
    write_checksums(folder)
    assert main([str(copy)]) == 0  # the files are intact and of the right form
    assert main([str(copy), "--labels"]) == 1
    lines = capsys.readouterr().out.splitlines()[1:]
    assert any(says in line for line in lines), lines
    assert all("000/000/labels.json" in line for line in lines)
