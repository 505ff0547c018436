"""`glassware verify --labels` finds labels that contradict the geometry, which the checksums cannot."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from glassware.dataset.commands.verify import main
from glassware.dataset.format.checksums import write_checksums


@pytest.fixture
def data(stored) -> Path:
    """The stored closed-form scene, which has no files of layers and refraction, and says so."""
    _edit(stored / "scenes/000000/scene.json", lambda scene: scene["picture"].update(layers=0, refraction=False))
    return stored


def _edit(path: Path, change: Callable[[dict], None]) -> None:
    """Change a JSON file of the scene, and give it the right checksum."""
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))
    folder = next(parent for parent in path.parents if parent.name == "000000" and parent.parent.name == "scenes")
    (folder / "checksums.json").unlink()
    write_checksums(folder)


def _shifted(label: dict) -> None:
    label["camera_T_object"][0][3] += 0.01


def _counted_wrongly(label: dict) -> None:
    label["pixels"]["visible"] -= 1
    label["pixels"]["seen_through"] += 1


def _boxed_wrongly(label: dict) -> None:
    label["box2d"]["modal"][2] += 1.0


def _masked_wrongly(label: dict) -> None:
    label["mask_seen"]["counts"] += "1"


def _relabelled(label: dict) -> None:
    label["name"] = "another"


def test_correct_labels_pass(data, capsys):
    assert main([str(data), "--labels"]) == 0
    assert "1 scene, no faults, labels correct" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (_shifted, "labels.json: poses: object 2 camera_T_object: expected"),
        (_counted_wrongly, "labels.json: masks: object 2 pixels: expected"),
        (_boxed_wrongly, "labels.json: boxes: object 2 box2d.modal: expected"),
        (_masked_wrongly, "labels.json: object 2 mask_seen: expected a mask"),
        (_relabelled, "labels.json: objects: labels: expected"),
    ],
)
def test_a_damaged_label_is_named_and_the_exit_code_is_1(data, capsys, damage, says):
    _edit(data / "scenes/000000/001/labels.json", lambda labels: damage(labels["objects"][0]))
    assert main([str(data)]) == 0  # the files are intact and of the right form
    assert main([str(data), "--labels"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert any(says in line for line in lines), lines
    assert all("000/001/labels.json" in line for line in lines[1:])
