"""Folders as people have them: what is no asset, what is passed over, and what would exhaust memory."""

from __future__ import annotations

import os
import struct
from pathlib import Path
from types import ModuleType

import pytest
import trimesh

from glassware.core.errors import InputError
from glassware.core.passed_over import report
from glassware.procedural.mesh_files.embedded import picture_folder
from glassware.procedural.props.mesh_files import usable_meshes

LFS = "version https://git-lfs.github.com/spec/v1\noid sha256:0123\nsize 12\n"


def test_one_bad_file_is_not_the_end_and_each_is_listed_with_its_reason(
    makers: ModuleType, tmp_path: Path, capfd: pytest.CaptureFixture
) -> None:
    good = makers.CORNERS + makers.FACES
    files = {
        "good.obj": good,
        "card.obj": makers.CORNERS + "f 1 2 3\n",
        "nan.obj": good.replace("0.1 0 0", "nan 0 0"),
        "lfs.glb": LFS,
        "empty.ply": "",
        "past.obj": makers.CORNERS + "f 1 2 9\n",
        "._good.obj": "\0\5\26\7Mac OS X",
        ".hidden/good.obj": good,
        "good.obj.lock": "",
        "good.obj~": "",
    }
    used, findings = usable_meshes(makers.written(tmp_path / "meshes", files), pictures=tmp_path)
    assert [file.name for file in used] == ["good.obj"]
    refused = {item.path: item.reason for item in findings}
    assert refused.keys() == {"card.obj", "nan.obj", "lfs.glb", "empty.ply", "past.obj"}
    assert refused["card.obj"] == "expected a body with three extents, found 0.1 x 0.1 x 0"
    assert "a pointer of Git LFS" in refused["lfs.glb"] or "git lfs pull" in refused["lfs.glb"]
    assert report(findings)[0] == "mesh_dir: 5 files passed over"
    assert capfd.readouterr() == ("", "")


def test_links_are_followed_and_rings_of_folders_end(makers: ModuleType, tmp_path: Path) -> None:
    store = makers.written(tmp_path / "store", {"a/m.obj": makers.CORNERS + makers.FACES})
    folder = tmp_path / "meshes"
    folder.mkdir()
    (folder / "object").symlink_to(store / "a")
    (folder / "ring").symlink_to(folder)
    (folder / "gone.obj").symlink_to(tmp_path / "nowhere.obj")
    used, findings = usable_meshes(folder, pictures=tmp_path)
    assert [file.name for file in used] == ["object/m.obj"]
    assert [item.path for item in findings] == ["gone.obj"]


def test_a_picture_in_a_glb_needs_no_home(
    makers: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temp"))
    (tmp_path / "temp").mkdir()
    material = makers.surface(baseColorTexture={"index": 0}, metallicFactor=0.0)
    folder = makers.written(tmp_path / "meshes", {"a.glb": makers.glb([material], makers.png())})
    (file,), findings = usable_meshes(folder)
    assert not findings
    assert file.pictures == picture_folder() == tmp_path / "temp" / f"glassware-{os.getuid()}" / "pictures"
    monkeypatch.setattr("tempfile.tempdir", "/dev/null")
    with pytest.raises(InputError, match=r"a folder that can be written \(set XDG_CACHE_HOME\)"):
        picture_folder()


@pytest.mark.parametrize("kind", ["obj", "stl", "text stl"])
def test_ten_million_triangles_are_one_line_within_bounded_memory(
    makers: ModuleType, tmp_path: Path, kind: str
) -> None:
    path = tmp_path / f"a.{kind[-3:]}"
    with path.open("wb") as file:
        match kind:
            case "obj":
                file.write(makers.CORNERS.encode() + b"f 1 2 3\n" * 2_500_000)
            case "stl":
                file.write(bytes(80) + struct.pack("<I", 2_100_000))
                file.truncate(84 + 50 * 2_100_000)
            case _:
                file.write(b"solid x\n" + b"facet normal 0 0 1\nendfacet\n" * 2_100_000)
    with pytest.raises(InputError, match=r"expected at most 2,000,000 faces, found 2,.00,000; simplify the mesh"):
        makers.parts_of(path)


def test_a_file_of_gigabytes_is_not_read(makers: ModuleType, tmp_path: Path) -> None:
    path = tmp_path / "a.glb"
    with path.open("wb") as file:
        file.truncate(3 * 2**30)  # holes: nothing is written
    with pytest.raises(InputError, match="expected at most 512 MiB, found 3072 MiB"):
        makers.parts_of(path)


def test_a_glb_that_claims_gigabytes_is_one_line(makers: ModuleType, tmp_path: Path) -> None:
    content = makers.glb()
    claim = content[:12] + struct.pack("<I", 2**32 - 1) + content[16:]
    with pytest.raises(InputError, match=r"a\.glb: expected a readable GLB mesh"):
        makers.parts_of(makers.written(tmp_path, {"a.glb": claim}) / "a.glb")


@pytest.mark.parametrize("kind", ["obj", "ply", "stl", "glb"])
def test_every_cut_of_a_file_is_read_or_refused_in_one_line(makers: ModuleType, tmp_path: Path, kind: str) -> None:
    content = trimesh.creation.box((0.1, 0.1, 0.05)).export(file_type=kind)
    content = content if isinstance(content, bytes) else str(content).encode()
    for end in range(1, len(content), max(1, len(content) // 40)):
        path = makers.written(tmp_path, {f"a.{kind}": content[:end]}) / f"a.{kind}"
        try:
            makers.parts_of(path)
        except InputError as error:
            assert "\n" not in str(error)  # noqa: PT017
