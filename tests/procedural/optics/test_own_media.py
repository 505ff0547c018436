from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.procedural.optics.catalogue import dyed
from glassware.procedural.optics.colour import LIQUID_LENGTH, transmitted_rgb
from glassware.procedural.optics.medium import Medium, eta
from glassware.procedural.optics.own_media import read_media
from glassware.procedural.optics.spectra import absorption

#: Largest difference of a fitted spectrum's colour from the one that was given: half of the last step of 8 bits.
COLOUR_TOLERANCE = 2e-3


@pytest.fixture
def read(tmp_path):
    """The text of a file of own media -> its media by name."""

    def media(text: str) -> dict[str, Medium]:
        path = tmp_path / "media.yaml"
        path.write_text(text, "utf-8")
        return {medium.name: medium for medium in read_media(path)}

    return media


def test_an_index_is_a_number_terms_or_a_table(read):
    media = read(
        "plain: {index: 1.43}\n"
        # Schott's N-BK7, whose n_d is 1.51680 and V_d 64.17.
        "crown: {sellmeier: {B: [1.03961212, 0.231792344, 1.01046945],"
        " C: [0.00600069867, 0.0200179144, 103.560653]}}\n"
        "oil: {cauchy: {A: 1.45, B: 0.004}}\n"
        "table: {index: {400: 1.475, 500: 1.466, 600: 1.4611111, 700: 1.4581633}}\n"
    )
    assert (media["plain"].eta, media["plain"].dispersion) == (1.43, None)
    assert media["crown"].eta == pytest.approx(1.51680, abs=5e-6)
    assert media["crown"].abbe == pytest.approx(64.17, abs=0.01)
    assert media["oil"].eta == pytest.approx(1.45 + 0.004 / 0.5875618**2, abs=1e-6)
    # The table is that of A = 1.45 and B = 0.004 as well.
    np.testing.assert_allclose(eta(media["table"], [450.0, 650.0]), eta(media["oil"], [450.0, 650.0]), atol=1e-6)


def test_a_colour_at_a_depth_is_what_light_has_behind_it_in_rgb_and_by_wavelength(read):
    (medium,) = read("tea: {index: 1.333, colour: {rgb: [0.7, 0.35, 0.1], depth: 5cm}, contact_angle: 25deg}").values()
    assert medium.contact_angle == pytest.approx(np.radians(25.0), rel=1e-12)
    np.testing.assert_allclose(np.exp(-0.05 * np.array(medium.sigma_a)), [0.7, 0.35, 0.1], atol=1e-12)
    np.testing.assert_allclose(transmitted_rgb(medium.absorbers, 0.05), [0.7, 0.35, 0.1], atol=COLOUR_TOLERANCE)
    assert (absorption(medium, np.arange(380.0, 781.0, 5.0)) >= 0.0).all()


def test_an_absorption_is_a_number_three_channels_or_a_table(read):
    media = read(
        "grey: {index: 1.5, absorption: 2}\n"
        "amber: {index: 1.4, absorption: [1.0, 5.0, 20.0]}\n"
        "filter: {index: 1.5, absorption: {400: 40.0, 500: 10.0, 700: 0.0}}\n"
    )
    assert media["grey"].sigma_a == (2.0, 2.0, 2.0)
    np.testing.assert_allclose(absorption(media["grey"], [400.0, 700.0]), 2.0)
    assert media["amber"].sigma_a == (1.0, 5.0, 20.0)
    np.testing.assert_allclose(absorption(media["filter"], [400.0, 450.0, 600.0]), [40.0, 25.0, 5.0])
    spectral = transmitted_rgb(media["filter"].absorbers, LIQUID_LENGTH)
    np.testing.assert_allclose(np.exp(-LIQUID_LENGTH * np.array(media["filter"].sigma_a)), spectral, atol=1e-6)


def test_an_own_liquid_can_be_dyed(read):
    (medium,) = read("tonic: {index: 1.34, absorption: 1.0}").values()
    blue = dyed(medium, "brilliant blue FCF", 0.005)
    assert blue.name == "tonic with 5 mg/L brilliant blue FCF"
    assert blue.sigma_a[0] > 10.0 * blue.sigma_a[2]


def test_an_own_medium_is_stored_whole_and_others_as_before(read):
    (medium,) = read("tonic: {index: 1.34, absorption: 1.0}").values()
    assert Medium.model_validate_json(medium.model_dump_json()) == medium
    water = Medium.model_validate({"name": "w", "eta": 1.3, "absorbers": [{"spectrum": "water", "amount": 1.0}]})
    assert water.model_dump()["absorbers"] == ({"spectrum": "water", "amount": 1.0},)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("water: {index: 1.3}", "expected names that the catalogue does not have, found 'water'"),
        ("sugar solution: {index: 1.3}", "expected names that the catalogue does not have, found 'sugar solution'"),
        ("", "expected own media by name, found none"),
        ("a: {index: 0.9}", "a: index.number: expected greater than or equal to 1, found 0.9"),
        ("a: {index: 4}", "a: index.number: expected less than or equal to 3, found 4"),
        ("a: {index: x}", "a: index.number: expected a number, found 'x'"),
        ("a: {index: {500: 1.3}}", "a: index: expected a table of at least 2 wavelengths, found 1"),
        (
            "a: {index: {400: 1.3, 500: 1.5, 600: 1.3, 700: 1.5}}",
            "a: index: expected indices within 0.002 of a smooth curve through them, found 1.3 at 600 nm",
        ),
        ("a: {cauchy: {A: 3.5}}", "a: cauchy: expected an index of 1 to 3 in visible light"),
        ("a: {sellmeier: {B: [1], C: [0.3]}}", "a: sellmeier: expected an index of 1 to 3 in visible light"),
        ("a: {sellmeier: {B: [1, 2], C: [0.3]}}", "a: sellmeier: expected as many C as B (2), found 1"),
        ("a: {index: 1.3, cauchy: {A: 1.3}}", "expected one of index, sellmeier, cauchy, found index and cauchy"),
        ("a: {absorption: 1}", "a: expected one of index, sellmeier, cauchy, found none"),
        ("a: {index: 1.3, absorption: -1}", "a: absorption.number: expected greater than or equal to 0, found -1"),
        ("a: {index: 1.3, absorption: [1, -2, 3]}", "absorption.channels.1: expected greater than or equal to 0"),
        ("a: {index: 1.3, absorption: {400: 1, 500: -1}}", "absorption.table.500"),
        ("a: {index: 1.3, colour: {rgb: [1, 0, 1], depth: 1}}", "a: colour.rgb.1: expected greater than 0, found 0"),
        (
            "a: {index: 1.3, colour: {rgb: [1, 1, 1], depth: 0}}",
            "a: colour.depth: expected greater than 0 m, found 0 m",
        ),
        ("a: {index: 1.3, contact_angle: 25}", "contact_angle: expected less than or equal to 3.14159 rad (180deg)"),
        ("a: {index: 1.3, contact_angle: 5cm}", "contact_angle: expected an angle in deg or rad"),
        (
            "a: {index: 1.3, absorption: 1, colour: {rgb: [1, 1, 1], depth: 1}}",
            "expected absorption or colour, found both",
        ),
        ("a: {index: 1.3, colur: 3, densty: 1}", "found colur (is it colour?), densty (is it density?)"),
        ("a: 1.3", "a: expected named values (a dict), found 1.3"),
        ("3: {index: 1.3}", "expected texts without = as names of media, found 3"),
        ("a=2: {index: 1.3}", "expected texts without = as names of media, found 'a=2'"),
        ("- a", "expected a mapping of settings, found list"),
    ],
)
def test_what_is_no_medium_is_one_line(read, text, words):
    with pytest.raises(InputError) as error:
        read(text)
    assert words in str(error.value)
    assert "media.yaml" in str(error.value)
    assert "\n" not in str(error.value)
