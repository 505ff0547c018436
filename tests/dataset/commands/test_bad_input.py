"""Each way of asking wrong is one clear line on stderr and exit code 2, and leaves nothing on disk."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

#: LLVM 14 aborts the process inside Dr.Jit 1.5; Debian 12 has it first on its path.
TOO_OLD_LLVM = Path("/usr/lib/llvm-14/lib/libLLVM-14.so")


@pytest.fixture
def refused(render_scene, small, tmp_path):
    """Assert that a request is refused in one line with these words, and that nothing was written."""

    def check(*arguments: object, says: tuple[str, ...]) -> str:
        before = _everything(tmp_path)
        out = () if "--out" in arguments else ("--out", tmp_path / "out")
        config = () if "--config" in arguments else ("--config", small)
        told = render_scene(*config, *out, *arguments)
        assert told.code == 2
        (line,) = told.errors
        for word in (*says, "expected", "found"):
            assert word in line
        assert _everything(tmp_path) == before
        return line

    return check


def _everything(folder: Path) -> dict[str, bytes | None]:
    return {str(path): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--views", "0"), ("cameras.views", "greater than or equal to 1", "found 0")),
        (("--views", "58"), ("cameras.views", "less than or equal to 57", "found 58")),
        (("--width", "0"), ("cameras.width", "greater than or equal to 1", "found 0")),
        (("--height", "-3"), ("cameras.height", "greater than or equal to 1", "found -3")),
        (("--spp", "0"), ("picture.spp", "greater than or equal to 1", "found 0")),
        (("--environment.room-share", "2"), ("environment.room_share", "less than or equal to 1", "found 2.0")),
        (("--vessels.height", "0.001", "0.1"), ("vessels.height", "greater than or equal to 0.04", "0.001")),
        (("--vessels.height", "0.2", "0.1"), ("vessels.height", "(smallest, largest)", "(0.2, 0.1)")),
        (("--vessel-count", "3", "1"), ("vessel_count", "(fewest, most)", "(3, 1)")),
        (("--seed", "-1"), ("seed", "greater than or equal to 0", "found -1")),
        (("--scene", "1000000"), ("scene", "less than or equal to 999999", "found 1000000")),
        (("--views", "many"), ("cameras.views", "many")),
        (("--vessels.categories", "mug"), ("vessels.categories", "mug", "tumbler")),
        (("--colour", "blue"), ("known settings", "--colour")),
        (("--preset", "huge"), ("--preset", "fast, standard, syn-todd", "huge")),
        (("--preset=huge",), ("--preset", "fast, standard, syn-todd", "huge")),
    ],
    ids=" ".join,
)
def test_a_setting_that_cannot_be_is_named_with_what_is_allowed(refused, arguments, says):
    refused(*arguments, says=says)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("cameras: [", ("valid YAML",)),
        ("- 1\n- 2\n", ("a mapping of settings", "list")),
        ("cameras: {views: 0}\n", ("cameras.views", "greater than or equal to 1", "0")),
        ("cameras: {veiws: 3}\n", ("cameras.veiws", "3")),
        ("nonsense: 1\n", ("nonsense", "1")),
        ("cameras: 3\n", ("cameras", "3")),
        ("!!python/object/apply:os.getcwd []\n", ("valid YAML",)),
    ],
)
def test_a_settings_file_that_cannot_be_used_is_named(refused, tmp_path, text, says):
    path = tmp_path / "settings.yaml"
    path.write_text(text)
    refused("--config", path, says=(str(path), *says))


def test_a_settings_file_that_is_missing_or_no_text_is_named(refused, tmp_path):
    refused("--config", tmp_path / "none.yaml", says=(str(tmp_path / "none.yaml"), "readable"))
    (tmp_path / "binary.yaml").write_bytes(b"\xff\xfe\x00\xd8")
    refused("--config", tmp_path / "binary.yaml", says=("binary.yaml",))


@pytest.mark.parametrize("option", ["--hdri-dir", "--mesh-dir", "--texture-dir"])
def test_a_folder_that_is_missing_or_empty_is_named(refused, tmp_path, option):
    refused(option, tmp_path / "nowhere", says=(str(tmp_path / "nowhere"),))
    (tmp_path / "empty").mkdir()
    refused(option, tmp_path / "empty", says=(str(tmp_path / "empty"), "none"))


def _bad_hdris() -> dict[str, tuple[str, bytes, str]]:
    pixels = np.zeros((4, 8, 3), np.float32)
    return {
        "empty": ("bad.exr", b"", "an OpenEXR file"),
        "text": ("bad.hdr", b"not a picture", "a Radiance HDR file"),
        "cut short": ("bad.exr", b"\x76\x2f\x31\x01\x02\x00\x00\x00chann", "a whole OpenEXR file"),
        "nan": ("bad.exr", _exr(np.full_like(pixels, np.nan)), "finite pixels"),
        "square": ("bad.exr", _exr(pixels[:, :4]), "twice as wide as high"),
        "dark side": ("bad.exr", _exr(pixels - 1.0), "at least 0"),
    }


def _exr(pixels: np.ndarray) -> bytes:
    import tempfile

    import OpenEXR

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "x.exr")
        channels = {name: np.ascontiguousarray(pixels[..., i]) for i, name in enumerate("RGB")}
        OpenEXR.File({}, channels).write(str(path))
        return path.read_bytes()


@pytest.mark.parametrize("fault", ["empty", "text", "cut short", "nan", "square", "dark side"])
def test_one_bad_environment_map_among_good_ones_is_named(refused, tmp_path, small, fault):
    name, content, expected = _bad_hdris()[fault]
    folder = tmp_path / "hdri"
    folder.mkdir()
    # The good one comes first: a scene might draw it and never meet the bad one.
    (folder / "a.hdr").write_bytes((small.parent / "hdri" / "plain.hdr").read_bytes())
    (folder / name).write_bytes(content)
    refused("--hdri-dir", folder, says=(str(folder / name), expected))


def _bad_meshes() -> dict[str, tuple[str, bytes]]:
    box = trimesh.creation.box(extents=(0.1, 0.1, 0.1))
    vertices = box.vertices.copy()
    vertices[0] = np.nan
    return {
        "no faces": ("bad.obj", b"v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\n"),
        "empty": ("bad.ply", b""),
        "nan": ("bad.obj", _obj(vertices, box.faces)),
        "flat": ("bad.obj", _obj(box.vertices * [1, 1, 0], box.faces)),
        "text": ("bad.glb", b"not a mesh"),
    }


def _obj(vertices: np.ndarray, faces: np.ndarray) -> bytes:
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    return ("\n".join(lines) + "\n").encode()


@pytest.mark.parametrize("fault", ["no faces", "empty", "nan", "flat", "text"])
def test_one_bad_mesh_among_good_ones_is_named(refused, tmp_path, fault):
    name, content = _bad_meshes()[fault]
    folder = tmp_path / "meshes"
    folder.mkdir()
    trimesh.creation.box(extents=(0.1, 0.1, 0.1)).export(folder / "a.stl")
    (folder / name).write_bytes(content)
    refused("--mesh-dir", folder, says=(str(folder / name),))


def test_one_bad_texture_among_good_ones_is_named(refused, tmp_path):
    import cv2

    folder = tmp_path / "textures"
    folder.mkdir()
    assert cv2.imwrite(str(folder / "a.png"), np.full((4, 4, 3), 128, np.uint8))
    whole = (folder / "a.png").read_bytes()
    (folder / "b.png").write_bytes(whole[:40])
    refused("--texture-dir", folder, says=(str(folder / "b.png"), "picture"))


def test_an_output_folder_that_holds_something_else_is_left_alone(refused, tmp_path):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.tex").write_text("years of work")
    refused("--out", tmp_path / "thesis", says=(str(tmp_path / "thesis"), "chapter.tex"))


def test_an_output_that_is_a_file_is_left_alone(refused, tmp_path):
    (tmp_path / "notes.txt").write_text("notes")
    refused("--out", tmp_path / "notes.txt", says=(str(tmp_path / "notes.txt"), "a folder to write to", "a file"))


def test_a_crowd_that_no_table_holds_is_refused(refused):
    crowd = ("--vessel-count", 24, 24, "--prop-count", 24, 24, "--placement.gap", 0.2)
    small_table = ("--table.smallest", 0.3, "--table.largest", 0.3)
    refused(*crowd, *small_table, says=("vessel_count", "fit on the table"))


@pytest.mark.parametrize("library", ["missing", "too old"])
def test_an_llvm_that_cannot_be_used_is_named_with_what_to_install(small, tmp_path, library):
    path = {"missing": tmp_path / "libLLVM.so", "too old": TOO_OLD_LLVM}[library]
    if library == "too old" and not path.exists():
        pytest.skip("no LLVM 14 is installed here")
    environment = {**os.environ, "DRJIT_LIBLLVM_PATH": str(path), "CUDA_VISIBLE_DEVICES": ""}
    command = [sys.executable, "-P", "-m", "glassware.dataset.commands.render_scene"]
    arguments = ["--config", str(small), "--out", str(tmp_path / "out")]
    ended = subprocess.run([*command, *arguments], env=environment, capture_output=True, text=True, timeout=120)
    assert ended.returncode == 2, ended.stderr
    (line,) = ended.stderr.splitlines()
    assert str(path) in line
    assert "libllvm19" in line
    assert not (tmp_path / "out").exists()
