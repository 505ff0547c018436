"""What is there and verifies is kept, what does not is made again, and nothing is mixed."""

from __future__ import annotations

import json
import shutil

import pytest

from glassware.dataset.commands.build_dataset import main


@pytest.fixture
def data(undisturbed, tmp_path):
    """A copy of the data set."""
    return shutil.copytree(undisturbed, tmp_path / "data")


@pytest.mark.slow
def test_scenes_that_are_whole_are_kept_and_damaged_ones_made_again(builds, undisturbed, content, data):
    scenes = data / "scenes"
    kept = (scenes / "000001" / "000" / "left.png").stat().st_ino
    (scenes / "000000" / "000" / "left.exr").unlink()
    damaged = scenes / "000002" / "000" / "geometry.exr"
    damaged.write_bytes(damaged.read_bytes()[:-1] + b"\0")  # of the same size
    shutil.rmtree(scenes / "000003")
    (scenes / "000004" / "extra").write_text("x")
    ended = builds.run(data, "--workers", 2)
    assert ended.returncode == 0, ended.stderr
    assert "4 scenes to render, 2 kept" in ended.stdout
    assert f"scene 2 is rendered again: {damaged}: expected SHA-256" in ended.stdout
    assert (scenes / "000001" / "000" / "left.png").stat().st_ino == kept
    assert content(data) == content(undisturbed)


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (("--seed", 4), ("seed 3 (requested: 4)", "--overwrite")),
        (("--spp", 4), ("picture.spp 2 (requested: 4)",)),
        (
            ("--spp", 4, "--vessel-count", 1, 2),
            ("picture.spp 2 (requested: 4)", "vessel_count [1, 1] (requested: [1, 2])"),
        ),
    ],
    ids=["seed", "a setting", "two settings"],
)
def test_another_seed_or_setting_is_refused_with_what_differs(refused, data, more, says):
    refused(data, *more, says=says)


@pytest.mark.slow
def test_another_version_of_a_package_is_refused_with_what_differs(refused, data):
    head = json.loads((data / "dataset.json").read_text())
    head["versions"]["numpy"] = "1.0"
    (data / "dataset.json").write_text(json.dumps(head))
    refused(data, scenes="0:7", says=("versions.numpy '1.0'",))


@pytest.mark.slow
def test_overwrite_of_some_scenes_does_not_mix_settings_and_of_all_starts_again(builds, data):
    ended = builds.run(data, "--overwrite", "--spp", 4, scenes="0:2")
    assert ended.returncode == 2
    assert "picture.spp 2 (requested: 4)" in ended.stderr
    assert len(list((data / "scenes").iterdir())) == 6
    ended = builds.run(data, "--overwrite", "--spp", 4)
    assert ended.returncode == 0, ended.stderr
    assert "6 scenes to render, 0 kept" in ended.stdout
    assert json.loads((data / "dataset.json").read_text())["config"]["picture"]["spp"] == 4


def test_the_log_has_a_line_for_each_scene(undisturbed):
    lines = [json.loads(line) for line in (undisturbed / "build.jsonl").read_text().splitlines()]
    assert [line["event"] for line in lines] == ["start", *["scene"] * 6, "end"]
    for line in lines[1:-1]:
        assert line["state"] == "made"
        assert line["views"] == 1
        assert line["spp"] == 2.0
        assert {"description", "loading", "picture", "geometry", "labels", "writing"} < line["seconds"].keys()
        assert sum(line["seconds"].values()) == pytest.approx(line["total"])
        # A process with the renderer loaded holds between 50 MB and the machine's memory.
        assert 50 < line["resident"] < 1e5
        assert 50 < line["peak"] < 1e5


def test_the_head_says_what_the_scenes_were_made_from(undisturbed):
    head = json.loads((undisturbed / "dataset.json").read_text())
    assert head["scenes"] == "0:6"
    assert set(head["hashes"]) == {"config", "backend", "assets"}
    assert head["versions"]["llvm"].split(".")[0].isdigit()
    manifest = json.loads((undisturbed / "manifest.json").read_text())
    assert [item["path"] for item in manifest["files"]] == ["a.hdr", "b.hdr", "c.hdr"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--scenes", "5:5"), "expected ranges that hold a scene, at most 999999, found '5:5'"),
        (("--scenes", "all"), "expected scenes such as 0:2000 or 3,7,10:20, found 'all'"),
        ((), "--scenes: expected scenes such as 0:2000, or --count 2000, found none"),
        (("--scenes", "0:3", "--shard", "4/3"), "--shard: expected i/n with i from 1 to n, such as 1/3, found '4/3'"),
        (("--scenes", "0:3", "--workers", "0"), "workers: expected greater than or equal to 1, found 0"),
        (("--scenes", "0:3", "--address", "auto"), "address: expected --executor ray with it"),
        (
            ("--scenes", "0:3", "--hdri-dir", "nowhere"),
            "environment.hdri_dir: expected a folder of environment maps, found none at nowhere",
        ),
    ],
)
def test_a_wrong_request_is_one_line_and_writes_nothing(capsys, tmp_path, arguments, says):
    assert main([*arguments, "--out", str(tmp_path / "data")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line
    assert not (tmp_path / "data").exists()


@pytest.mark.slow
def test_a_folder_that_holds_another_scene_is_no_scene(builds, undisturbed, content, tmp_path):
    data = shutil.copytree(undisturbed, tmp_path / "data")
    (data / "scenes/000002").rename(data / "scenes/000007")
    refused = builds.run(data)
    assert refused.returncode == 2
    assert "scenes/000007/views.json: expected the views of scene 7, found those of scene 2" in refused.stderr
    (data / "scenes/000007").rename(data / "scenes/000001.away")
    shutil.rmtree(data / "scenes/000001")
    (data / "scenes/000001.away").rename(data / "scenes/000001")
    mended = builds.run(data)
    assert mended.returncode == 0, mended.stderr
    assert "scene 1 is rendered again" in mended.stdout
    assert content(data) == content(undisturbed)


def test_overwriting_and_retrying_are_not_asked_for_at_once(refused, data):
    refused(data, "--overwrite", "--retry-failed", says=("--retry-failed: expected it without --overwrite",))


@pytest.mark.parametrize(
    ("option", "says"),
    [
        (("--name", "other"), "name 'glassware' (requested: 'other')"),
        (("--devices", "banana"), "devices"),
    ],
)
def test_what_would_change_the_data_set_or_means_nothing_is_refused(refused, data, option, says):
    refused(data, *option, says=(says,))
