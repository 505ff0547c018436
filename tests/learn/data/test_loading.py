from __future__ import annotations

import pickle

import pytest
import torch

from glassware.core.errors import InputError
from glassware.learn.data.loading import load_batches
from glassware.learn.data.samples import SampleDataset, collate
from glassware.learn.data.settings import ViewSettings
from glassware.learn.targets.encoding import CORRECTED


@pytest.mark.parametrize("workers", [0, 1, 2])
def test_batches_are_those_of_the_samples(rendered, workers):
    data = SampleDataset(rendered, "all", ViewSettings(), CORRECTED)
    order = [[(0, 0), (3, 1)], [(5, 0)]]
    found = list(load_batches(data, order, workers))
    assert len(found) == 2
    for batch, items in zip(found, order, strict=True):
        assert torch.equal(batch.images, collate([data[item] for item in items]).images)


def test_more_processes_than_cores_are_taken_without_a_warning(rendered, monkeypatch):
    monkeypatch.setattr("torch._utils.cpu_count", lambda: 1)
    data = SampleDataset(rendered, "all", ViewSettings(), CORRECTED)
    assert len(list(load_batches(data, [[(0, 0)]], 2))) == 1


@pytest.mark.parametrize("workers", [0, 1, 2])
def test_a_sample_that_cannot_be_used_is_one_line_from_any_process(rendered, workers):
    data = SampleDataset(rendered, "all", ViewSettings(count=9), CORRECTED)
    with pytest.raises(InputError) as raised:
        list(load_batches(data, [[(0, 0)]], workers))
    assert "expected 8 others by the rule distance" in str(raised.value)
    assert "\n" not in str(raised.value)


def test_an_input_error_is_the_same_in_another_process():
    error = InputError("here", "this", "that\nand more")
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is InputError
    assert str(again) == str(error) == "here: expected this, found that and more"
