from __future__ import annotations

import numpy as np
import pytest
import torch

from glassware.core.errors import InputError
from glassware.learn.data.joined import JoinedSamples
from glassware.learn.data.samples import DEPTH_QUANTILES, SampleDataset
from glassware.learn.data.settings import ViewSettings
from glassware.learn.targets.encoding import CORRECTED


def samples(root, size=(64, 96), seed=0) -> SampleDataset:
    return SampleDataset(root, "all", ViewSettings(size=size), CORRECTED, seed=seed)


def test_samples_of_several_data_sets_follow_each_other(rendered):
    one, other = samples(rendered), samples(rendered, seed=1)
    both = JoinedSamples([one, other])
    assert len(both) == 20
    for index, (part, number) in {0: (one, 0), 9: (one, 9), 10: (other, 0), 19: (other, 9)}.items():
        found, expected = both[index, 3], part[number, 3]
        assert found.name == expected.name
        torch.testing.assert_close(found.images, expected.images)
        torch.testing.assert_close(found.world_T_camera, expected.world_T_camera)
    with pytest.raises(IndexError):
        both[20, 0]
    assert both.depth_range(20) == pytest.approx(one.depth_range(10), rel=1e-3)


def test_a_few_near_views_of_one_data_set_do_not_spread_the_planes_of_all(rendered):
    class Near(SampleDataset):
        def object_depths(self, max_views):
            return super().object_depths(max_views) / 4.0

    far = samples(rendered)
    near = Near(rendered, "all", ViewSettings(size=(64, 96)), CORRECTED)
    near._references = near._references[:1]
    many = JoinedSamples([far] * 30 + [near])
    depths = [far.object_depths(10)] * 30 + [near.object_depths(1)]
    pooled = np.quantile(np.concatenate(depths), DEPTH_QUANTILES)
    assert many.depth_range(301) == pytest.approx(tuple(pooled))
    assert many.depth_range(301)[0] > 2.0 * near.depth_range()[0]


def test_pictures_of_several_sizes_are_refused(rendered):
    with pytest.raises(InputError, match=r"views\.size: expected a size .* found 96 x 64 px in .*, 128 x 96 px in "):
        JoinedSamples([samples(rendered), samples(rendered, size=None)])
