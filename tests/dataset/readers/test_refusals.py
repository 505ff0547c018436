"""What is wrong with a folder is one line with what was expected; a damaged view does not hide the others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.dataset.readers.picture_files import read_indices
from glassware.dataset.readers.recognition import open_source
from glassware.dataset.readers.text_proto import read_text_proto


def refused(root: Path, match: str) -> None:
    with pytest.raises(InputError, match=match) as caught:
        open_source(root)
    assert "\n" not in str(caught.value)


def unreadable(root: Path, match: str) -> None:
    _, collection = open_source(root)
    with pytest.raises(InputError, match=match) as caught:
        collection.entries[0].read()
    assert "\n" not in str(caught.value)


def test_a_folder_that_is_none(tmp_path):
    refused(tmp_path, r"expected a data set of one of KeyPose \(TOD\), .*, found none of them")
    refused(tmp_path / "absent", "expected the folder of a data set, found none")


def test_a_folder_that_is_two(makers, tmp_path):
    makers.keypose(tmp_path / "a", frames=1)
    makers.bop(tmp_path / "b", images=1)
    refused(tmp_path, r"expected one data set, such as one of its folders, found 2: KeyPose .* and BOP ")


def test_half_a_download_names_what_is_missing(makers, tmp_path):
    folder = makers.keypose(tmp_path, frames=3)
    (folder / "000001_R.png").unlink()
    _, collection = open_source(tmp_path)
    assert [(item.name[-6:], item.reason) for item in collection.left_out] == [
        ("000001", "expected 000001_R.png, found none")
    ]
    assert len(collection.entries) == 2
    for path in folder.glob("*_R.png"):
        path.unlink()
    refused(tmp_path, r"found none complete of 3; the first, .*000000: expected 000000_R.png, found none")


@pytest.mark.parametrize(
    ("write", "calibration", "match"),
    [
        ("keypose", "*_[LR].pbtxt", "expected calibration and keypoints of each picture"),
        ("ttd", "cameras_params.yml", "expected calibration of its cameras, cameras_params.yml, found none"),
        ("clearpose", "metadata.mat", "expected calibration of its pictures, metadata.mat, found none"),
        ("transcg", "*.npy", "expected camera_intrinsics/1-camIntrinsics-D435.npy, found none"),
    ],
)
def test_pictures_without_calibration(makers, tmp_path, write, calibration, match):
    getattr(makers, write)(tmp_path)
    for path in tmp_path.rglob(calibration):
        path.unlink()
    refused(tmp_path, match)


def test_eyes_of_different_size(makers, tmp_path):
    folder = makers.keypose(tmp_path, frames=1)
    makers.save(folder / "000000_R.png", makers.picture(0, 32, 24))
    unreadable(tmp_path, "expected two eyes of one size, 64 x 48 px as the left one, found 32 x 24 px in the right one")


def test_a_picture_of_another_size_than_its_camera(makers, tmp_path):
    folder = makers.keypose(tmp_path, frames=1)
    for eye in "LR":
        makers.save(folder / f"000000_{eye}.png", makers.picture(0, 32, 24))
    unreadable(tmp_path, "expected a picture of 64 x 48 px, as its camera is, found 32 x 24 px")


def test_a_right_camera_that_does_not_fit_the_baseline(makers, tmp_path):
    folder = makers.keypose(tmp_path, frames=1)
    (folder / "000000_R.pbtxt").write_text((folder / "000000_L.pbtxt").read_text())
    unreadable(tmp_path, r"expected a right camera at \(0.1200, 0, 0\) m")


def test_a_picture_that_is_cut_short(makers, tmp_path):
    folder = makers.keypose(tmp_path, frames=1)
    path = folder / "000000_L.png"
    path.write_bytes(path.read_bytes()[:-300])
    unreadable(tmp_path, "000000_L.png: expected a whole PNG file, found a part of one")


def test_pickles_are_refused(tmp_path):
    (tmp_path / "100.pickle.zstd").write_bytes(b"\x28\xb5\x2f\xfd")
    refused(tmp_path, "found pickles, which run code when they are read and are refused")


def test_an_array_that_is_a_pickle_is_refused(makers, tmp_path):
    makers.transcg(tmp_path)
    np.save(tmp_path / "camera_intrinsics" / "1-camIntrinsics-D435.npy", np.array([{}], object), allow_pickle=True)
    refused(tmp_path, "expected an array of numbers, and no pickle")


def test_paths_that_lead_out_of_a_data_set_are_refused(makers, tmp_path):
    folder = makers.ttd(tmp_path / "data")
    path = folder / "train.json"
    path.write_text(path.read_text().replace("scene/left.png", "../../../etc/passwd"))
    refused(tmp_path / "data", "expected paths below the data set, found ../../../etc/passwd")


def test_a_data_set_of_ours_is_refused(tmp_path):
    (tmp_path / "dataset.json").write_text("{}")
    refused(tmp_path, "expected another project's data set, found one of glassware")


def test_a_shard_that_is_cut_short_is_refused(makers, tmp_path):
    path = makers.bop_shards(tmp_path)
    path.write_bytes(path.read_bytes()[:3000])
    refused(tmp_path, r"shard-000000.tar: expected a whole tar file")


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("a { b: 1", "expected a closed group a, found the end of the file"),
        ("a: 1 }", "found a } that closes no group"),
        ("a: 1x", "a: expected a number, found 1x"),
        ("a: $", "expected protocol buffers as text, found "),
    ],
)
def test_text_that_is_no_protocol_buffer(tmp_path, text, match):
    path = tmp_path / "x.pbtxt"
    path.write_text(text)
    with pytest.raises(InputError, match=match):
        read_text_proto(path)


def test_a_palette_with_equal_colours_is_refused(makers, tmp_path):
    path = tmp_path / "mask.png"
    path.write_bytes(makers.indexed_png(np.zeros((4, 4), np.uint8), [(0, 0, 0), (0, 0, 0), (1, 1, 1)]))
    with pytest.raises(InputError, match="expected a palette with 3 different colours, found two equal ones"):
        read_indices(path, 3)
