from __future__ import annotations

import base64
import re
import shutil
import subprocess
import tracemalloc

import cv2
import numpy as np
import pytest

from glassware.dataset.commands.report import main
from glassware.dataset.reader import Dataset
from glassware.dataset.report.summary import summarise

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
#: Most memory that a scene of this size may leave behind [bytes]: ten thousand then take 100 MB.
MOST_A_SCENE = 10_000


def test_the_page_loads_nothing_and_runs_nothing(files, page):
    assert main([str(files.root)]) == 0
    shown = page(files.root / "report.html")
    assert not {"script", "link", "iframe", "object", "embed", "form"} & set(shown.tags)
    assert shown.references
    assert all(one.startswith(("#", "data:image/jpeg;base64,")) for one in shown.references)
    assert "default-src 'none'" in shown.text
    assert not re.search(r"url\(|@import|https?:", shown.text)
    assert shown.text.count("&lt;script&gt;") >= 4  # name, family, finding, failure


def test_the_same_data_set_gives_the_same_page(files, tmp_path):
    for name in ("a.html", "b.html"):
        assert main([str(files.root), "--out", str(tmp_path / name)]) == 0
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_simplified_light_and_a_sensor_are_named(files, page):
    assert main([str(files.root)]) == 0
    assert "simplified light" not in page(files.root / "report.html").text
    picture = {"refractivity": 0.5, "air_gap": True, "spectral": True}
    changed = {"sensitivities": {"name": "nikon-d5100"}, "picture": picture}
    files.change(files.scenes[1] / "scene.json", lambda data: data.update(changed))
    assert main([str(files.root)]) == 0
    shown = page(files.root / "report.html")
    lead = shown.text.partition("</header>")[0]
    assert "simplified light: picture.air_gap yes (true: no), picture.refractivity 0.5 (true: 1)" in lead
    assert "sensor nikon-d5100" in lead
    assert shown.counts("optics") == {"picture.air_gap yes (true: no)": 1, "picture.refractivity 0.5 (true: 1)": 1}
    assert shown.counts("colour_sensors") == {"nikon-d5100": 1}


@pytest.mark.parametrize(("most", "count"), [(0, 0), (2, 2), (48, 3)])
def test_the_gallery_has_so_many_first_left_pictures(files, tmp_path, most, count):
    out = tmp_path / "page.html"
    assert main([str(files.root), "--out", str(out), "--pictures", str(most)]) == 0
    found = re.findall(r'src="data:image/jpeg;base64,([^"]+)"', out.read_text("utf-8"))
    assert len(found) == count
    for data in found:
        picture = cv2.imdecode(np.frombuffer(base64.b64decode(data), np.uint8), cv2.IMREAD_COLOR)
        assert picture is not None
        stored = cv2.imread(str(files.views[0] / "left.png"))
        assert stored is not None
        assert picture.shape == stored.shape
        # JPEG of a tiny picture: a few steps of 255 in the mean.
        assert np.abs(picture.astype(float) - stored).mean() < 12


def test_a_data_set_without_log_splits_and_scenes_has_a_page(copy, page):
    shutil.rmtree(copy / "scenes")
    (copy / "scenes").mkdir()
    assert main([str(copy)]) == 0
    shown = page(copy / "report.html")
    assert "0 scenes of seed" in shown.text
    assert "No attempt is in a build.jsonl" in shown.text


def test_memory_does_not_hold_the_scenes(files):
    dataset = Dataset.open(files.root)
    summarise(dataset, 0)  # loads and compiles what the first reading needs
    for number in range(3, 20):
        files.add_scene(number)
    tracemalloc.start()
    try:
        summary = summarise(dataset, 0)
        left, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert summary.scenes == 20
    assert left / summary.scenes < MOST_A_SCENE


@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
@pytest.mark.parametrize(("scheme", "ground"), [("dark", (27, 24, 24)), ("light", (255, 255, 255))])
def test_a_browser_shows_it_in_the_colours_of_the_system(files, tmp_path, scheme, ground):
    out, shot = tmp_path / "page.html", tmp_path / "shot.png"
    assert main([str(files.root), "--out", str(out)]) == 0
    command = [str(CHROMIUM), "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
    command += [f"--user-data-dir={tmp_path / 'profile'}", "--host-resolver-rules=MAP * ~NOTFOUND"]
    command += [f"--blink-settings=preferredColorScheme={0 if scheme == 'dark' else 1}"]
    command += ["--window-size=1280,1400", f"--screenshot={shot}", out.as_uri()]
    subprocess.run(command, capture_output=True, timeout=120, check=True)
    picture = cv2.imread(str(shot))
    assert picture is not None
    assert tuple(picture[-1, 0].tolist()) == ground
    # The gallery's pictures and the bars are on the screen: neither is grey.
    saturation = np.ptp(picture.astype(int), axis=2)
    assert np.count_nonzero(saturation > 60) > 5000
