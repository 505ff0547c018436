"""What there is to choose from: glasses, liquids, dyes, families of vessels, props, tables and presets."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from ...core.arguments import as_path
from ...core.units import volume_text
from ...procedural.optics.catalogue import glasses, liquids
from ...procedural.optics.draw import liquid_names
from ...procedural.optics.dyes import DYES, Dye
from ...procedural.optics.medium import Medium
from ...procedural.optics.own_media import read_media
from ...procedural.tables.kinds import TABLE_KINDS
from ...procedural.tables.prints import PRINT_KINDS
from ...procedural.things.kinds import KINDS
from ...procedural.vessels.families import FAMILIES
from ...procedural.vessels.family_pieces import Family
from ...procedural.vessels.settings import VesselSettings
from ...procedural.vessels.sizes import NOMINAL, volumes_of
from .config import preset_names


@dataclass(frozen=True, repr=False)
class Catalogue:
    """What settings and changes of a scene can name."""

    glasses: dict[str, Medium]  #: media of walls, by name
    liquids: dict[str, Medium]  #: liquids in their standard composition, by name
    mixtures: tuple[str, ...]  #: names for `vessels.liquids` that are drawn with random parts
    dyes: dict[str, Dye]  #: food dyes, by name
    families: dict[str, Family]  #: vessels: heights, radii and walls [m], by name
    volumes: dict[str, tuple[float, float]]  #: smallest and largest nominal volume of each family [m^3]
    props: dict[str, tuple[float, float]]  #: everyday things: range of the longest side [m], by kind
    tables: tuple[str, ...]  #: kinds of tables
    prints: tuple[str, ...]  #: kinds of flat prints on tables
    presets: tuple[str, ...]  #: names of presets
    own: dict[str, Medium] = field(default_factory=dict)  #: media of a file of one's own, by name

    def __repr__(self) -> str:
        """Return a table of everything, to print."""
        return "\n".join(_lines(self))


def catalogue(media: Path | str | None = None) -> Catalogue:
    """Return what the toolkit has: glasses, liquids, dyes, families of vessels, presets.

    Parameters
    ----------
    media : Path or str, optional
        YAML file of own media, as `vessels.media` names it, which become `Catalogue.own`.

    Raises
    ------
    InputError
        Where the file cannot be read, or has an impossible medium.
    """
    own = {} if media is None else {medium.name: medium for medium in read_media(as_path("catalogue: media", media))}
    settings, limits = VesselSettings(), {}
    for name in FAMILIES:
        low, high = volumes_of(settings, name)
        limits[name] = (low * NOMINAL.get(name, 1.0), high * NOMINAL.get(name, 1.0))
    found = {medium.name: medium for medium in liquids()}
    return Catalogue(
        glasses={medium.name: medium for medium in glasses()},
        liquids=found,
        mixtures=tuple(name for name in liquid_names() if name not in found),
        dyes=dict(DYES),
        families={str(name): family for name, family in FAMILIES.items()},
        volumes=limits,
        props={name: kind.longest for name, kind in KINDS.items()},
        tables=TABLE_KINDS,
        prints=PRINT_KINDS,
        presets=tuple(preset_names()),
        own=own,
    )


def _lines(found: Catalogue) -> Iterator[str]:
    yield "glasses (vessels.glasses, with_glass): refractive index at 588 nm"
    yield from (f"  {name:26}{medium.eta:.4f}" for name, medium in found.glasses.items())
    yield "liquids (vessels.liquids, with_liquid): refractive index at 588 nm"
    yield from (f"  {name:26}{medium.eta:.4f}" for name, medium in found.liquids.items())
    yield f"  drawn with random parts: {', '.join(found.mixtures)}; N % sugar solution, N up to 60"
    if found.own:
        yield "own media"
        yield from (f"  {name:26}{medium.eta:.4f}" for name, medium in found.own.items())
    yield "dyes (vessels.dyes, with_dye): concentrations in drinks [kg/m^3]"
    yield from (f"  {n:26}{dye.concentrations[0]:g} to {dye.concentrations[1]:g}" for n, dye in found.dyes.items())
    yield "families (vessels.categories): heights [mm], and nominal volumes as drawn without vessels.volume"
    for name, family in found.families.items():
        low, high = (volume_text(float(f"{volume:.2g}")) for volume in found.volumes[name])
        yield f"  {name:26}{1e3 * family.height[0]:.0f} to {1e3 * family.height[1]:.0f} mm, {low} to {high}"
    yield "props (props.kinds): longest side [mm]; and `shape`, plain bodies"
    yield from (f"  {name:26}{1e3 * low:.0f} to {1e3 * high:.0f}" for name, (low, high) in found.props.items())
    yield f"tables (table.kinds): {', '.join(found.tables)}"
    yield f"prints on tables (table.print_kinds): {', '.join(found.prints)}"
    yield f"presets: {', '.join(found.presets)}"
