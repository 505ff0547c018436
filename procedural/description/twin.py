"""Whose counterfactual twin a scene is: the same scene but for one thing."""

from __future__ import annotations

from typing import Literal, get_args

from pydantic import Field

from ...core.model import Model

#: What differs in a twin (`procedural.scene.twins`).
TwinKind = Literal["opaque", "empty", "clean-plate", "light", "media"]
TWIN_KINDS: tuple[TwinKind, ...] = get_args(TwinKind)


class Twin(Model):
    """The record of a twin."""

    kind: TwinKind = Field(
        description="What differs: all glass is painted, vessels are empty, vessels are gone, there is other light, or "
        "vessels are of other glass with other liquids"
    )
    of: str = Field(pattern="^[0-9a-f]{64}$", description="SHA-256 of the scene that it is a twin of (`scene_digest`)")
    unchanged: tuple[str, ...] = Field(
        default=(),
        exclude_if=lambda names: not names,
        description="Vessels whose liquid stayed, as no other one that was drawn fits in",
    )
