"""A page of a converted data set shows what that has, and nothing that it has not."""

from __future__ import annotations

import re

import numpy as np
import pytest

from glassware.dataset.commands.convert import main as convert
from glassware.dataset.commands.view import main
from glassware.dataset.reader import Dataset


@pytest.fixture
def shown(makers, tmp_path, page):
    """(name of a maker) -> the data set that its folder became, and its page."""

    def show(write):
        getattr(makers, write)(tmp_path / "source", 2)  # frames, or the version
        assert convert([str(tmp_path / "source"), "--out", str(tmp_path / "out"), "--rows", "0"]) == 0
        assert main([str(tmp_path / "out"), "--save", str(tmp_path / "page.html")]) == 0
        return Dataset.open(tmp_path / "out"), page(tmp_path / "page.html")

    return show


def test_a_pair_with_depth_and_poses_has_maps_boxes_and_points(shown, unpack):
    data, found = shown("keypose")
    view, record = data.views()[0], found.record("view-0-0")
    assert set(record["pictures"]) == {"left", "right"}
    maps = found.maps()
    np.testing.assert_array_equal(unpack(maps["left/ids"]["data"]), view.instances())
    Z = np.nan_to_num(view.depth())
    np.testing.assert_allclose(unpack(maps["left/depth"]["data"]) * maps["left/depth"]["step"], Z, atol=1e-4)
    (item,) = view.partial_labels().objects
    (shape,) = record["shapes"]["left"]
    assert shape["modal"] == pytest.approx(item.box2d)
    assert len(shape["keypoints"]) == len(item.keypoints)
    points = unpack(record["cloud"]["points"]).T
    np.testing.assert_allclose(points, view.points("world"), atol=1e-5)
    (body,) = found.record("scene-0")["bodies"]
    expected = view.camera().world_T_camera @ np.asarray(item.camera_T_object)
    np.testing.assert_allclose(np.reshape(body["pose"], (4, 4)), expected, atol=1e-9)


def test_what_no_view_has_is_named(shown, unpack):
    data, found = shown("trans10k")
    record = found.record("view-0-0")
    assert {"depth", "poses", "intrinsics", "stereo"} <= set(record["lacks"])
    assert (set(record["pictures"]), record["cloud"], record["shapes"]["left"]) == ({"left"}, None, [])
    classes = found.maps()["left/classes"]
    np.testing.assert_array_equal(unpack(classes["data"]), data.views()[0].classes())
    assert classes["names"][7][0] == "cup"


@pytest.mark.slow
@pytest.mark.parametrize("write", ["keypose", "trans10k"])
@pytest.mark.parametrize("tab", ["picture", "maps", "space", "objects"])
def test_no_tab_fails(shown, browser, write, tab):
    _, found = shown(write)
    address = f"tab={tab}&eye=right&map=depth&show=keypoints,boxes,axes&solid=cameras,cloud,boxes,names"
    text = browser(found.path, address, "--dump-dom")
    assert f'data-ready="0-0 {tab}"' in text, re.findall(r'data-failed="[^"]*"', text)
    assert "data-failed" not in text


def test_rerun_is_for_rendered_data_sets(makers, tmp_path, capsys):
    pytest.importorskip("rerun")
    makers.trans10k(tmp_path / "source", 1)
    assert convert([str(tmp_path / "source"), "--out", str(tmp_path / "out"), "--rows", "0"]) == 0
    assert main([str(tmp_path / "out"), "--save", str(tmp_path / "out.rrd")]) == 2
    assert "expected a rendered data set for Rerun" in capsys.readouterr().err
    assert not (tmp_path / "out.rrd").exists()
