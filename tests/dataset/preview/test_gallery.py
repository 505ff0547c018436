from __future__ import annotations

import numpy as np

from glassware.dataset.format.pictures import write_png
from glassware.dataset.preview.gallery import gallery


def _scene(root, number, level):
    folder = root / "scenes" / f"{number:06d}" / "000"
    folder.mkdir(parents=True)
    write_png(folder / "left.png", np.full((24, 32, 3), level, np.uint8))


def test_a_gallery_shows_the_first_view_of_each_scene(tmp_path):
    for number, level in enumerate((40, 120, 200)):
        _scene(tmp_path, number, level)
    sheet = gallery(tmp_path)
    assert sheet is not None
    # Cells of 240 px and gaps of 6; a picture of 32 x 24 px becomes 240 x 180.
    for column, level in enumerate((40, 120, 200)):
        cell = sheet[6 : 6 + 180, 6 + column * 246 : 6 + column * 246 + 240]
        assert (cell == level).all()


def test_a_gallery_of_many_scenes_is_bounded_and_has_the_first_and_the_last(tmp_path):
    for number in range(100):
        _scene(tmp_path, number, 2 * number)
    sheet = gallery(tmp_path)
    assert sheet is not None
    assert sheet[6, 6, 0] == 0
    assert sheet[-6 - 22 - 90, -6 - 120, 0] == 198
    assert sheet.shape == (6 * (180 + 22 + 6) + 6, 8 * 246 + 6, 3)


def test_without_scenes_there_is_none(tmp_path):
    assert gallery(tmp_path) is None
