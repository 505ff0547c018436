from __future__ import annotations

import json
import re

import cv2
import numpy as np
import pytest

from glassware.dataset.commands.view import main
from glassware.dataset.reader import Dataset

#: Text that would be markup, were it not escaped.
MARKUP = "<script>document.title='run'</script></script>"
#: Colour behind the scene in a light page, as OpenCV orders it.
GROUND = (240, 237, 236)
#: Half a stored step of a normal, half a shown one, and half floats.
STEP_OF_NORMALS = 0.5 / 127 + 0.005 + 1e-3


def _saved(root, folder, *options):
    path = folder / "page.html"
    assert main([str(root), "--save", str(path), *options]) == 0
    return path


def test_the_page_loads_nothing_and_runs_its_own_script_alone(copy, tmp_path, page):
    head = json.loads((copy / "dataset.json").read_text("utf-8"))
    (copy / "dataset.json").write_text(json.dumps(head | {"name": MARKUP}), "utf-8")
    objects = copy / "scenes" / "000000" / "objects.json"
    records = json.loads(objects.read_text("utf-8"))
    records["objects"][0]["category"] = MARKUP
    objects.write_text(json.dumps(records), "utf-8")
    shown = page(_saved(copy, tmp_path))
    assert MARKUP not in shown.text
    assert shown.record("scene-0")["objects"][0]["cells"][1] == MARKUP
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]+)"', shown.text)
    assert policy.startswith("default-src 'none'; img-src data:;")
    assert policy.endswith(f"script-src '{shown.script_hash()}'")
    outside_of_data = re.sub(r'<script type="application/json".*?</script>', "", shown.text, flags=re.DOTALL)
    assert not re.search(r"https?:|@import|url\(|\bimport\(|fetch\(|XMLHttp", outside_of_data)


@pytest.mark.slow
def test_the_same_data_set_gives_the_same_page(proven, tmp_path):
    for name in ("a.html", "b.html"):
        assert main([str(proven), "--save", str(tmp_path / name)]) == 0
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_maps_are_the_stored_labels(proven, tmp_path, page, unpack):
    maps, view = page(_saved(proven, tmp_path)).maps(), Dataset.open(proven).views()[0]
    for eye in ("left", "right"):
        geometry, found = (
            view.geometry(eye),
            {name: unpack(maps[f"{eye}/{name}"]["data"]) for name in ("ids", "depth", "normals")},
        )
        np.testing.assert_array_equal(found["ids"], geometry.id)
        Z = np.where(np.isfinite(geometry.Z), geometry.Z, 0.0)
        step = maps[f"{eye}/depth"]["step"]
        np.testing.assert_allclose(found["depth"] * step, Z, atol=0.501 * step)
        np.testing.assert_allclose(found["normals"] / 127.0, geometry.normal, atol=0.51 / 127)
    np.testing.assert_array_equal(unpack(maps["left/layer-1-ids"]["data"]), view.layers().id[1])
    flow, stored = view.refraction().flow, unpack(maps["left/refractive-flow"]["data"]) / 16.0
    np.testing.assert_allclose(stored[np.isfinite(flow)], flow[np.isfinite(flow)], atol=0.5 / 16)
    kinds = {"ids", "depth", "heatmap", "coordinates", "vessel-parts", "disparity", "pair", "layer-count", "ends"}
    assert kinds <= {name.split("/")[1] for name in maps}


def test_what_was_not_written_is_named(copy, tmp_path, page):
    for name in ("layers.exr", "right_geometry.exr", "right_instances.png", "right_labels.json"):
        (copy / "scenes" / "000000" / "000" / name).unlink()
    shown = page(_saved(copy, tmp_path))
    assert set(shown.record("view-0-0")["absent"]) == {"layers", "right-labels"}
    assert not [name for name in shown.maps() if "layer" in name or name == "right/ids"]


@pytest.mark.slow
def test_what_is_unusual_about_the_pictures_is_named(copy, tmp_path, page):
    (scene,) = (copy / "scenes").glob("*/scene.json")
    data = json.loads(scene.read_text())
    data["picture"] |= {"refractivity": 0.5, "spectral": True}
    sensor = {"name": "nikon-d5100", "wavelengths": [400, 700], "white": [1, 1, 1]}
    data["sensitivities"] = sensor | {key: [0, 1] for key in ("red", "green", "blue")} | {"matrix": np.eye(3).tolist()}
    scene.write_text(json.dumps(data))
    head = json.loads((copy / "dataset.json").read_text())
    head["developed"] = {"camera": {"name": "phone"}, "seed": 1}
    (copy / "dataset.json").write_text(json.dumps(head))
    assert main([str(copy), "--save", str(tmp_path / "a.html"), "--most-views", "1"]) == 0
    facts = page(tmp_path / "a.html").text.partition("</header>")[0]
    light = "simplified light: picture.refractivity 0.5 (true: 1)"
    assert f"; developed by the camera phone; {light}; sensor nikon-d5100<" in facts


def test_width_bounds_the_page(proven, tmp_path, page, unpack):
    large, small = (_saved(proven, tmp_path, "--most-columns", width).stat().st_size for width in ("640", "20"))
    assert small < large
    shown = page(_saved(proven, tmp_path, "--most-columns", "20"))
    ids = unpack(shown.maps()["left/ids"]["data"])
    view = Dataset.open(proven).views()[0]
    assert ids.shape == (15, 20)
    assert set(np.unique(ids)) <= set(np.unique(view.geometry().id))


def test_a_browser_reads_the_labels_of_a_pixel(proven, tmp_path, browser):
    geometry = Dataset.open(proven).views()[0].geometry()
    row, column = np.argwhere((geometry.id > 1) & (geometry.background_id == 1))[0]
    text = browser(_saved(proven, tmp_path), f"pixel={column},{row}", "--dump-dom")
    assert 'data-ready="0-0 picture"' in text, re.findall(r'data-failed="[^"]*"', text)
    cells = dict(re.findall(r'data-map="([^"]+)"[^>]*><td>[^<]*</td><td>([^<]*)</td>', text))
    assert cells["left/ids"].split()[0] == str(geometry.id[row, column])
    assert cells["left/background-ids"] == "1 table"
    assert float(cells["left/depth"].split()[0]) == pytest.approx(geometry.Z[row, column], abs=1e-4)
    normal = [float(one) for one in cells["left/normals"].split(",")]
    np.testing.assert_allclose(normal, geometry.normal[row, column], atol=STEP_OF_NORMALS)


@pytest.mark.slow
def test_a_camera_sees_the_meshes_where_the_labels_have_the_objects(proven, tmp_path, browser):
    shot, geometry = tmp_path / "shot.png", Dataset.open(proven).views()[0].geometry()
    light = "--blink-settings=preferredColorScheme=1"
    text = browser(
        _saved(proven, tmp_path), "tab=space&solid=meshes&camera=0", light, f"--screenshot={shot}", "--dump-dom"
    )
    assert "data-failed" not in text
    picture = cv2.imread(str(shot))
    assert picture is not None
    # The canvas has a ground of its own; the camera's picture is fitted into it, centred.
    rows, columns = np.nonzero((picture == GROUND).all(axis=2))
    inside = picture[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    coloured = np.ptp(inside.astype(int), axis=2) > 18
    height, width = geometry.id.shape
    fit = min(inside.shape[1] / width, inside.shape[0] / height)
    left, top = (inside.shape[1] - fit * width) / 2, (inside.shape[0] - fit * height) / 2
    v, u = np.mgrid[:height, :width]
    seen = coloured[(top + (v + 0.5) * fit).astype(int), (left + (u + 0.5) * fit).astype(int)]
    expected = geometry.crossed.any(axis=0)
    overlap = (seen & expected).sum() / (seen | expected).sum()
    assert overlap > 0.9


@pytest.mark.slow
@pytest.mark.parametrize("tab", ["picture", "maps", "space", "objects"])
def test_no_tab_fails(proven, tmp_path, browser, tab):
    text = browser(
        _saved(proven, tmp_path), f"tab={tab}&map=depth&show=keypoints,boxes,axes&solid=cloud,names", "--dump-dom"
    )
    assert f'data-ready="0-0 {tab}"' in text
    assert "data-failed" not in text


def test_what_cannot_be_done_is_one_line(copy, tmp_path, capsys):
    root = str(copy)
    (tmp_path / "folder.html").mkdir()
    for arguments, words in (
        ([str(tmp_path)], "expected the folder of a data set, with dataset.json, found none"),
        ([root, "--save", str(tmp_path / "a.png")], "--save: expected a file that ends in .html or .htm"),
        ([root, "--rerun", "--save", str(tmp_path / "a.html")], "--save: expected a file that ends in .rrd"),
        ([root, "--save", str(tmp_path / "folder.html")], "--save: expected a file, found the folder"),
        ([root, "--save", str(copy / "scenes" / "a.html")], "--save: expected a file outside the folders of scenes"),
        ([root, "--scenes", "3"], "expected a scene 3"),
        ([root, "--scenes", "x"], "--scenes: expected scenes such as"),
        ([root, "--most-views", "0"], "most_views: expected"),
    ):
        assert main(arguments) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert words in line, line
    (copy / "scenes" / "000000" / "000" / "geometry.exr").write_bytes(b"no picture")
    assert main([root, "--save", str(tmp_path / "a.html")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "geometry.exr: expected an undamaged EXR file" in line
    assert not (tmp_path / "a.html").exists()
