from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.dataset.format.exr import channel, read_channel, read_exr, stacked, unstacked, write_exr


def test_one_channel_is_that_of_all(tmp_path):
    path, rng = tmp_path / "a.exr", np.random.default_rng(2)
    channels = {"Z": rng.random((5, 7), np.float32), "N.X": rng.random((5, 7), np.float32).astype(np.float16)}
    write_exr(path, channels)
    for name, values in channels.items():
        found = read_channel(path, name)
        assert found.dtype == values.dtype
        np.testing.assert_array_equal(found, values)
    with pytest.raises(InputError, match=r"a channel Y, found \['N.X', 'Z'\]"):
        read_channel(path, "Y")
    for content in (b"no picture", path.read_bytes()[:-20], None):
        (tmp_path / "b.exr").unlink(missing_ok=True)
        if content is not None:
            (tmp_path / "b.exr").write_bytes(content)
        with pytest.raises(InputError, match=r"b\.exr"):
            read_channel(tmp_path / "b.exr", "Z")


def test_channels_come_back_bit_by_bit_with_infinities(tmp_path, rng):
    Z = rng.random((11, 17)).astype(np.float32)
    Z[3, 4], Z[5, 6] = np.inf, np.nan
    normal = rng.normal(size=(11, 17, 3)).astype(np.float32)
    ids = rng.integers(0, 65536, (11, 17)).astype(np.uint16)
    path = tmp_path / "a.exr"
    write_exr(path, {"Z": Z, "background.Z": Z[::-1], "background.id": ids, **unstacked(normal, "N.XYZ")})
    again = read_exr(path)
    assert sorted(again) == ["N.X", "N.Y", "N.Z", "Z", "background.Z", "background.id"]
    assert {values.dtype for values in again.values()} == {np.dtype(np.float32)}
    np.testing.assert_array_equal(again["Z"].view(np.uint32), Z.view(np.uint32))
    np.testing.assert_array_equal(again["background.Z"], Z[::-1])
    np.testing.assert_array_equal(again["background.id"].astype(np.uint16), ids)
    np.testing.assert_array_equal(stacked(again, "N.XYZ", path), normal)


def test_colour_channels_and_named_layers_live_in_one_file(tmp_path, rng):
    clean, noisy = rng.random((2, 6, 8, 3)).astype(np.float32)
    path = tmp_path / "a.exr"
    write_exr(path, unstacked(clean, "RGB") | unstacked(noisy, "noisy.RGB"))
    again = read_exr(path)
    np.testing.assert_array_equal(stacked(again, "RGB", path), clean)
    np.testing.assert_array_equal(stacked(again, "noisy.RGB", path), noisy)


def test_the_same_channels_give_the_same_bytes_on_one_core_too(tmp_path):
    script = (
        "import sys, pathlib, numpy as np\n"
        "from glassware.dataset.format.exr import read_channel, write_exr\n"
        "Z = np.sin(np.arange(240 * 320, dtype=np.float32)).reshape(240, 320)\n"
        "write_exr(pathlib.Path(sys.argv[1]), {'Z': Z, 'N.X': Z[::-1]})\n"
    )
    one = {min(os.sched_getaffinity(0))}
    for name, limit in (("a", None), ("b", lambda: os.sched_setaffinity(0, one))):
        command = [sys.executable, "-P", "-c", script, str(tmp_path / name)]
        subprocess.run(command, check=True, preexec_fn=limit, timeout=60)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


@pytest.mark.parametrize("keep", [0, 4, 300, -100])
def test_a_damaged_file_is_one_clear_line(tmp_path, keep):
    path = tmp_path / "a.exr"
    write_exr(path, {"Z": np.random.default_rng(1).random((64, 64)).astype(np.float32)})
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(InputError) as error:
        read_exr(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_a_missing_file_or_channel_is_one_clear_line(tmp_path):
    with pytest.raises(InputError, match="a readable EXR file"):
        read_exr(tmp_path / "none.exr")
    with pytest.raises(InputError, match=r"a channel N\.X"):
        channel({"Z": np.zeros((2, 2))}, "N.X", tmp_path / "a.exr")


def test_channels_of_two_shapes_are_a_fault_of_ours(tmp_path):
    with pytest.raises(ValueError, match="one shape"):
        write_exr(tmp_path / "a.exr", {"Z": np.zeros((2, 2)), "R": np.zeros((2, 3))})
