from __future__ import annotations

import hashlib
import os
import re
from pathlib import Path

import pytest

from glassware.core.errors import InputError
from glassware.dataset.builds import manifest
from glassware.procedural.scene.settings import SceneSettings


@pytest.fixture
def assets(tmp_path, monkeypatch):
    """Settings with two folders of files; the cache of digests is empty."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    for name in ("hdri/a.hdr", "hdri/b.exr", "hdri/readme.txt", "meshes/mug/mug.obj", "meshes/mug/mug.mtl"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(name.encode())
    folders = {"environment": {"hdri_dir": tmp_path / "hdri"}, "mesh_dir": tmp_path / "meshes"}
    return SceneSettings.model_validate(folders)


def test_all_files_that_a_scene_may_draw_from_are_in_it(assets):
    found = manifest.scan(assets)
    assert [(item.folder, item.path) for item in found.files] == [
        ("hdri_dir", "a.hdr"),
        ("hdri_dir", "b.exr"),
        ("mesh_dir", "mug/mug.mtl"),
        ("mesh_dir", "mug/mug.obj"),
    ]
    assert found.files[0].sha256 == hashlib.sha256(b"hdri/a.hdr").hexdigest()


@pytest.mark.parametrize(
    ("change", "name", "says"),
    [
        (lambda root: (root / "hdri/b.exr").unlink(), "hdri/b.exr", "expected the asset that manifest.json names"),
        (lambda root: (root / "hdri/c.hdr").write_bytes(b"c"), "hdri/c.hdr", "expected only assets that"),
        (
            lambda root: (root / "meshes/mug/mug.mtl").write_bytes(b"other"),
            "meshes/mug/mug.mtl",
            "expected the asset as manifest.json has it",
        ),
    ],
    ids=["missing", "new", "changed"],
)
def test_a_file_that_is_not_as_it_was_is_named(assets, tmp_path, change, name, says):
    kept = manifest.scan(assets)
    change(tmp_path)
    with pytest.raises(InputError, match=re.escape(str(tmp_path / name)) + f": {says}"):
        manifest.check_manifest(kept, manifest.scan(assets), assets)


def test_files_are_read_once_and_known_by_size_and_time_afterwards(assets, tmp_path, monkeypatch):
    read: list[Path] = []
    digest = manifest.file_digest
    monkeypatch.setattr(manifest, "file_digest", lambda path: read.append(path) or digest(path))
    first = manifest.scan(assets)
    assert len(read) == 4
    assert manifest.scan(assets) == first
    assert len(read) == 4
    os.utime(tmp_path / "hdri/a.hdr", ns=(1, 1))  # touched: read again, and found to be the same
    assert manifest.scan(assets) == first
    assert read[4:] == [tmp_path / "hdri/a.hdr"]


@pytest.mark.parametrize("cache", [b"", b"[]", b'{"x": 3}', b"\xff"])
def test_a_damaged_cache_only_costs_the_reading(assets, tmp_path, cache):
    first = manifest.scan(assets)
    (tmp_path / "cache/glassware/digests.json").write_bytes(cache)
    assert manifest.scan(assets) == first


def test_a_file_that_changes_while_a_worker_lives_is_named(assets, tmp_path):
    before = manifest.stamps(assets)
    manifest.check_unchanged(before)
    (tmp_path / "hdri/a.hdr").write_bytes(b"longer than before")
    with pytest.raises(InputError, match=r"a\.hdr: expected the asset as it was"):
        manifest.check_unchanged(before)
    (tmp_path / "hdri/a.hdr").unlink()
    with pytest.raises(InputError, match=r"a\.hdr: expected the asset that the worker found"):
        manifest.check_unchanged(before)


def test_a_manifest_reads_back_and_none_is_none(assets, tmp_path):
    assert manifest.read_manifest(tmp_path) is None
    found = manifest.scan(assets)
    manifest.write_manifest(tmp_path, found)
    assert manifest.read_manifest(tmp_path) == found


def test_the_poses_of_cameras_and_the_tables_own_pictures_are_in_it_as_well(assets, tmp_path):
    poses = tmp_path / "robot" / "poses.txt"
    poses.parent.mkdir()
    poses.write_text("1 0 0 0\n")
    (tmp_path / "tops").mkdir()
    (tmp_path / "tops" / "oak.png").write_bytes(b"oak")
    groups = {"cameras": {"poses": poses}, "table": {"texture_dir": tmp_path / "tops"}}
    settings = SceneSettings.model_validate(groups)
    kept = manifest.scan(settings)
    assert [(item.folder, item.path) for item in kept.files] == [
        ("cameras.poses", "poses.txt"),
        ("table.texture_dir", "oak.png"),
    ]
    for path in (poses, tmp_path / "tops" / "oak.png"):
        before = path.read_bytes()
        path.write_bytes(b"other")
        with pytest.raises(InputError, match=re.escape(str(path)) + ": expected the asset as manifest.json has it"):
            manifest.check_manifest(kept, manifest.scan(settings), settings)
        path.write_bytes(before)
    stamps = manifest.stamps(settings)
    poses.unlink()
    with pytest.raises(InputError, match=re.escape(str(poses))):
        manifest.check_unchanged(stamps)


def test_the_file_of_own_media_is_pinned(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    path = tmp_path / "media.yaml"
    path.write_text("syrup: {index: 1.43}\n", "utf-8")
    settings = SceneSettings.model_validate({"vessels": {"media": path, "liquids": "syrup"}})
    kept = manifest.scan(settings)
    assert [(item.folder, item.path) for item in kept.files] == [("vessels.media", "media.yaml")]
    path.write_text("syrup: {index: 1.44}\n", "utf-8")
    with pytest.raises(InputError, match=re.escape(str(path)) + ": expected the asset as manifest.json has it"):
        manifest.check_manifest(kept, manifest.scan(settings), settings)
    path.unlink()
    with pytest.raises(InputError, match=re.escape(str(path)) + ": expected the file of vessels.media, found none"):
        manifest.scan(settings)
