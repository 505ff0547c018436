"""The front door: ten lines from a seed to a picture, labels, files and a point cloud."""

from __future__ import annotations

import base64
import os
import re
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

import glassware as gw
from glassware.procedural.scene.scene_file import scene_digest
from glassware.procedural.scene.validate import check_scene

#: Small enough for a test.
SMALL = {"cameras": {"views": 2, "width": 48, "height": 36}, "picture": {"spp": 2}}
#: Few objects.
FEW = {
    "vessel_count": (1, 1),
    "prop_count": (1, 1),
    "vessels": {"categories": ["tumbler", "beaker"], "fill_probability": 1.0, "contents": {"standing": 0.0}},
    "props": {"kinds": ["shape"]},
    "physics": {"piled_probability": 0.0},
}
#: Longest that a child process may take [s].
PATIENCE = 120


@pytest.fixture(scope="module")
def settings(tmp_path_factory):
    """Settings of a scene under a small map: a room takes longer to draw than all else."""
    folder = tmp_path_factory.mktemp("hdri")
    pixels = np.random.default_rng(1).uniform(0.5, 1.0, (8, 16, 3)).astype(np.float32)
    assert cv2.imwrite(str(folder / "plain.hdr"), pixels)
    return FEW | SMALL | {"environment": {"hdri_dir": folder, "hdri_share": 1.0}}


@pytest.fixture(scope="module")
def scene(settings):
    return gw.draw(seed=7, **settings)


@pytest.fixture(scope="module")
def renderer(scene):
    return gw.Renderer(scene, "llvm_ad_rgb")


def _python(code: str, *arguments: str) -> str:
    command = [sys.executable, "-P", "-c", code, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=True).stdout


def test_importing_loads_no_renderer_starts_no_process_and_changes_no_variable():
    code = """
import os, subprocess, sys
import cv2  # extends LD_LIBRARY_PATH, whoever imports it
before = dict(os.environ)
def refuse(*_, **__):
    raise AssertionError("a process is started")
subprocess.Popen.__init__ = refuse
import glassware, glassware.dataset.reader, glassware.annotate.labels, glassware.render.renderer
import glassware.render.pictures.integrator, glassware.render.scene.loaded_scene
assert not {"mitsuba", "drjit"} & set(sys.modules), "the renderer is loaded"
assert dict(os.environ) == before
print("clean")
"""
    assert _python(code) == "clean\n"


def test_every_public_name_is_there_and_nothing_else_is_promised():
    assert dir(gw) == sorted(gw.__all__)
    assert all(getattr(gw, name) is not None for name in gw.__all__)
    with pytest.raises(AttributeError, match=r"no attribute 'Rendrer'; it has Dataset, "):
        gw.Rendrer  # noqa: B018


def test_a_seed_becomes_files_that_show_what_was_rendered(scene, renderer, tmp_path):
    frame = renderer.frame(1)
    labels = gw.label(scene, frame, renderer)
    gw.write(tmp_path / "out", scene, renderer, files="all")
    stored = gw.Dataset.open(str(tmp_path / "out"))
    assert repr(stored) == f"Dataset({str(tmp_path / 'out')!r}: glassware, seed 7, 1 scene)"
    assert repr(frame).startswith("Frame(view 1: 48x36, 2 samples per pixel")
    assert re.fullmatch(r"Labels\(2 objects, [012] visible\)", repr(labels))
    (first, second) = stored.views()
    for wrong, words in (
        (lambda: second.picture("top"), "^eye: expected 'left' or 'right', found 'top'$"),
        (lambda: second.radiance(3), "^eye: expected 'left' or 'right', found 3$"),
        (lambda: stored.scene("a"), "^scene: expected a whole number"),
        (lambda: stored.split("test"), "expected a data set that is split, .* found one without splits$"),
        (lambda: stored.split("tests"), "^split: expected one of train, val, test, found 'tests'$"),
        (lambda: stored.index(3), "^index: columns: expected a list of names of columns, found 3$"),
        (lambda: stored.index([3]), r"expected one of the columns .*, found 3$"),
        (lambda: second.painted_sensor_depth(seed=0.5), "^seed: expected a whole number from 0"),
        (lambda: gw.label(scene, frame, renderer, 3), "^label: points: expected keypoints"),
        (lambda: gw.save_png("a.png", frame, "bright"), "^save_png: exposure: expected a number"),
        (lambda: stored.index(["paths"]), r"expected one of the columns .* \(is it path\?\), found 'paths'$"),
    ):
        with pytest.raises(gw.InputError, match=words):
            wrong()
    np.testing.assert_array_equal(second.radiance("left"), frame.left.astype(np.float16))
    assert second.labels().model_dump_json() == labels.model_dump_json()
    assert (tmp_path / "out" / "preview.png").is_file()
    # Point by point: Z is the third coordinate in the camera frame, and the pose takes one frame to the other.
    depth = second.geometry().Z
    points = second.points()
    np.testing.assert_allclose(points[:, 2], depth[np.isfinite(depth)], rtol=1e-12)
    world = second.points("world")
    pose = second.camera().world_T_camera
    np.testing.assert_allclose(world, points @ pose[:3, :3].T + pose[:3, 3], atol=1e-12)
    assert first.points().shape != points.shape


@pytest.mark.slow
def test_a_view_without_a_file_says_how_it_is_made(scene, renderer, tmp_path):
    gw.write(tmp_path / "out", scene, renderer, files=["layers"])
    view = gw.Dataset.open(tmp_path / "out").views()[0]
    assert view.layers().count.shape == view.picture().shape[:2] == view.geometry().Z.shape
    for read, kind in ((view.radiance, "radiance"), (view.refraction, "refraction")):
        with pytest.raises(gw.InputError, match=rf"exr: expected a data set with {kind}, made with --write {kind} "):
            read()
    gw.write(tmp_path / "out", scene, renderer, files="radiance")
    view = gw.Dataset.open(tmp_path / "out").views()[0]
    assert view.radiance().dtype == np.float32
    with pytest.raises(gw.InputError, match=r"left\.exr: expected a data set with noisy, made with --write noisy "):
        view.radiance(noisy=True)
    with pytest.raises(gw.InputError, match=r"^write: files: expected some of .*\(is it layers\?\), found 'layer'$"):
        gw.write(tmp_path / "out", scene, renderer, files="layer")


def test_a_python_started_in_a_checkout_finds_all_packages():
    root = Path(__file__).resolve().parents[1]
    command = [sys.executable, "-c", "import glassware; print(glassware.InputError.__module__)"]
    ended = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=PATIENCE, check=True)
    assert ended.stdout == "glassware.core.errors\n"


def test_a_stored_scene_renders_the_same_bits_with_the_irradiance_cache_too(tmp_path):
    shared = SMALL | {"picture": {"spp": 2, "light": "shared"}}
    scene = gw.draw(seed=3, vessel_count=(1, 1), prop_count=(0, 0), **shared)
    gw.write(tmp_path / "out", scene, files="radiance")
    again = gw.Renderer(gw.load_scene(tmp_path / "out" / "scenes" / "000000" / "scene.json"))
    assert again.light_check is not None
    stored = gw.Dataset.open(tmp_path / "out").views()[0].radiance()
    np.testing.assert_array_equal(again.frame(0).left.astype(np.float16), stored)


def test_a_renderer_keeps_its_variant_whatever_is_active(scene, renderer):
    before = renderer.frame(0)
    bare = {"spectral": True, "layers": 0, "refraction": False}  # fewer kernels
    spectral = scene.model_copy(update={"picture": scene.picture.model_copy(update=bare)})
    other = gw.Renderer(spectral)
    assert other.variant == "llvm_ad_spectral"
    assert np.isfinite(other.frame(0).left).all()
    np.testing.assert_array_equal(renderer.frame(0).left, before.left)


def test_threads_get_the_same_pictures(renderer):
    expected, found = renderer.frame(0).left, []
    threads = [threading.Thread(target=lambda: found.append(renderer.frame(0).left)) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 2
    for picture in found:
        np.testing.assert_array_equal(picture, expected)


@pytest.mark.parametrize("view", [2, -1, 0.0, "0", True])
def test_a_view_out_of_range_is_one_clear_line(renderer, view):
    with pytest.raises(gw.InputError, match=r"^view: expected a whole number from 0 to 1, found "):
        renderer.frame(view)


@pytest.mark.parametrize(
    ("variant", "spectral", "words"),
    [
        ("llvm_ad_rbg", False, "expected one of .*llvm_ad_rgb.*found 'llvm_ad_rbg'"),
        ("llvm_ad_spectral", False, "expected an RGB variant, as picture.spectral is off, found llvm_ad_spectral"),
        ("llvm_ad_rgb", True, "expected a spectral variant, as picture.spectral is on, found llvm_ad_rgb"),
    ],
)
def test_a_wrong_variant_is_one_clear_line(backend, scene, variant, spectral, words):
    picture = scene.picture.model_copy(update={"spectral": spectral})
    with pytest.raises(gw.InputError, match=words):
        gw.Renderer(scene.model_copy(update={"picture": picture}), variant)


def test_a_forgotten_variant_is_one_clear_line(scene, tmp_path):
    gw.save_scene(scene, tmp_path / "scene.json")
    code = """
import sys
import glassware as gw
from glassware.render.scene.loaded_scene import load
try:
    load(gw.load_scene(sys.argv[1]))
except gw.InputError as error:
    print(error)
"""
    assert "backend: expected a variant that is set" in _python(code, str(tmp_path / "scene.json"))


def test_labels_of_another_scene_are_refused(scene, renderer):
    moved = scene.model_copy(update={"props": ()})
    with pytest.raises(gw.InputError, match="label: expected the renderer's own scene"):
        gw.label(moved, renderer.frame(0), renderer)
    with pytest.raises(gw.InputError, match="write: expected the renderer's own scene"):
        gw.write("nowhere", moved, renderer)
    assert not Path("nowhere").exists()


def test_a_frame_of_another_scene_view_or_size_is_refused(scene, renderer):
    frame = renderer.frame(0)
    other = replace(frame, scene=scene.with_camera(0, eye=(0.0, -0.5, 0.4)))
    for wrong, words in (
        (other, "expected a frame of Scene"),
        (replace(frame, view=2), "view: expected a whole number from 0 to 1, found 2"),
        (replace(frame, left=frame.left[:9]), r"expected pictures of shape \(36, 48, 3\), as view 0 has them"),
    ):
        with pytest.raises(gw.InputError, match=rf"^label: frame.*{words}"):
            gw.label(scene, wrong, renderer)


def test_another_scene_is_replaced_only_by_name(scene, renderer, tmp_path):
    gw.write(tmp_path, scene, renderer)
    gw.write(tmp_path, scene, renderer)
    stored = gw.load_scene(tmp_path / "scenes" / "000000" / "scene.json")
    assert scene_digest(stored) == scene_digest(scene)
    moved = scene.with_camera(0, eye=(0.0, -0.5, 0.4))
    assert scene_digest(moved) != scene_digest(scene)
    with pytest.raises(gw.InputError, match=r"expected a folder without another scene .* replace=True, found another"):
        gw.write(tmp_path, moved)
    gw.write(tmp_path, moved, replace=True)
    camera = gw.Dataset.open(tmp_path).views()[0].camera()
    np.testing.assert_allclose(camera.world_T_camera[:3, 3], (0.0, -0.5, 0.4))


@pytest.mark.parametrize(
    ("call", "line"),
    [
        (
            lambda s, r: gw.Renderer("scene.json"),
            "Renderer: scene: expected a Scene, from gw.draw or gw.load_scene, found",
        ),
        (
            lambda s, r: gw.Renderer(None),
            "Renderer: scene: expected a Scene, from gw.draw or gw.load_scene, found None",
        ),
        (lambda s, r: gw.Renderer(s, threads=0), "Renderer: threads: expected a whole number from 1 to 1024, found 0"),
        (
            lambda s, r: gw.Renderer(s, threads=1.5),
            "Renderer: threads: expected a whole number from 1 to 1024, found 1.5",
        ),
        (lambda s, r: gw.Renderer(s, 3), "Renderer: variant: expected the name of a variant"),
        (lambda s, r: gw.Renderer(s, on_stage=3), "Renderer: on_stage: expected a function, found 3"),
        (lambda s, r: r.frame(0, 4), "margin: expected four whole numbers: left, top, right, bottom [px], found 4"),
        (lambda s, r: r.frame(0, (1, 2, 3)), "margin: expected four whole numbers: left, top, right, bottom [px], fou"),
        (lambda s, r: r.transmission(0, 1, 0.5), "shift: expected two numbers: to the right and down [px], found 0.5"),
        (lambda s, r: r.geometry(0, np.zeros(2)), "eye: expected 'left' or 'right', found an array of shape (2,)"),
        (lambda s, r: gw.look_at((0, 0, 1), (0, 0, 0), "up"), "look_at: roll: expected a number from -inf to inf rad,"),
        (lambda s, r: r.line_of_sight(5, [[0, 0, 0]]), "view: expected a whole number from 0 to 1, found 5"),
        (
            lambda s, r: r.line_of_sight(0, [0, 0, 0]),
            "points: expected points as an array of finite numbers of shape (n, 3)",
        ),
        (lambda s, r: r.line_of_sight(0, [[0, 0, np.nan]]), "points: expected finite numbers"),
        (lambda s, r: gw.write(s, "out", r), "write: out: expected a path (text or pathlib.Path), found a Scene"),
        (lambda s, r: gw.write("out", r, s), "write: scene: expected a Scene, found a Renderer"),
        (
            lambda s, r: gw.write("out", s, "r"),
            "write: renderer: expected a Renderer, or None for a new one, found 'r'",
        ),
        (
            lambda s, r: gw.label(s, r, s),
            "label: frame: expected a Frame; the order is label(scene, frame, renderer), found",
        ),
        (lambda s, r: gw.Dataset.open(None), "Dataset.open: path: expected a path (text or pathlib.Path), found None"),
        (lambda s, r: gw.Dataset("out"), "Dataset: expected Dataset.open(path), which reads the head, found None"),
        (lambda s, r: gw.load_scene(None), "load_scene: path: expected a path (text or pathlib.Path), found None"),
        (lambda s, r: gw.load_scene("absent.json"), "absent.json: expected a readable file, found none"),
        (lambda s, r: gw.save_scene("scene.json", s), "save_scene: scene: expected a Scene, found 'scene.json'"),
        (lambda s, r: gw.draw("7"), "draw: seed: expected a whole number from 0 to "),
        (
            lambda s, r: gw.draw(7, preset="quick"),
            "draw: preset: expected one of fast, keypose, standard, syn-todd, train, found 'quick'",
        ),
    ],
)
def test_a_wrong_argument_is_one_clear_line(scene, renderer, call, line):
    with pytest.raises(gw.InputError) as error:
        call(scene, renderer)
    assert str(error.value).startswith(line)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 200


def test_a_number_of_numpy_is_a_seed(scene, settings):
    assert scene_digest(gw.draw(np.int64(7), np.uint8(0), **settings)) == scene_digest(scene)


def test_a_changed_copy_that_cannot_exist_is_refused(scene):
    (prop,) = scene.props
    pose = prop.world_T_object.copy()
    pose[2, 3] -= 0.05
    sunk = scene.model_copy(update={"props": (prop.model_copy(update={"world_T_object": pose}),)})
    with pytest.raises(gw.InputError, match=r"prop-00: expected an object above the table's top"):
        gw.Renderer(sunk)


def test_a_renderer_is_refused_in_a_forked_process(renderer):
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            renderer.frame(0)
            said = "it rendered"
        except gw.InputError as error:
            said = str(error)
        except BaseException as error:
            said = repr(error)
        os.write(writing, said.encode())
        os._exit(0)
    os.waitpid(child, 0)
    said = os.read(reading, 10_000).decode()
    os.close(reading)
    os.close(writing)
    assert said.startswith(f"renderer: expected to be used in the process that made it ({os.getpid()})")
    assert '"spawn"' in said


def test_a_new_renderer_in_a_forked_process_is_refused_and_does_not_hang(scene, tmp_path):
    gw.save_scene(scene, tmp_path / "scene.json")
    code = """
import os, signal, sys
import glassware as gw
scene = gw.load_scene(sys.argv[1])
gw.Renderer(scene, "llvm_ad_rgb")
child = os.fork()
if child == 0:
    signal.alarm(60)  # ends a child that hangs
    try:
        gw.Renderer(scene, "llvm_ad_rgb").frame(0)
    except gw.InputError as error:
        print(error, flush=True)
    os._exit(0)
assert os.waitpid(child, 0)[1] == 0
"""
    said = _python(code, str(tmp_path / "scene.json"))
    assert said.startswith('backend: expected a process of its own; start processes with the "spawn" method')
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"vessls": {}}, "vessls"),
        ({"cameras": {"views": 0}}, r"cameras\.views"),
        ({"preset": "quick"}, r"^draw: preset: expected"),
        ({"seed": -1}, "seed"),
        ({"scene": True}, "scene"),
    ],
)
def test_a_setting_that_cannot_be_is_one_clear_line(settings, words):
    with pytest.raises(gw.InputError, match=words) as caught:
        gw.draw(**({"seed": 7} | settings))
    assert "\n" not in str(caught.value)


def test_a_missing_data_set_is_one_clear_line(tmp_path):
    with pytest.raises(gw.InputError, match="expected the folder of a data set, found none"):
        gw.Dataset.open(tmp_path / "missing")


def test_scene_frame_and_data_set_show_themselves_in_a_notebook(scene, renderer, tmp_path):
    shown = scene._repr_html_()
    assert repr(scene) == "Scene(seed 7/0: 1 vessel, 1 prop, map, 2 cameras 48x36)"
    assert shown.startswith(f"<p>{scene!r}</p><svg ")
    assert shown.count("<polygon ") == 3  # the table and both objects
    assert all(f"<td>{item.name}</td>" in shown for item in scene.objects)
    frame = renderer.frame(0)
    pictures = [base64.b64decode(part.partition('"')[0]) for part in frame._repr_html_().split("base64,")[1:]]
    assert len(pictures) == 5
    gw.write(tmp_path / "out", scene, renderer)
    left = gw.Dataset.open(tmp_path / "out").views()[0].picture("left")
    decoded = cv2.imdecode(np.frombuffer(pictures[0], np.uint8), cv2.IMREAD_COLOR)
    assert decoded is not None
    np.testing.assert_array_equal(decoded[..., ::-1], left)
    assert "1 scene in " in gw.Dataset.open(tmp_path / "out")._repr_html_()


def test_a_changed_copy_has_its_change_everywhere(scene):
    (vessel,) = scene.vessels
    crystal = scene.with_glass(vessel.name, "lead crystal").with_dye(vessel.name, "brilliant blue FCF", 0.01)
    moved = crystal.with_camera(0, eye=(0.0, -0.5, 0.4), target=(0.0, 0.0, 0.05))
    (changed,) = moved.vessels
    media = {part.part: (part.front.name, part.back.name) for part in changed.interfaces}
    assert changed.glass.name == "lead crystal"
    assert media["outside"] == ("air", "lead crystal")
    assert media["wet_wall"] == (changed.liquid.medium.name, "lead crystal")
    assert "brilliant blue FCF" in changed.liquid.medium.name
    # Blue passes a blue dye, red does not.
    assert changed.liquid.medium.sigma_a[0] > 10 * changed.liquid.medium.sigma_a[2]
    assert changed.liquid.medium.eta == vessel.liquid.medium.eta
    pose = moved.cameras[0].world_T_camera
    np.testing.assert_allclose(pose[:3, 3], (0.0, -0.5, 0.4))
    # The target lies on the optical axis.
    np.testing.assert_allclose(np.cross(pose[:3, 2], np.array([0.0, 0.5, -0.35])), 0.0, atol=1e-12)
    check_scene(moved)
    assert scene.vessels[0].glass.name != "lead crystal"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda s: s.with_glass("vessel-0", "acrylic"), r"^vessel: expected one of vessel-00 \(is it vessel-00\?\)"),
        (lambda s: s.with_glass("vessel-00", "acryl"), r"^glass: expected one of .*\(is it acrylic\?\), found 'acryl'"),
        (lambda s: s.with_dye("vessel-00", "erythrosin", 0.1), r"^dye: expected one of .*\(is it erythrosine\?\)"),
        (
            lambda s: s.with_dye("vessel-00", "erythrosine", -1.0),
            "^concentration of the dye: expected a number",
        ),
        (lambda s: s.with_camera(2, eye=(0, 0, 1)), "^view: expected a whole number from 0 to 1, found 2"),
        (lambda s: s.with_camera(0, eye="above"), r"^camera, eye: expected three finite numbers .*, found 'above'$"),
        (lambda s: s.with_camera(0, eye=(0, np.nan, 0)), "^camera, eye: expected finite numbers"),
        (lambda s: s.with_dye("vessel-00", "erythrosine", "much"), r"^concentration of the dye: .*, found 'much'$"),
        (lambda s: s.with_dye("vessel-00", "erythrosine", 1e9), "^concentration of the dye: .* from 0 to 1000 kg/m"),
        (lambda s: s.with_glass("vessel-00", 3), "^glass: expected a Medium, or its name in the catalogue, found 3$"),
        (lambda s: s.with_camera(0, eye=(0, 0, 0)), "^camera, target: expected a point away from the eye"),
    ],
)
def test_a_change_that_cannot_be_is_one_clear_line(scene, change, words):
    with pytest.raises(gw.InputError, match=words):
        change(scene)
