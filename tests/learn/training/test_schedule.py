from __future__ import annotations

import pytest

from glassware.learn.training.schedule import StepBatches, learning_rate_at
from glassware.learn.training.settings import OptimiserSettings


@pytest.mark.parametrize("count", [5, 8, 30])
def test_every_epoch_goes_through_every_sample_once(count):
    steps = 3 * count
    pairs = [pair for batch in StepBatches(count, 4, range(steps), seed=1) for pair in batch]
    assert len(pairs) == 4 * steps
    for epoch in range(12):
        assert sorted(index for index, draw in pairs if draw == epoch) == list(range(count))
        assert {draw for _, draw in pairs[epoch * count : (epoch + 1) * count]} == {epoch}
    assert [index for index, draw in pairs if draw == 0] != [index for index, draw in pairs if draw == 1]


def test_a_run_that_goes_on_takes_what_it_would_have_taken():
    whole = list(StepBatches(7, 3, range(20), seed=2))
    assert list(StepBatches(7, 3, range(11, 20), seed=2)) == whole[11:]
    assert list(StepBatches(7, 3, range(20), seed=3)) != whole


def test_processes_share_a_batch():
    whole = list(StepBatches(7, 4, range(6), seed=2))
    parts = [list(StepBatches(7, 4, range(6), 2, rank, 2)) for rank in range(2)]
    for step, batch in enumerate(whole):
        assert sorted(parts[0][step] + parts[1][step]) == sorted(batch)


def test_the_rate_rises_and_falls_as_its_schedule_says():
    def rates(**changes) -> list[float]:
        settings = OptimiserSettings(learning_rate=1.0, **changes)
        return [learning_rate_at(step, 100, settings) for step in (0, 1, 50, 99)]

    assert rates(schedule="constant", warmup=4) == [0.25, 0.5, 1.0, 1.0]
    assert rates(schedule="polynomial", warmup=0) == pytest.approx([1.0, 0.99**0.9, 0.5**0.9, 0.01**0.9])
    cosine = rates(schedule="cosine", warmup=0)
    assert cosine[0] == 1.0
    assert cosine[2] == pytest.approx(0.5)
    assert 0.0 < cosine[3] < 1e-3
