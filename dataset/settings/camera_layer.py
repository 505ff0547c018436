"""Settings of cameras that follow from others: a camera preset, and the number of poses in a file.

They lie between the preset of the whole scene and what the user gives: ``--preset fast`` has small pictures,
``--cameras.preset d435`` takes precedence over them, and ``--width`` over both.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...core.errors import InputError
from ...procedural.surroundings.camera_presets import PRESET_FIELDS, with_preset
from ...procedural.surroundings.camera_settings import MOST_VIEWS, CameraSettings

_OPTION = "--cameras."
#: Settings of a lens of the user's own.
_LENS = ("K", "fx", "focal")
#: Rows and columns of the settings that are matrices.
_MATRICES = {"K": (3, 3), "world_T_poses": (4, 4)}


def with_cameras(below: dict[str, Any], given: dict[str, Any], arguments: Sequence[str] = ()) -> dict[str, Any]:
    """Return the group of the cameras as a user gives it, on top of others, with what follows in between.

    Parameters
    ----------
    below : dict
        Nested settings under the user's own: a preset.
    given : dict
        The user's settings, of a YAML file or from Python.
    arguments : sequence of str
        The user's command line, options by their full names. Its options of cameras are taken into account, as far as
        they are valid; the parser applies, or refuses, all of them later.

    Returns
    -------
    dict
        ``cameras`` alone; settings that are not valid are in it, for their validation to report.

    Raises
    ------
    InputError
        Where the file of poses cannot be used, or the size of the pictures has not the shape of the preset's.
    """
    cameras, options = given.get("cameras", {}), _camera_options(arguments)
    if not isinstance(cameras, dict):
        return {}
    lens = {name: value for name, value in options.items() if name in _LENS}
    named = {name: value for name, value in options.items() if name in ("preset", *lens)}
    # Options that do not fit together are left for the parser to refuse: the preset's size may show why.
    for user, left_out in ((cameras | options, {}), (cameras | named, named if lens else {}), (cameras, {})):
        resolved = _resolved(below.get("cameras", {}), user)
        try:
            resolved = {name: value for name, value in resolved.items() if name not in left_out}
            checked = CameraSettings.model_validate(resolved)
        except ValueError:  # also a pydantic.ValidationError
            continue
        if checked.poses is not None and user.get("views") is None:
            resolved["views"] = _number_of_poses(checked)
        return {"cameras": resolved}
    # Not valid, whatever the options: with the preset in between, validation reports the user's own fault.
    return {"cameras": _resolved(below.get("cameras", {}), cameras)}


def _resolved(below: dict[str, Any], user: dict[str, Any]) -> dict[str, Any]:
    if user.get("preset") is None and below.get("preset") is None:
        return below | user
    if user.get("preset") is None:
        user = {"preset": below["preset"]} | user
    kept = {name: value for name, value in below.items() if name not in PRESET_FIELDS}
    try:
        return kept | with_preset(user)
    except ValueError as error:
        field, _, text = str(error).partition(": expected ")
        expected, _, found = text.rpartition(", found ")
        raise InputError(f"cameras.{field}", expected, found) from error


def _number_of_poses(settings: CameraSettings) -> int:
    from ...procedural.surroundings.pose_files import read_poses  # SciPy, which --help does without

    assert settings.poses is not None
    count = len(read_poses(settings.poses, settings.world_T_poses))
    if count > MOST_VIEWS:
        raise InputError("cameras.views", f"1 to {MOST_VIEWS} of the {count} poses in {settings.poses}", "nothing")
    return count


def _camera_options(arguments: Sequence[str]) -> dict[str, Any]:
    """Return the options of the cameras as nested settings, with texts as values."""
    found: dict[str, list[str]] = {}
    name = ""
    for argument in arguments:
        if argument.startswith("--"):
            option, equals, value = argument.partition("=")
            name = option.removeprefix(_OPTION).replace("-", "_") if option.startswith(_OPTION) else ""
            if name:
                found[name] = [value] if equals else []
        elif name:
            found[name].append(argument)
    return {name: _value(name, words) for name, words in found.items() if words}


def _value(name: str, words: list[str]) -> Any:
    if name in _MATRICES and len(words) == _MATRICES[name][0] * _MATRICES[name][1]:
        rows, columns = _MATRICES[name]
        return [words[columns * row : columns * (row + 1)] for row in range(rows)]
    return words[0] if len(words) == 1 else words
