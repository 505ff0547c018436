"""Each way of asking wrong is one clear line on stderr and exit code 2, and leaves nothing on disk."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from glassware.core.setting_errors import shortened
from glassware.dataset.commands.render_scene import main

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
        (("--vessels.height", "0.2", "0.1"), ("vessels.height", "the smaller number first", "(0.2, 0.1)")),
        (("--vessel-count", "3", "1"), ("vessel_count", "the smaller number first", "(3, 1)")),
        (("--seed", "-1"), ("seed", "greater than or equal to 0", "found -1")),
        (("--scene", "1000000"), ("scene", "less than or equal to 999999", "found 1000000")),
        (("--views", "many"), ("cameras.views", "many")),
        (("--vessels.categories", "goblet"), ("vessels.categories", "goblet", "tumbler")),
        (("--colour", "blue"), ("known options", "--colour blue")),
        (("--cameras.veiws", "3"), ("known options", "is it --cameras.views?", "--cameras.veiws 3")),
        (("--preset", "huge"), ("--preset", "fast, keypose, standard, syn-todd, train", "huge")),
        (("--preset=huge",), ("--preset", "fast, keypose, standard, syn-todd, train", "huge")),
    ],
    ids=" ".join,
)
def test_a_setting_that_cannot_be_is_named_with_what_is_allowed(refused, arguments, says):
    refused(*arguments, says=says)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (("--cameras.roll", "nan"), "cameras.roll: expected a finite number, found nan"),
        (("--cameras.slack", "1", "inf"), "cameras.slack.1: expected a finite number, found inf"),
        (
            ("--lights.elevation", "0", "1"),
            "lights.elevation.0: expected greater than or equal to 0.1 rad (5.73deg), found 0 rad",
        ),
        (
            ("--environment.sun-radius", "0.001"),
            "environment.sun_radius: expected greater than or equal to 0.00465 rad (0.266deg), found 0.001 rad "
            "(0.057deg)",
        ),
        (("--lights.margin", "1e9"), "lights.margin: expected less than or equal to 20 m, found 1e+09 m"),
        (("--lights.spread", "1e9"), "lights.spread: expected less than or equal to 20 m, found 1e+09 m"),
        (("--lights.aim", "3"), "lights.aim: expected less than or equal to 2 m, found 3 m (is it 3cm?)"),
        (
            ("--cameras.roll", "45"),
            "cameras.roll: expected less than or equal to 3.14159 rad (180deg), found 45 rad (2578.31deg) "
            "(is it 45deg?)",
        ),
        (("--cameras.focal", "1e9"), "cameras.focal: expected less than or equal to 20000, found 1000000000.0"),
        (
            ("--cameras.min-distance", "21"),
            "cameras.min_distance: expected less than or equal to 20 m, found 21 m (is it 21cm?)",
        ),
        (("--cameras.slack", "1", "11"), "cameras.slack.1: expected less than or equal to 10, found 11.0"),
        (
            ("--cameras.target-jitter", "2"),
            "cameras.target_jitter: expected less than or equal to 1 m, found 2 m (is it 2cm?)",
        ),
        (("--picture.rr-depth", "5000"), "picture.rr_depth: expected less than or equal to 4096, found 5000"),
        (("--seed", 2**63), f"seed: expected less than or equal to {2**63 - 1}, found {2**63}"),
        (("--name", "a\0b"), "name: expected text without NUL, found 'a\\x00b'"),
        (("--name", "\udcff"), "name: expected valid Unicode, found '\\udcff'"),
        (
            ("--props.smallest", "0.2", "--props.largest", "0.1"),
            "props.smallest: expected at most largest (0.1 m), found 0.2 m",
        ),
        (("--picture.dispersion",), "picture.dispersion: expected spectral to be on as well, found it off"),
        (("--lights.elevation", "1", "0.5"), "lights.elevation: expected the smaller number first, found (1.0, 0.5)"),
        (("--scene", "x"), "scene: expected INT, found 'x'"),
        (("--cameras.roll", "x"), "cameras.roll: expected FLOAT, found 'x'"),
        (("--vessels.height", "0.1"), "vessels.height: expected two numbers (FLOAT FLOAT), found fewer values"),
        (("--seed", "9" * 5000), f"seed: expected INT, found {shortened('9' * 5000)}"),
    ],
    ids=lambda value: str(value)[:40],
)
def test_a_setting_is_told_of_in_one_form(refused, arguments, line):
    assert refused(*arguments, says=()) == f"render-scene: {line}"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("cameras: [", ("line 1, column 11: expected valid YAML",)),
        ("seed: 1\n\tspp: 2\n", ("line 2, column 1: expected valid YAML",)),
        ("seed: \x01\n", ("expected valid YAML, found the character U+0001 at position 6",)),
        ("- 1\n- 2\n", ("a mapping of settings", "list")),
        ("cameras: {views: 0}\n", ("cameras.views", "greater than or equal to 1", "0")),
        ("cameras: {veiws: 3}\n", ("is it cameras.views?", "cameras.veiws")),
        ("nonsense: 1\n", ("known settings", "nonsense")),
        ("cameras: {width: yes}\n", ("cameras.width: expected a number or a text", "True")),
        ("seed: off\n", ("seed: expected a number or a text", "False")),
        ("vessel_count: [1, on]\n", ("vessel_count: expected a number or a text", "True")),
        ("cameras: 3\n", ("cameras", "3")),
        ("!!python/object/apply:os.getcwd []\n", ("valid YAML",)),
    ],
)
def test_a_settings_file_that_cannot_be_used_is_named(refused, tmp_path, text, says):
    path = tmp_path / "settings.yaml"
    path.write_text(text)
    refused("--config", path, says=(str(path), *says))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a: 2026-99-99\n", "valid YAML values"),
        ("seed: 0x_\n", "valid YAML values"),
        (f"seed: {'9' * 6000}\n", "valid YAML values"),
        ("[" * 5000, "too deeply nested values"),
        ("seed: 1\ncameras: {views: 3, views: 4}\n", "each setting once, found views 2 times"),
        ("preset: fast\n", "--preset on the command line alone, found 'fast'"),
        ("config: other.yaml\n", "--config on the command line alone, found 'other.yaml'"),
        ('name: "a\\0b"\n', "name: expected text without NUL"),
        ('out: ""\n', "out: expected a path, found ''"),
        ("&a {cameras: *a}\n", "cameras.cameras"),
        ("cameras: {roll: .nan}\n", "cameras.roll: expected a finite number, found nan"),
        ("1: 2\n", "expected"),
        (f"# {'x' * 1_000_000}\n", "at most 1000000 bytes"),
    ],
    ids=range(13),
)
def test_a_settings_file_with_strange_data_is_one_line_too(refused, tmp_path, text, says):
    path = tmp_path / "settings.yaml"
    path.write_text(text)
    assert len(refused("--config", path, says=(str(path), says))) < 600


def test_a_settings_file_that_is_no_regular_file_is_not_opened(refused, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    refused("--config", tmp_path / "pipe", says=("a regular file", "a device or a pipe"))
    refused("--config", "/dev/zero", says=("a regular file", "a device or a pipe"))
    refused("--config", tmp_path, says=("a regular file", "a folder"))


@pytest.mark.parametrize("option", ["--config", "--out", "--preset", "--hdri-dir", "--mesh-dir", "--texture-dir"])
def test_a_path_or_a_name_that_cannot_be_one_is_refused(refused, option):
    refused(option, "", says=(f"{option}: expected a value, found ''",))
    refused(f"{option}=", says=(f"{option}: expected a value, found ''",))
    for value in ("a\0b", "n" * 256, "\udcff"):
        line = refused(option, value, says=())
        assert line.isprintable()
        assert line.split(": ")[0] in (option, "render-scene")


@pytest.mark.parametrize("option", ["--hdri-dir", "--mesh-dir", "--texture-dir"])
def test_a_folder_that_is_a_file_is_called_one(refused, tmp_path, option):
    (tmp_path / "notes.txt").write_text("notes")
    refused(option, tmp_path / "notes.txt", says=("a folder of", "found a file"))


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
        "black": ("bad.exr", _exr(pixels), "found only black pixels"),
        "light from below": ("bad.exr", _exr(_half_lit(pixels, slice(3, None), 1.0)), "light in the upper half"),
        "too dim": ("bad.exr", _exr(_half_lit(pixels, slice(None), 1e-40)), "light in the upper half"),
        "too bright": ("bad.exr", _exr(_half_lit(pixels, slice(1), 1e9)), "finite pixels"),
        "vast": (
            "bad.hdr",
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000 +X 2000000\n",
            "1 to 16384 pixels a side",
        ),
        "dark side": ("bad.exr", _exr(pixels - 1.0), "at least 0"),
    }


def _half_lit(pixels: np.ndarray, rows: slice, value: float) -> np.ndarray:
    lit = pixels.copy()
    lit[rows] = value
    return lit


def _exr(pixels: np.ndarray) -> bytes:
    import tempfile

    import OpenEXR

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "x.exr")
        channels = {name: np.ascontiguousarray(pixels[..., i]) for i, name in enumerate("RGB")}
        OpenEXR.File({}, channels).write(str(path))
        return path.read_bytes()


@pytest.mark.parametrize("fault", sorted(_bad_hdris()))
def test_one_bad_environment_map_ends_a_strict_run_or_one_without_a_good_map(refused, tmp_path, small, fault):
    name, content, expected = _bad_hdris()[fault]
    folder = tmp_path / "hdri"
    folder.mkdir()
    # The good one comes first: a scene might draw it and never meet the bad one.
    (folder / "a.hdr").write_bytes((small.parent / "hdri" / "plain.hdr").read_bytes())
    (folder / name).write_bytes(content)
    refused("--hdri-dir", folder, "--strict", says=("--strict", f"environment.hdri_dir: {name}: expected", expected))
    (folder / "a.hdr").unlink()
    refused("--hdri-dir", folder, says=(f"{folder}: expected environment maps that can be used", name, expected))


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
def test_one_bad_mesh_among_good_ones_ends_a_strict_run(refused, tmp_path, fault):
    name, content = _bad_meshes()[fault]
    folder = tmp_path / "meshes"
    folder.mkdir()
    trimesh.creation.box(extents=(0.1, 0.1, 0.1)).export(folder / "a.stl")
    (folder / name).write_bytes(content)
    refused("--mesh-dir", folder, "--strict", says=("--strict", f"mesh_dir: {name}: expected"))


def test_one_bad_texture_among_good_ones_ends_a_strict_run(refused, tmp_path):
    import cv2

    folder = tmp_path / "textures"
    folder.mkdir()
    assert cv2.imwrite(str(folder / "a.png"), np.full((4, 4, 3), 128, np.uint8))
    whole = (folder / "a.png").read_bytes()
    (folder / "b.png").write_bytes(whole[:40])
    refused("--texture-dir", folder, "--strict", says=("--strict", "texture_dir: b.png: expected a readable picture"))


def _cut_exr(path: Path, rng: np.random.Generator) -> None:
    content = _exr(rng.random((64, 128, 3)).astype(np.float32))
    path.write_bytes(content[: len(content) * 2 // 3])


def _cut_png(path: Path, rng: np.random.Generator) -> None:
    import cv2

    assert cv2.imwrite(str(path), rng.integers(0, 256, (64, 64, 3)).astype(np.uint8))
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])


def _damaged_png(path: Path, rng: np.random.Generator) -> None:
    _cut_png(path, rng)
    content = bytearray(path.read_bytes())
    content[60] ^= 0xFF
    path.write_bytes(content)


@pytest.mark.parametrize(
    ("option", "name", "written"),
    [
        ("--hdri-dir", "bad.exr", _cut_exr),
        ("--texture-dir", "bad.png", _cut_png),
        ("--texture-dir", "bad.png", _damaged_png),
    ],
)
def test_a_decoder_says_nothing_beside_our_line(backend, capfd, rng, tmp_path, option, name, written):
    folder = tmp_path / "files"
    folder.mkdir()
    written(folder / name, rng)
    # The decoders print from C: only the file descriptors themselves show it.
    assert main([option, str(folder), "--out", str(tmp_path / "out")]) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith(f"{folder}: expected")
    assert name in line


def test_an_output_folder_that_holds_something_else_is_left_alone(refused, tmp_path):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.tex").write_text("years of work")
    refused("--out", tmp_path / "thesis", says=(str(tmp_path / "thesis"), "chapter.tex"))


def test_an_output_that_is_a_file_is_left_alone(refused, tmp_path):
    (tmp_path / "notes.txt").write_text("notes")
    refused("--out", tmp_path / "notes.txt", says=(str(tmp_path / "notes.txt"), "a folder to write to", "a file"))


@pytest.mark.slow
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
