"""Food dyes and plant pigments: published strength and peak, band shapes as sums of Gaussians."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from ...core.model import Model

#: A specific absorbance E(1 %, 1 cm) is decadic, per cm and per 10 g/L. Times this it is Napierian, per m and per g/L.
PER_SPECIFIC_ABSORBANCE = np.log(10.0) * 100.0 / 10.0


class Dye(Model):
    """A dissolved colour. Its specific absorbance at one wavelength is published; its bands give the shape."""

    specific_absorbance: float = Field(gt=0.0, description="E(1 %, 1 cm) at `reference` [1/(cm 10 g/L)]")
    reference: float = Field(description="Wavelength of the specific absorbance [nm]")
    bands: tuple[tuple[float, float, float], ...] = Field(
        description="Peak [nm], relative height [1], full width at half maximum [nm]; Gaussians in wavelength"
    )
    concentrations: tuple[float, float] = Field(description="What is drunk or eaten: lowest and highest [kg/m^3]")
    source: str

    @property
    def valid(self) -> tuple[float, float]:
        """Wavelengths that the bands describe [nm]."""
        return 380.0, 780.0

    def strength(self, wavelength_nm: np.ndarray) -> np.ndarray:
        """Return the Napierian absorption per concentration [1/m per kg/m^3]."""
        return (
            self.specific_absorbance
            * PER_SPECIFIC_ABSORBANCE
            * self._shape(wavelength_nm)
            / self._shape(np.array(self.reference))
        )

    def _shape(self, wavelength_nm: np.ndarray) -> np.ndarray:
        parts = [h * np.exp(-4.0 * np.log(2.0) * ((wavelength_nm - p) / w) ** 2) for p, h, w in self.bands]
        return np.sum(parts, axis=0)


_EU = "Commission Regulation (EU) 231/2012, {}: specific absorbance and peak in water; band widths estimated"


def _dye(number: str, strength: float, peak: float, bands: tuple, drunk: tuple[float, float]) -> Dye:
    return Dye(
        specific_absorbance=strength, reference=peak, bands=bands, concentrations=drunk, source=_EU.format(number)
    )


#: Synthetic food colours. Highest concentrations stay within the 100 mg/L that Regulation (EU) 1129/2011, category
#: 14.1.4 (flavoured drinks), allows for the sum of colours of its group III; the strong triphenylmethane and xanthene
#: dyes are used at a tenth of that, where a drink is already deeply coloured.
DYES: dict[str, Dye] = {
    "tartrazine": _dye("E 102", 530.0, 426.0, ((426.0, 1.0, 95.0),), (0.002, 0.1)),
    "sunset yellow FCF": _dye("E 110", 555.0, 485.0, ((485.0, 1.0, 95.0), (400.0, 0.30, 60.0)), (0.002, 0.1)),
    "azorubine": _dye("E 122", 510.0, 516.0, ((516.0, 1.0, 100.0),), (0.002, 0.1)),
    "allura red AC": _dye("E 129", 540.0, 504.0, ((504.0, 1.0, 105.0),), (0.002, 0.1)),
    "erythrosine": _dye("E 127", 1100.0, 526.0, ((526.0, 1.0, 32.0), (492.0, 0.32, 40.0)), (0.0005, 0.01)),
    "brilliant blue FCF": _dye(
        "E 133", 1630.0, 630.0, ((630.0, 1.0, 42.0), (584.0, 0.2, 50.0), (408.0, 0.13, 40.0)), (0.0005, 0.01)
    ),
    "patent blue V": _dye(
        "E 131", 2000.0, 638.0, ((638.0, 1.0, 48.0), (590.0, 0.2, 50.0), (412.0, 0.2, 45.0)), (0.0005, 0.01)
    ),
}

#: Molar spectra of pure pigments in triolein, the main fat of olive oil: the table `evoodec/pigments/pigments.csv` of
#: the public repository sandroj87/EVOODec. Molar strength times 10 over molar mass (871.2, 568.9 g/mol) is E(1 %).
_TRIOLEIN = "strength and bands fitted to the spectrum in triolein of the program EVOODec"

#: Pigments of virgin olive oil: pheophytins (as pheophytin a) and carotenoids (as lutein). In oil, M. I.
#: Minguez-Mosquera et al., J. Am. Oil Chem. Soc. 68, 332 (1991), doi:10.1007/BF02657688, use 613 at 670 nm and 2000 at
#: 470 nm; the spectra in triolein have 683 and, for lutein and beta-carotene, 1656 and 2268.
PIGMENTS: dict[str, Dye] = {
    "pheophytins": Dye(
        specific_absorbance=683.0,
        reference=670.0,
        # The last stands for the weak bands between the named ones.
        bands=(
            (670.0, 1.0, 21.0),
            (612.0, 0.11, 24.0),
            (537.0, 0.13, 22.0),
            (508.0, 0.16, 26.0),
            (414.0, 1.99, 24.5),
            (560.0, 0.06, 200.0),
        ),
        concentrations=(0.001, 0.02),
        source=f"pheophytin a, {_TRIOLEIN}",
    ),
    "carotenoids": Dye(
        specific_absorbance=2330.0,
        reference=455.0,
        bands=((455.6, 1.0, 24.1), (485.3, 0.932, 27.8), (430.6, 0.611, 26.4), (404.3, 0.423, 38.4)),
        concentrations=(0.001, 0.012),
        source=f"lutein, {_TRIOLEIN}",
    ),
}
