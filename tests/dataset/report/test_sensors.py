from __future__ import annotations

import numpy as np

from glassware.dataset.commands.report import main
from glassware.dataset.format.checksums import write_checksums


def test_the_numbers_of_each_vessel_and_the_devices_are_on_the_page(files, page):
    """Five numbers of a depth camera and a degree of polarisation for each vessel, null for those of too few pixels."""
    given: dict[str, list[float]] = {}
    names = [*(f"sensor_{name}" for name in ("missing", "right", "behind", "front", "rim")), "polarisation_degree"]
    rng = np.random.default_rng(1)
    for folder in files.scenes:
        objects = files.read(folder, "objects.json")["objects"]
        vessels = {one["id"] for one in objects if one["material"]["kind"] == "glass"}

        def sensed(data: dict, vessels: set[int] = vessels) -> None:
            for row in data["views"]:
                row |= {"sensor_depth": f"{row['path']}/sensor_depth.png", "sensor_measured": 0.75}
                for name in names:
                    row[name] = [float(value) for value in rng.uniform(0.0, 1.0, len(row["object_ids"]))]
                    row[name][0] = None
                    pairs = zip(row["object_ids"], row[name], strict=True)
                    given.setdefault(name, []).extend(v for i, v in pairs if i in vessels and v is not None)

        files.change(folder / "views.json", sensed)
        devices = {"depth_camera": {"name": "d435"}, "polarisation_camera": {"name": "imx250mzr"}}
        files.change(folder / "scene.json", lambda data, devices=devices: data.update(devices))
        (folder / "checksums.json").unlink()
        write_checksums(folder)
    assert main([str(files.root)]) == 0
    shown = page(files.root / "report.html")
    assert len(given["sensor_rim"]) >= 3
    for name, values in given.items():
        factor = 1.0 if name == "sensor_rim" else 100.0
        found = shown.statistics(name)
        assert found["n"] == len(values)
        np.testing.assert_allclose(found["median"], factor * np.median(values), rtol=1e-3)
    assert shown.counts("depth_cameras") == {"d435": 3}
    assert shown.counts("polarisation_cameras") == {"imx250mzr": 3}
