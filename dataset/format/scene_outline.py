"""The small parts of ``scene.json``: surroundings, lamps, cameras, kinds of table and light, without any mesh."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pydantic import Field

from ...core.errors import InputError
from ...core.json_file import check_schema, parsed, read_json
from ...core.model import Model
from ...procedural.description.camera import Camera
from ...procedural.description.picture import Picture
from ...procedural.description.scene import SCENE_SCHEMA
from ...procedural.description.surroundings import AreaLight, Environment
from . import layout


class SceneOutline(Model):
    """What of a scene can be read in a millisecond: loading it takes a hundred times as long, for its meshes."""

    environment: Environment
    lights: tuple[AreaLight, ...]
    cameras: tuple[Camera, ...] = Field(min_length=1)
    table: str = Field(description="Kind of the table, such as 'wood'")
    prints: tuple[str, ...] = Field(description="Kinds of the flat prints on the table, such as 'sheet'")
    redrawn: int = Field(ge=0, description="How often contents of its vessels did not fit, and were drawn again")
    placed_again: int = Field(ge=0, description="How often its objects did not fit on the table, and were placed again")
    depth_camera: str | None = Field(description="Name of the depth camera")
    polarisation_camera: str | None = Field(description="Name of the polarisation camera")
    sensitivities: str | None = Field(description="Name of the sensor whose raw responses the pictures are made of")
    picture: Picture = Field(description="How its pictures are computed")

    @property
    def simplified(self) -> tuple[str, ...]:
        """What is simplified in the light of its pictures, such as ``picture.refractivity 0.5 (true: 1)``."""
        choices = self.picture.simplified.items()
        return tuple(f"picture.{name} {found} (true: {true})" for name, (true, found) in choices)


def picture_notes(outlines: Iterable[SceneOutline]) -> tuple[str, ...]:
    """Return what is unusual about the light and the sensors of some scenes' pictures, in words."""
    notes: dict[str, None] = {}
    for outline in outlines:
        if outline.simplified:
            notes[f"simplified light: {', '.join(outline.simplified)}"] = None
        if outline.sensitivities is not None:
            notes[f"sensor {outline.sensitivities}"] = None
    return tuple(notes)


def read_outline(folder: Path) -> SceneOutline:
    """Read it from a scene's folder; InputError where ``scene.json`` is missing, damaged or of an unknown schema."""
    path = folder / layout.SCENE
    data = read_json(path)
    check_schema(path, data, SCENE_SCHEMA)
    table, vessels = _part(path, data, "table", dict), _part(path, data, "vessels", list)
    parts = {
        **{name: _part(path, data, name, object) for name in ("environment", "lights", "cameras")},
        "table": table.get("kind", "plain"),
        "prints": [_part(path, item, "kind", str) for item in _part(path, {"prints": [], **table}, "prints", list)],
        "redrawn": sum(_redrawn(path, vessel) for vessel in vessels),
        "placed_again": data.get("placed_again", 0),
        **{name: _device(path, data, name) for name in ("depth_camera", "polarisation_camera", "sensitivities")},
        "picture": _part(path, {"picture": {}, **data}, "picture", dict),
    }
    return parsed(SceneOutline, parts, path)


def _device(path: Path, data: dict[str, Any], name: str) -> str | None:
    return None if data.get(name) is None else _part(f"{path}: {name}", _part(path, data, name, dict), "name", str)


def _redrawn(path: Path, vessel: object) -> int:
    count = vessel.get("redrawn", 0) if isinstance(vessel, dict) else None
    if not isinstance(count, int):
        raise InputError(f"{path}: vessels", "objects with a whole number `redrawn`, or none", repr(vessel)[:80])
    return count


def _part(path: Path | str, data: dict[str, Any], name: str, kind: type) -> Any:
    if not isinstance(data.get(name), kind) or name not in data:
        raise InputError(f"{path}: {name}", "a part of a scene", type(data.get(name)).__name__)
    return data[name]
