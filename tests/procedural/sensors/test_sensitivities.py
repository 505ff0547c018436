"""Sensitivities of sensors: published ones, those of a user's file, and the colour matrix that follows from them."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from glassware.core.errors import InputError
from glassware.procedural.description.sensitivities import Sensitivities
from glassware.procedural.scene.settings import SceneSettings
from glassware.procedural.sensors import colour_matrix
from glassware.procedural.sensors.sensitivities import PUBLISHED, check_sensitivities, sensitivities

#: Mean and largest colour difference of the chart's 24 patches in D65, as docs/cameras.md states them [CIE Delta E
#: 2000].
STATED = {"nikon-d5100": (0.93, 3.10), "sigma-sd-merrill": (1.96, 4.11)}
DIGITS = 0.01
ROWS = ["400,0.1,0.2,0.3", *(f"{nm},{nm / 700:.4f},0.5,{400 / nm:.4f}" for nm in range(420, 681, 20))]


@pytest.fixture(scope="module")
def colour():
    return colour_matrix.colour_science()


@pytest.fixture
def csv(tmp_path):
    """Lines -> a CSV file of them."""

    def write(*lines: str) -> str:
        path = tmp_path / "own.csv"
        path.write_text("\n".join(lines) + "\n")
        return str(path)

    return write


def named(name: str) -> Sensitivities:
    found = sensitivities(name)
    assert found is not None
    return found


@pytest.mark.parametrize("name", PUBLISHED)
def test_colours_of_a_chart_that_the_matrix_was_not_fitted_to_differ_by_what_the_docs_state(colour, name):
    sensor, light = named(name), colour_matrix.daylight()
    patches = colour.SDS_COLOURCHECKERS["BabelColor Average"].values()
    reflected = light * np.stack([np.interp(colour_matrix.NM, one.wavelengths, one.values) for one in patches])
    curves = sensor.at(colour_matrix.NM)
    raw = reflected @ curves / (light @ curves)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    xyz = np.stack([np.interp(colour_matrix.NM, observer.wavelengths, one) for one in observer.values.T], axis=1)
    white = light @ xyz
    seen = raw @ np.array(sensor.matrix).T @ colour.RGB_COLOURSPACES["ITU-R BT.709"].matrix_RGB_to_XYZ.T
    lab = [colour.XYZ_to_Lab(one, colour.XYZ_to_xy(white)) for one in (seen, reflected @ xyz / white[1])]
    differences = colour.delta_E(*lab, method="CIE 2000")
    assert (differences.mean(), differences.max()) == pytest.approx(STATED[name], abs=DIGITS)


def test_white_daylight_is_white_and_saturates_the_channels_by_their_curves():
    sensor, light = named("nikon-d5100"), colour_matrix.daylight()
    signals = np.trapezoid(light[:, None] * sensor.at(colour_matrix.NM), colour_matrix.NM, axis=0)
    assert sensor.white == pytest.approx(signals / signals[1], rel=1e-3)  # ends of the range count half here
    assert np.array(sensor.matrix) @ np.ones(3) == pytest.approx(np.ones(3))
    assert sensor.at(np.array([300.0, 900.0])).max() == 0.0


def test_a_file_of_published_curves_is_the_published_sensor(csv):
    published = named("sigma-sd-merrill")
    rows = np.column_stack([published.wavelengths, published.curves])
    own = named(csv("wavelength, red, green, blue", *(",".join(map(repr, row)) for row in rows.tolist()), ""))
    assert own.name == "own"
    same = {"curves": own.curves, "white": own.white, "matrix": own.matrix}
    for name, value in same.items():
        np.testing.assert_array_equal(value, getattr(published, name))


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ((), "own.csv: expected wavelengths from 400 nm or less to 680 nm or more, found none"),
        (ROWS[1:], "own.csv: expected wavelengths from 400 nm or less to 680 nm or more, found 420 to 680 nm"),
        (ROWS[:-1], "own.csv: expected wavelengths from 400 nm or less to 680 nm or more, found 400 to 660 nm"),
        (("nm,r,g,b", "nm,r,g,b"), "line 2: expected a wavelength [nm] and values of red, green and blue, found"),
        ((ROWS[0], "420,1,2"), "line 2: expected a wavelength [nm] and values of red, green and blue, found '420,1,2'"),
        ((ROWS[0], "420,1,-2,3"), "line 2: expected finite numbers that are not negative, found '420,1,-2,3'"),
        ((ROWS[0], "420,1,nan,3"), "line 2: expected finite numbers that are not negative, found '420,1,nan,3'"),
        ((ROWS[0], ROWS[0]), "line 2: expected a wavelength after 400 nm, by 20 nm or less, found 400 nm"),
        ((ROWS[0], ROWS[2]), "line 2: expected a wavelength after 400 nm, by 20 nm or less, found 440 nm"),
        ([f"{row.rpartition(',')[0]},0" for row in ROWS], "own.csv: expected light that blue sees, found zeros alone"),
        ([f"{nm},1,2,{nm}" for nm in range(400, 681, 20)], "own.csv: expected three different curves, found"),
    ],
    ids=range(11),
)
def test_a_wrong_file_is_told_of_in_one_line(csv, lines, says):
    with pytest.raises(InputError) as found:
        check_sensitivities(csv(*lines))
    assert says in str(found.value)
    assert "\n" not in str(found.value)


def test_sensitivities_belong_to_wavelengths():
    with pytest.raises(
        ValidationError, match=r"picture.spectral: expected on, .* found sensors.sensitivities nikon-d5100"
    ):
        SceneSettings.model_validate({"sensors": {"sensitivities": "nikon-d5100"}})
    kept = SceneSettings.model_validate({"sensors": {"sensitivities": "nikon-d5100"}, "picture": {"spectral": True}})
    assert kept.sensors.sensitivities == "nikon-d5100"


def test_an_unknown_sensor_and_a_missing_extra_are_one_line_each(monkeypatch):
    expected = "sensors.sensitivities: expected one of none, nikon-d5100, sigma-sd-merrill, or a CSV file"
    with pytest.raises(InputError, match=expected):
        check_sensitivities("nikon")
    monkeypatch.setattr(colour_matrix, "_PACKAGE", "no-such-package")
    with pytest.raises(InputError, match=r"expected its extra, as in pip install 'glassware\[colour\]', found no pack"):
        check_sensitivities("nikon-d5100")
