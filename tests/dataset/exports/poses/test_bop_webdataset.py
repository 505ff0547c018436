"""BOP's shards: the same poses, masks, depth and counts as the scenewise layout, read by the toolkit's definitions."""

from __future__ import annotations

import json
import tarfile

import cv2
import numpy as np
import pytest

from glassware.dataset.exports.run import export
from glassware.dataset.reader import Dataset


def samples(shard):
    """Members of each sample by their endings, in order, as the toolkit's `decode_sample` takes them."""
    found = {}
    with tarfile.open(shard) as tar:
        for entry in tar:
            key, ending = entry.name.split(".", 1)
            file = tar.extractfile(entry)
            assert file is not None
            found.setdefault(key, {})[ending] = file.read()
    return found


def decoded(rle):
    """A mask of uncompressed run lengths, column by column, as `pycoco_utils.rle_to_binary_mask` decodes it."""
    flat = np.repeat(np.arange(len(rle["counts"])) % 2, rle["counts"])
    return flat.reshape(rle["size"], order="F").astype(bool)


def png(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)


@pytest.mark.parametrize("options", [{}, {"vessels_only": True}])
def test_shards_have_what_the_scenewise_layout_has(stored, tmp_path, options):
    export(stored, "bop", tmp_path / "scenes", **options)
    export(stored, "bop-webdataset", tmp_path / "shards", **options)
    scene, folder = tmp_path / "scenes" / "train_pbr" / "000000", tmp_path / "shards" / "train_pbr_web"
    found = samples(folder / "shard-000000.tar")
    assert json.loads((folder / "key_to_shard.json").read_text()) == dict.fromkeys(found, 0)
    assert list(found) == ["000000_000000", "000000_000001"]
    records = {name: json.loads((scene / f"scene_{name}.json").read_text()) for name in ("camera", "gt", "gt_info")}
    for key, members in found.items():
        view = str(int(key.split("_")[1]))
        for name, record in records.items():
            assert json.loads(members[f"{name}.json"]) == record[view]
        assert members["rgb.png"] == (scene / "rgb" / f"{key[7:]}.png").read_bytes()
        np.testing.assert_array_equal(png(members["depth.png"]), png((scene / f"depth/{key[7:]}.png").read_bytes()))
        for kind in ("mask", "mask_visib"):
            for number, rle in json.loads(members[f"{kind}.json"]).items():
                whole = png((scene / kind / f"{key[7:]}_{int(number):06d}.png").read_bytes()) == 255
                np.testing.assert_array_equal(decoded(rle), whole)
    for path in (tmp_path / "scenes" / "models").iterdir():
        assert path.read_bytes() == (tmp_path / "shards" / "models" / path.name).read_bytes()
    for name in ("camera.json", "dataset_info.json"):
        assert (tmp_path / "scenes" / name).read_bytes() == (tmp_path / "shards" / name).read_bytes()


# webdataset 1.0.2 leaves closing the shard to the garbage collector.
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_webdataset_reads_the_shards(stored, tmp_path):
    webdataset = pytest.importorskip("webdataset")
    export(stored, "bop-webdataset", tmp_path / "out")
    shard = tmp_path / "out" / "train_pbr_web" / "shard-000000.tar"
    read = list(webdataset.WebDataset(str(shard), shardshuffle=False).decode("rgb8"))
    assert [sample["__key__"] for sample in read] == ["000000_000000", "000000_000001"]
    for sample, view in zip(read, Dataset.open(stored).views(), strict=True):
        np.testing.assert_array_equal(sample["rgb.png"], view.picture())
        camera = sample["camera.json"]
        np.testing.assert_allclose(np.reshape(camera["cam_K"], (3, 3)), view.camera().K, atol=1e-6)
        for pose, label in zip(sample["gt.json"], view.labels().objects, strict=True):
            turn = np.reshape(pose["cam_R_m2c"], (3, 3))
            np.testing.assert_allclose(turn, np.array(label.camera_T_object)[:3, :3], atol=1e-6)
