"""The catalogue of media: glasses, plastics and liquids with their published constants. ``docs/media.md`` shows it."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from ...core.arguments import check_type, number
from ...core.errors import InputError
from ...core.setting_errors import suggest
from .colour import LIQUID_LENGTH, WALL_LENGTH, rgb_absorption
from .dispersion import D_LINE, SODIUM_LINE, Cauchy, Dispersion, Power, Scaled, Sellmeier, abbe_number, index
from .dyes import DYES
from .medium import ETA_DIGITS, Absorber, Medium

#: Most of a dye in a liquid [kg/m^3]: the density of water, as a solution holds less dye than solvent.
MOST_DYE = 1000.0

SODA_LIME = Cauchy(
    A=1.5130,
    B=0.003962,
    D=-0.003169,
    valid=(310.0, 4600.0),
    source="Rubin 1985, eq. for n, doi:10.1016/0165-1633(85)90052-8",
)
#: Least-squares fit to the six indices of the data sheet (`test_catalogue.py` has them); largest
#: residual 1.1e-5.
BOROSILICATE = Cauchy(
    A=1.461727,
    B=0.0035686,
    D=-0.001958,
    valid=(435.0, 660.0),
    source="Schott, BOROFLOAT 33 data sheet (glass to ISO 3585), indices at 435.8-656.3 nm; fit",
)
FUSED_SILICA = Sellmeier(
    B=(0.6961663, 0.4079426, 0.8974794),
    C=(0.0684043**2, 0.1162414**2, 9.896161**2),
    valid=(210.0, 3710.0),
    source="Malitson 1965, eq. 1, 20 degC, doi:10.1364/JOSA.55.001205",
)
LEAD_CRYSTAL = Sellmeier(
    B=(1.21640125, 0.13366454, 0.883399468),
    C=(0.00857807248, 0.0420143003, 107.59306),
    valid=(310.0, 2500.0),
    source="Schott data sheet LLF1 (548458.294), catalogue of 2017-01-20",
)
HEAVY_LEAD_CRYSTAL = Sellmeier(
    B=(1.28035628, 0.163505973, 0.893930112),
    C=(0.00929854416, 0.0449135769, 110.493685),
    valid=(320.0, 2325.0),
    source="Schott data sheet LF5 (581409.322), catalogue of 2017-01-20",
)
ACRYLIC = Power(
    coefficients=(2.1778, 6.1209e-3, -1.5004e-3, 2.3678e-2, -4.2137e-3, 7.3417e-4, -4.5042e-5),
    exponents=(0, 2, 4, -2, -4, -6, -8),
    valid=(420.0, 1620.0),
    source="Beadie et al. 2015, 20.1 degC, doi:10.1364/AO.54.00F139",
)
POLYCARBONATE = Sellmeier(
    B=(1.4182,),
    C=(0.021304,),
    valid=(436.8, 1052.0),
    source="Sultanova et al. 2009, Acta Phys. Pol. A 116, 585; one-term fit of refractiveindex.info",
)
#: Least-squares fit to the indices of Zhang et al. at 400-800 nm; largest residual 9.4e-4.
PET = Cauchy(
    A=1.543147, B=0.0074267, C=0.00052226, valid=(400.0, 800.0), source="Zhang et al. 2020, fit, doi:10.1364/AO.383831"
)
WATER = Sellmeier(
    B=(0.5684027565, 0.1726177391, 0.02086189578, 0.1130748688),
    C=(0.005101829712, 0.01821153936, 0.02620722293, 10.69792721),
    absolute=True,  # Its n_D is 1.33335, that of water against vacuum; against air it is 1.33299.
    valid=(182.0, 1129.0),
    source="Daimon and Masumura 2007, table 3, 20.0 degC, doi:10.1364/AO.46.003811",
)
ETHANOL = Cauchy(
    A=1.35265,
    B=0.00306,
    C=0.00002,
    valid=(476.5, 830.0),
    source="Rheims et al. 1997, 20 degC, doi:10.1088/0957-0233/8/6/003",
)
GLYCEROL = Cauchy(
    A=1.46004,
    B=0.00394934611,
    C=-0.0000177343,
    valid=(400.0, 710.0),
    source="Gupta et al. 2022, supporting information, doi:10.1002/adpr.202200152",
)
#: Index 1.4691 at the sodium line, the middle of Codex Alimentarius CXS 33-1981 (1.4677-1.4705, 20 degC); the shape is
#: that of oleic acid, of which most of olive oil is an ester. Measured at 495-670 nm, carried on to the F line.
OLIVE_OIL = Cauchy(
    A=1.455124,
    B=0.004565,
    C=0.0001,
    valid=(480.0, 680.0),
    source="Codex CXS 33-1981 (index); Jones et al. 2015, oleic acid (dispersion), doi:10.1039/C4CP05015A",
)
#: Least-squares fit to the 32 indices of Warren and Brandt at 400 to 710 nm, 266 K; largest residual 1.3e-4.
ICE = Cauchy(
    A=1.300020,
    B=0.00356245,
    C=-0.000077096,
    valid=(400.0, 710.0),
    source="Warren and Brandt 2008, fit, doi:10.1029/2007JD009744",
)
#: Sucrose in water by mass fraction at 20 degC: n_D and density [kg/m^3]. ICUMSA 1974 (as in AOAC 990.35) and NBS
#: Circular 440 (1942), table 114.
SUCROSE = (
    (0.00, 1.33299, 998.2),
    (0.10, 1.34782, 1038.1),
    (0.20, 1.36384, 1081.0),
    (0.30, 1.38115, 1127.0),
    (0.40, 1.39986, 1176.4),
    (0.50, 1.42009, 1229.6),
    (0.60, 1.44193, 1286.5),
)
#: Surface tensions at 20 degC [N/m]: IAPWS R1-76(2014) for water; Vazquez et al. 1995, doi:10.1021/je00019a016, for
#: ethanol; CRC Handbook for glycerol. Sucrose raises that of water by 4 mN/m at 60 % (CRC Handbook, 25 degC).
WATER_TENSION, ETHANOL_TENSION, GLYCEROL_TENSION, OLIVE_TENSION = 0.07274, 0.02231, 0.0634, 0.0320
SUCROSE_TENSION_RISE = 0.0066
#: Contact angles on washed household glass. Freshly flamed glass is wet by water at 0 degrees and everyday glass at
#: 20-40 (Sumner et al. 2004, doi:10.1016/j.apsusc.2004.01.022).
WATER_ANGLE, ETHANOL_ANGLE, GLYCEROL_ANGLE, OLIVE_ANGLE = (
    math.radians(25.0),
    0.0,
    math.radians(20.0),
    math.radians(20.0),
)


def _medium(
    name: str, formula: Dispersion, absorbers: tuple[Absorber, ...], longest: float, **fields: object
) -> Medium:
    return Medium.model_validate(
        {
            "name": name,
            "eta": round(float(index(formula, D_LINE)), ETA_DIGITS),
            "sigma_a": rgb_absorption(absorbers, longest),
            "dispersion": formula,
            "absorbers": absorbers,
            "abbe": abbe_number(formula),
            **fields,
        }
    )


def _wall(name: str, formula: Dispersion, density: float, source: str, *absorbers: Absorber) -> Medium:
    return _medium(name, formula, absorbers, WALL_LENGTH, density=density, source=source)


def soda_lime(iron: float = 0.3) -> Medium:
    """Return colourless soda-lime glass.

    Parameters
    ----------
    iron : float
        0 is low-iron glass, 1 window glass, in between their mixture: bottles and tumblers of clear ("flint") glass
        have 0.02-0.08 % Fe2O3, low-iron glass about 0.01-0.02 and window glass about 0.1.
    """
    if not 0.0 <= iron <= 1.0:
        raise InputError("soda-lime glass, iron", "a fraction in [0, 1]", iron)
    parts = (
        Absorber(spectrum="soda-lime, low-iron", amount=1.0 - iron),
        Absorber(spectrum="soda-lime, clear", amount=iron),
    )
    return _wall("soda-lime glass", SODA_LIME, 2500.0, f"{SODA_LIME.source}; density EN 572-1", *parts)


def tinted_soda_lime(tint: str) -> Medium:
    """Return window glass coloured in the mass: ``"green"``, ``"bronze"`` or ``"grey"`` (Rubin 1985)."""
    if tint not in ("green", "bronze", "grey"):
        raise InputError("tinted glass", "green, bronze or grey", tint)
    part = Absorber(spectrum=f"soda-lime, {tint}", amount=1.0)
    return _wall(f"{tint} soda-lime glass", SODA_LIME, 2500.0, f"{SODA_LIME.source}; density EN 572-1", part)


def sugar_solution(sugar: float, *dyes: Absorber) -> Medium:
    """Return sucrose in water, with dyes if given.

    Parameters
    ----------
    sugar : float
        Mass fraction of sucrose, 0-0.6 [1].
    dyes : Absorber
        Dyes of `dyes.DYES` with their concentrations.
    """
    fractions, indices, densities = np.array(SUCROSE).T
    if not 0.0 <= sugar <= fractions[-1]:
        raise InputError("sugar solution, mass fraction", f"a fraction in [0, {fractions[-1]:g}]", sugar)
    density = float(np.interp(sugar, fractions, densities))
    factor = float(np.interp(sugar, fractions, indices) - 1.0) / (indices[0] - 1.0)
    formula = Scaled(base=WATER, factor=factor, source=f"ICUMSA 1974 at the sodium line; dispersion of {WATER.source}")
    # Sucrose does not absorb visible light; the water in the solution does, by its concentration.
    water = Absorber(spectrum="water", amount=(1.0 - sugar) * density / densities[0])
    return _medium(
        _named(f"{100.0 * sugar:.0f} % sugar solution", dyes),
        formula,
        (water, *dyes),
        LIQUID_LENGTH,
        density=density,
        surface_tension=WATER_TENSION + SUCROSE_TENSION_RISE * sugar,
        contact_angle=WATER_ANGLE,
        source=f"{formula.source}; density NBS Circular 440",
    )


def water(*dyes: Absorber) -> Medium:
    """Return water, with dyes of `dyes.DYES` if given."""
    return _medium(
        _named("water", dyes),
        WATER,
        (Absorber(spectrum="water", amount=1.0), *dyes),
        LIQUID_LENGTH,
        density=998.2,
        surface_tension=WATER_TENSION,
        contact_angle=WATER_ANGLE,
        source=f"{WATER.source}; surface tension IAPWS R1-76(2014)",
    )


def ice() -> Medium:
    """Return ice near its melting point. It absorbs less than 1 % of visible light over 20 mm, which is left out."""
    source = f"{ICE.source}; density CRC Handbook, 0 degC"
    return _medium("ice", ICE, (), LIQUID_LENGTH, density=916.7, source=source)


def olive_oil(pheophytins: float = 0.006, carotenoids: float = 0.005) -> Medium:
    """Return virgin olive oil with these concentrations of its pigments [kg/m^3]."""
    parts = (
        Absorber(spectrum="pheophytins", amount=pheophytins),
        Absorber(spectrum="carotenoids", amount=carotenoids),
    )
    return _medium(
        "olive oil",
        OLIVE_OIL,
        parts,
        LIQUID_LENGTH,
        density=911.4,
        surface_tension=OLIVE_TENSION,
        contact_angle=OLIVE_ANGLE,
        source=f"{OLIVE_OIL.source}; density Codex CXS 33-1981 (0.910 to 0.916 of water's)",
    )


def _named(solvent: str, dyes: tuple[Absorber, ...]) -> str:
    parts = [f"{1e3 * dye.amount:.3g} mg/L {dye.spectrum}" for dye in dyes]
    return f"{solvent} with {' and '.join(parts)}" if parts else solvent


def _clear_liquid(name: str, formula: Cauchy, density: float, tension: float, angle: float) -> Medium:
    fields = {"density": density, "surface_tension": tension, "contact_angle": angle, "source": formula.source}
    return _medium(name, formula, (), LIQUID_LENGTH, **fields)


def dyed(medium: Medium, dye: str, concentration: float) -> Medium:
    """Return a liquid with a dye dissolved in it; its index and its surface tension stay the same.

    Parameters
    ----------
    medium : Medium
        A liquid whose absorption is known by wavelength, or that has none.
    dye : str
        Name in `dyes.DYES`, such as ``"brilliant blue FCF"``.
    concentration : float
        Of the dye [kg/m^3]; a soft drink has 0.002 to 0.1.

    Raises
    ------
    InputError
        For an unknown dye, an impossible concentration, or a medium of which only `sigma_a` is known.
    """
    check_type("dye", dye, str, "the name of a dye")
    if dye not in DYES:
        raise InputError("dye", f"one of {', '.join(DYES)}{suggest(dye, list(DYES))}", repr(dye))
    concentration = number("concentration of the dye", concentration, 0.0, MOST_DYE, "kg/m^3")
    if any(medium.sigma_a) and not medium.absorbers:
        raise InputError(f"medium {medium.name}", "absorbers, to add a dye to them", "sigma_a alone")
    parts = (*medium.absorbers, Absorber(spectrum=dye, amount=concentration))
    changes = {"absorbers": parts, "sigma_a": rgb_absorption(parts, LIQUID_LENGTH)}
    return medium.model_copy(update={"name": _named(medium.name, parts[-1:]), **changes})


def glass_named(name: str) -> Medium:
    """Return a glass or plastic by its name; InputError with the nearest name where the catalogue has none."""
    known = {medium.name: medium for medium in glasses()}
    if name not in known:
        raise InputError("glass", f"one of {', '.join(known)}{suggest(name, list(known))}", repr(name))
    return known[name]


def catalogue() -> dict[str, Medium]:
    """Return every medium with its standard composition, by name."""
    return {medium.name: medium for medium in (*glasses(), *liquids())}


@cache
def glasses() -> tuple[Medium, ...]:
    """Return the media of walls. Those without absorbers lose less than 1 % over 10 mm in the visible."""
    return (
        soda_lime(),
        *(tinted_soda_lime(tint) for tint in ("green", "bronze", "grey")),
        _wall("borosilicate glass 3.3", BOROSILICATE, 2230.0, f"{BOROSILICATE.source}; density ISO 3585"),
        _wall("fused silica", FUSED_SILICA, 2203.0, f"{FUSED_SILICA.source}; density Heraeus Suprasil data sheet"),
        _wall("lead crystal", LEAD_CRYSTAL, 2940.0, LEAD_CRYSTAL.source, _all("lead glass LLF1")),
        _wall("heavy lead crystal", HEAVY_LEAD_CRYSTAL, 3220.0, HEAVY_LEAD_CRYSTAL.source, _all("lead glass LF5")),
        _wall("acrylic", ACRYLIC, 1190.0, f"{ACRYLIC.source}; density ISO 8257-1 grades"),
        _wall(
            "polycarbonate",
            POLYCARBONATE,
            1200.0,
            f"{POLYCARBONATE.source}; absorption Zhang et al. 2020",
            _all("polycarbonate"),
        ),
        _wall("PET", PET, 1360.0, f"{PET.source}; density of bottle walls, 1350 to 1370", _all("PET")),
    )


@cache
def liquids() -> tuple[Medium, ...]:
    """Return the liquids in their standard composition, without dyes."""
    return (
        water(),
        sugar_solution(0.1),
        _clear_liquid("ethanol", ETHANOL, 789.3, ETHANOL_TENSION, ETHANOL_ANGLE),
        _clear_liquid("glycerol", GLYCEROL, 1261.0, GLYCEROL_TENSION, GLYCEROL_ANGLE),
        olive_oil(),
    )


def _all(spectrum: str) -> Absorber:
    return Absorber(spectrum=spectrum, amount=1.0)


def sodium_index(medium: Medium) -> float:
    """Return the index at the sodium D line, which tables of liquids give."""
    return medium.eta if medium.dispersion is None else float(index(medium.dispersion, SODIUM_LINE))
