"""Settings of the vessels: sizes, walls, filling, roughness, fineness of the meshes."""

from __future__ import annotations

from typing import Annotated, Literal, get_args

from pydantic import Field, ValidationInfo, field_validator, model_validator

from ...core.model import Model, Ordered
from ...core.units import ANGLE, LENGTH, Length, volume_text
from ...core.user_text import UserPath
from ...core.weighted import Weighted, check_names, unknown_names, weights_of
from ..contents.settings import ContentsSettings
from ..optics.catalogue import MOST_DYE
from ..optics.draw import NO_DYE, dissolves_dyes, glass_names, is_sugar_solution, liquid_names
from ..optics.dyes import DYES
from .amounts import Filled, Limits, Volumes, fill_volumes, volume_limits
from .other_names import OTHER_CATEGORIES, OTHER_GLASSES

Category = Literal[
    "tumbler",
    "beaker",
    "bowl",
    "bottle",
    "stem glass",
    "flask",
    "vase",
    "freeform",
    "faceted glass",
    "fluted glass",
    "ribbed glass",
    "square glass",
    "mug",
    "cup",
    "jug",
    "teapot",
    "double-walled glass",
    "cocktail glass",
    "spouted beaker",
    "test tube",
    "vial",
    "volumetric flask",
    "round flask",
    "square bottle",
    "oval bottle",
    "jar",
    "plastic bottle",
    "plastic cup",
]
CATEGORIES: tuple[Category, ...] = get_args(Category)
#: Families that are no solids of revolution (`shaped_vessels.draw` makes them), and those that are.
SHAPED: frozenset[Category] = frozenset(
    (
        "faceted glass",
        "fluted glass",
        "ribbed glass",
        "square glass",
        "mug",
        "cup",
        "jug",
        "teapot",
        "double-walled glass",
        "spouted beaker",
        "square bottle",
        "oval bottle",
        "plastic bottle",
        "plastic cup",
    )
)
REVOLVED: tuple[Category, ...] = tuple(category for category in CATEGORIES if category not in SHAPED)
#: Units of mesh files, and axes of theirs that point up.
Unit = Literal["m", "cm", "mm", "in"]
UpAxis = Literal["x", "y", "z", "-x", "-y", "-z"]


_Height = Annotated[float, Field(ge=0.04, le=0.30), LENGTH]
_Radius = Annotated[float, Field(ge=0.005, le=0.08), LENGTH]
_Wall = Annotated[float, Field(ge=0.0003, le=0.004), LENGTH]
_Base = Annotated[float, Field(ge=0.0003, le=0.010), LENGTH]
_Concentration = Annotated[float, Field(ge=1e-5, le=MOST_DYE)]
#: Least and most of the brimful volume that a volume of liquid may take [1]: more than a film on the floor, and a level
#: below the rim, whatever the vessel's shape.
LEAST_FILL, MOST_FILL = 0.05, 0.9
#: Factor that absorbs the rounding of products of volumes.
ROUNDING = 1.0 + 1e-9
#: Everyday names, for hints, by the setting.
_OTHERS = {"glasses": OTHER_GLASSES}
_Alpha = Annotated[float, Field(ge=0.001, le=1.0)]


class VesselSettings(Model):
    """Vessels to draw. Ranges are (smallest, largest), both included."""

    categories: Weighted = Field(
        default=CATEGORIES,
        min_length=1,
        description="Families to draw from, equally likely or by weights (beaker=2); those that cannot have the given "
        "sizes are skipped",
        json_schema_extra={"range": f"one or more of {', '.join(CATEGORIES)}"},
    )
    media: UserPath | None = Field(
        default=None, description="YAML file of own media: index, absorption or colour, capillary constants"
    )
    glasses: Weighted | None = Field(
        default=None,
        description="Glasses and plastics to draw from, by weights: names of the catalogue or of own media, such as "
        "'lead crystal=2'; by default what each family is made of",
        json_schema_extra={"range": "one or more names"},
    )
    liquids: Weighted | None = Field(
        default=None,
        description="Liquids to draw from, by weights: names of the catalogue or of own media, such as 'olive oil=2'; "
        "by default mostly water, clear or dyed",
        json_schema_extra={"range": "one or more names"},
    )
    dyes: Weighted | None = Field(
        default=None,
        description="Food dyes of which each drawn liquid but oil gets one, by weights; 'none' is one of them; by "
        "default those of dyed water and dyed sugar solution",
        json_schema_extra={"range": f"one or more of {', '.join([*DYES, NO_DYE])}"},
    )
    dye_concentration: Annotated[tuple[_Concentration, _Concentration], Ordered] | None = Field(
        default=None,
        description="Concentration of `dyes`, within 1e-5 and 1000; by default that of drinks [kg/m^3]",
    )
    volume: Volumes | None = Field(
        default=None,
        description="Nominal volume of the vessel, such as 250ml or 200ml 300ml: its size is scaled to it",
        json_schema_extra={"range": "one or two volumes, each 10ml to 4l"},
    )
    height: Annotated[tuple[_Height, _Height], Ordered] = Field(
        default=(0.04, 0.30), description="Height of the vessel, within 0.04 and 0.30 [m]"
    )
    radius: Annotated[tuple[_Radius, _Radius], Ordered] = Field(
        default=(0.005, 0.08),
        description="Largest outer radius, within 0.005 and 0.08 [m]; rounding may take up to 5 % from it; of "
        "square and oval vessels half the smaller width, without handles and lips",
    )
    wall: Annotated[tuple[_Wall, _Wall], Ordered] = Field(
        default=(0.0003, 0.004), description="Smallest thickness across the wall, within 0.0003 and 0.004 [m]"
    )
    base: Annotated[tuple[_Base, _Base], Ordered] = Field(
        default=(0.0003, 0.010),
        description="Thickness of the base, within 0.0003 and 0.010; never below the wall's [m]",
    )
    fill_probability: float = Field(default=0.6, ge=0.0, le=1.0, description="Probability that a vessel holds a liquid")
    fill: Filled = Field(
        default=(0.1, 0.9),
        description="Fraction of the brimful volume that is filled, within 0 and 1, or a volume such as 150ml or 100ml "
        "200ml, for which vessels are scaled where they are too small or too large; the level stays below the rim",
        json_schema_extra={"range": "a pair, each > 0, <= 1, or one or two volumes"},
    )
    rough_probability: float = Field(default=0.1, ge=0.0, le=1.0, description="Probability that the glass is rough")
    roughness: Annotated[tuple[_Alpha, _Alpha], Ordered] = Field(
        default=(0.02, 0.2), description="GGX alpha of rough glass, within 0.001 and 1"
    )
    closed_probability: float = Field(
        default=0.5,
        ge=0.0,
        le=1.0,
        description="Probability that a vessel that can be closed has its cap, cork, lid or stopper",
    )
    label_probability: float = Field(
        default=0.6,
        ge=0.0,
        le=1.0,
        description="Probability that a bottle, jar or vial has a label, and laboratory glass a print",
    )
    file_probability: float = Field(
        default=1.0, ge=0.0, le=1.0, description="Probability that a vessel comes from `vessel_dir`, if that is given"
    )
    unit: Unit | None = Field(
        default=None,
        description="Unit of the files in `vessel_dir`; by default metres, where that gives a vessel's size",
    )
    up: UpAxis | Literal["fullest"] | None = Field(
        default=None,
        description="Axis of the files in `vessel_dir` that points up, or 'fullest', the one along which a vessel "
        "holds most, or stands on most where it holds nothing; by default y in GLB and z in other files",
    )
    shell: Annotated[float, Field(ge=0.0003, le=0.02), LENGTH] | None = Field(
        default=None,
        description="Thickness that surfaces without one get in `vessel_dir`, inwards, 0.0003 to 0.02 [m]; by default "
        "they are refused",
    )
    contents: ContentsSettings = ContentsSettings()
    smooth: Annotated[float, Field(gt=0.0, le=1.3), ANGLE] | None = Field(
        default=None,
        description="Edges of the files in `vessel_dir` that bend by less than this angle are rounded, such as 50deg, "
        "at most 1.3 [rad]; by default files keep their shape, and edges up to 40deg look smooth",
    )
    chord_error: Length = Field(
        default=15e-6,
        ge=2e-6,
        le=200e-6,
        description="Largest distance of the mesh from the true surface, along rings and along the profile [m]; "
        "it sets the number of segments",
    )

    @field_validator("categories")
    @classmethod
    def _known_families(cls, categories: tuple[str, ...]) -> tuple[str, ...]:
        check_names(weights_of(categories), CATEGORIES, OTHER_CATEGORIES)
        return categories

    @field_validator("glasses", "liquids")
    @classmethod
    def _known_media(cls, names: tuple[str, ...] | None, info: ValidationInfo) -> tuple[str, ...] | None:
        if info.data.get("media") is None:  # with own media, `media.own_media` knows the names
            field = str(info.field_name)
            check_names(_plain_names(names), media_names(field), _OTHERS.get(field))
        return names

    @field_validator("dyes")
    @classmethod
    def _known_dyes(cls, dyes: tuple[str, ...] | None) -> tuple[str, ...] | None:
        check_names(weights_of(dyes or ()), [*DYES, NO_DYE])
        return dyes

    @model_validator(mode="after")
    def _fit_together(self) -> VesselSettings:
        if self.media is None:
            check_dissolving(self)
        if self.dye_concentration is not None and self.dyes is None:
            raise ValueError("dye_concentration: expected dyes with it, found none")
        volumes = fill_volumes(self.fill)
        if volumes is not None and self.volume is not None:
            _check_filling(volumes, volume_limits(self.volume), self)
        return self


def _check_filling(filled: Limits, nominal: Limits, settings: VesselSettings) -> None:
    """Raise ValueError where a liquid's volumes do not fit into vessels of all nominal volumes [m^3]."""
    most, least = MOST_FILL * nominal[0], LEAST_FILL * nominal[1]
    smallest, largest = (settings.volume or ("", ""))[:2]
    if filled[1] > most * ROUNDING:
        limit = f"at most {volume_text(most)} ({100 * MOST_FILL:.0f} % of vessels.volume {smallest})"
        raise ValueError(f"fill: expected {limit}, found {settings.fill[1]}")
    if filled[0] * ROUNDING < least:
        limit = f"at least {volume_text(least)} ({100 * LEAST_FILL:.0f} % of vessels.volume {largest})"
        raise ValueError(f"fill: expected {limit}, found {settings.fill[0]}")


def media_names(field: str, own: tuple[str, ...] = ()) -> list[str]:
    """Return the names that the setting `glasses` or `liquids` may have, those of own media first."""
    return [*own, *(glass_names() if field == "glasses" else liquid_names())]


def unknown_media(settings: VesselSettings, own: tuple[str, ...]) -> dict[str, tuple[str, str]]:
    """Return what was expected and what was found in each of `glasses` and `liquids` that has unknown names."""
    found = {
        field: unknown_names(_plain_names(getattr(settings, field)), media_names(field, own), _OTHERS.get(field))
        for field in ("glasses", "liquids")
    }
    return {field: wrong for field, wrong in found.items() if wrong is not None}


def check_dissolving(settings: VesselSettings) -> None:
    """Raise ValueError where there are dyes, and no liquid that dissolves them."""
    liquids = weights_of(settings.liquids or ())
    if settings.dyes and liquids and not any(dissolves_dyes(name) for name in liquids):
        raise ValueError(f"dyes: expected a liquid that dissolves them, found {', '.join(liquids)}")


def _plain_names(entries: tuple[str, ...] | None) -> list[str]:
    """Return the names of entries without their weights, and without sugar solutions, which any number names."""
    return [name for name in weights_of(entries or ()) if not is_sugar_solution(name)]


def family_weights(settings: VesselSettings) -> dict[Category, float]:
    """Return the weight of each family, in the order of the settings."""
    return {category: weight for category, weight in weights_of(settings.categories).items() if category in CATEGORIES}
