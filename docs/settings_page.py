"""Write ``docs/settings.md`` from the settings' own types: run it after a setting has changed."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from glassware.dataset.commands.build_request import BuildDataset
from glassware.dataset.commands.scene_request import RenderScene
from glassware.dataset.settings.config import preset, preset_names
from glassware.learn.training.settings import TrainSettings
from glassware.procedural.scene.settings import SceneSettings

PAGE = Path(__file__).with_name("settings.md")

_HEAD = """# Settings

Made by `docs/settings_page.py` from the types that check the settings. Do not edit it by hand.

Each setting is given by its dotted name. In a YAML file the dots are nesting: `cameras: {views: 3}`. On the command
line underscores become hyphens: `--environment.hdri-dir`. A pair is two words there and a list in YAML:
`--vessel-count 1 3`, `vessel_count: [1, 3]`. A switch is `--picture.denoise` or `--picture.no-denoise`.
The [guide](guide.md#settings) has examples. Defaults are rounded to six digits here.

Lengths are metres and angles radians. Either may be given with a unit, in files, on the command line and from Python:
`0.4m`, `12cm`, `55mm`, `30deg`, `0.5rad`.
"""
_REQUEST = """
## The request

These are options of `render-scene` and no part of the data set's settings.
"""
_BUILD = """
## The request of a build

These are options of `build-dataset`; [builds](building.md) has how to use them.
"""
_SCENE = """
## What is drawn and how

The short names `--views`, `--width`, `--height`, `--spp`, `--noise` and `--hdri-dir` stand for `cameras.views`,
`cameras.width`, `cameras.height`, `picture.spp`, `picture.noise` and `environment.hdri_dir`.
"""
_PRESETS = """
## Presets

What a preset changes; all else is the default. `render-scene` starts from `{default}` where none is named.
"""
_TRAINING = """
## Training

Settings of `glassware train`; [networks](networks.md) has how to use them.
"""
_COLUMNS = ("setting", "default", "range", "unit", "meaning")
_UNIT = re.compile(r"\s*\[([^\]]*)\]")


def page() -> str:
    """Return the whole page."""
    request = dict(_fields(RenderScene))
    scene = dict(_leaves(SceneSettings.model_json_schema()))
    request_rows = [_row(name, field) for name, field in request.items()]
    scene_rows = [_row(name, field) for name, field in scene.items()]
    presets = _PRESETS.format(default=RenderScene.model_fields["preset"].default)
    build_rows = [_row(name, field) for name, field in _fields(BuildDataset)]
    lines = [_HEAD, _REQUEST.lstrip("\n"), *_table(_COLUMNS, request_rows), _BUILD, *_table(_COLUMNS, build_rows)]
    training_rows = [_row(name, field) for name, field in _leaves(TrainSettings.model_json_schema())]
    lines += [_SCENE, *_table(_COLUMNS, scene_rows), presets, *_preset_table()]
    lines += [_TRAINING, *_table(_COLUMNS, training_rows), ""]
    return "\n".join(lines)


def _fields(model: Any) -> Iterator[tuple[str, dict]]:
    """Yield a model's own fields as JSON schema, without those that hold further settings."""
    schema = model.model_json_schema()
    for name, field in schema["properties"].items():
        if "$ref" not in field:
            yield name, field


def _leaves(schema: dict, definitions: dict | None = None, prefix: str = "") -> Iterator[tuple[str, dict]]:
    """Go through all settings, their dotted names first."""
    definitions = schema.get("$defs", {}) if definitions is None else definitions
    for name, field in schema["properties"].items():
        if "$ref" in field:
            inner = definitions[field["$ref"].rpartition("/")[2]]
            yield from _leaves(inner, definitions, f"{prefix}{name}.")
        else:
            yield prefix + name, field


def _row(name: str, field: dict) -> tuple[str, ...]:
    # What may be left out has its own type beside that of nothing.
    field = {**next((kind for kind in field.get("anyOf", []) if kind.get("type") != "null"), {}), **field}
    meaning = field["description"]
    unit = _UNIT.search(meaning)
    return (
        f"`{name}`",
        _shown(field.get("default")),
        _range(field),
        unit.group(1) if unit else "",
        _UNIT.sub("", meaning).replace("|", "\\|"),
    )


def _shown(value: object) -> str:
    if value is None or value == [] or value == "":
        return "none"
    if isinstance(value, list):
        return ", ".join(_shown(item) for item in value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _range(field: dict) -> str:
    """Return the limits in words; of a list, those of its entries; what a field says of itself comes first."""
    if "range" in field:
        return field["range"]
    if "prefixItems" in field:
        items = field["prefixItems"]
        if "prefixItems" in items[0]:
            return f"{len(items)} rows of {len(items[0]['prefixItems'])} numbers"
        count = "a pair" if len(items) == 2 else f"{len(items)} numbers"
        return f"{count}, each " + " or ".join(sorted({_range(item) for item in items}))
    if "items" in field:
        return f"one or more of {_range(field['items'])}"
    if "enum" in field:
        return ", ".join(map(str, field["enum"]))
    if field.get("type") == "boolean":
        return "yes, no"
    if "minimum" in field and "maximum" in field:
        return f"{_shown(field['minimum'])} to {_shown(field['maximum'])}"
    signs = {"minimum": ">=", "exclusiveMinimum": ">", "maximum": "<=", "exclusiveMaximum": "<"}
    return ", ".join(f"{sign} {_shown(field[key])}" for key, sign in signs.items() if key in field) or _kind(field)


def _kind(field: dict) -> str:
    kinds = [field, *field.get("anyOf", [])]
    if any(kind.get("type") == "number" for kind in kinds):
        return "a number"
    return "a path" if any(kind.get("format") == "path" for kind in kinds) else "text"


def _preset_table() -> list[str]:
    found = {name: dict(_flat(preset(name))) for name in preset_names()}
    settings = sorted({setting for values in found.values() for setting in values})
    rows = [(f"`{setting}`", *(_shown(found[name].get(setting)) for name in found)) for setting in settings]
    return _table(("setting", *found), rows)


def _flat(settings: dict, prefix: str = "") -> Iterator[tuple[str, object]]:
    for name, value in settings.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _table(columns: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    lines = [columns, ("---",) * len(columns), *rows]
    return [f"| {' | '.join(line)} |" for line in lines]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
