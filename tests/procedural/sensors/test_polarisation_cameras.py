from __future__ import annotations

import pytest

from glassware.core.errors import InputError
from glassware.procedural.description.polarisation_camera import PolarisationCamera
from glassware.procedural.sensors.polarisation_cameras import POLARISATION_CAMERAS, polarisation_camera


def test_figures_are_those_of_the_measured_sensor():
    """Largest signal-to-noise ratio 40.3 dB and dynamic range 71.2 dB (EMVA 1288)."""
    from math import log10

    device = POLARISATION_CAMERAS["imx250mzr"]
    assert 20 * log10(device.full_well**0.5) == pytest.approx(40.3, abs=0.05)
    assert 20 * log10(device.full_well / device.read_noise) == pytest.approx(71.2, abs=0.05)


def test_a_file_changes_what_it_names_and_keeps_the_rest(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("like: imx250myr\nname: lab\nextinction_ratio: 80\n", encoding="utf-8")
    device = polarisation_camera(path)
    assert device is not None
    known = POLARISATION_CAMERAS["imx250myr"]
    assert device == known.model_copy(update={"name": "lab", "extinction_ratio": 80.0, "source": device.source})
    assert PolarisationCamera.model_validate_json(device.model_dump_json()) == device
    assert polarisation_camera("none") is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("like: imx250\n", "like: expected one of imx250mzr, imx250myr"),
        ("like: imx250mzr\nextinction_ratio: 1\n", "extinction_ratio"),
        ("like: imx250mzr\nbits: 40\n", "bits"),
        ("like: imx250mzr\nsamples: 0\n", "samples"),
        ("name: mine\n", "angles: expected a value, or like: imx250mzr for all that the file leaves out, found none"),
        ("like: imx250mzr\nblack_level: 1\n", "black_level: expected less than 1, found 1"),
        ("like: imx250mzr\nangles: [[0, 45], [180, 45]]\n", "angles: expected three different axes or more"),
    ],
)
def test_a_device_that_cannot_be_is_one_line(tmp_path, text, words):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as error:
        polarisation_camera(path)
    assert words in str(error.value)
    assert "\n" not in str(error.value)
