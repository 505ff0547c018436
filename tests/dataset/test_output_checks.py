from __future__ import annotations

import pytest

from glassware.core.errors import InputError
from glassware.dataset.format.dataset_file import new_head, write_head
from glassware.dataset.output_checks import check_request

CONFIG = {"cameras": {"preset": None, "views": 2}, "vessel_count": [1, 1]}


@pytest.fixture
def root(tmp_path):
    """A data set that was made with these settings and seed 3."""
    write_head(tmp_path, new_head("n", 3, CONFIG, {}, "llvm_ad_rgb"))
    return tmp_path


def test_a_setting_that_follows_from_others_is_called_not_set(root):
    wanted = {"cameras": {"preset": "d435", "views": 2, "noise": 0.1}, "vessel_count": None}
    with pytest.raises(InputError) as error:
        check_request(root, 3, wanted)
    assert str(error.value).endswith(
        "found cameras.noise not set (requested: 0.1), cameras.preset not set (requested: 'd435'), "
        "vessel_count [1, 1] (requested: not set)"
    )


def test_equal_seed_and_settings_are_taken(root):
    check_request(root, 3, CONFIG)
