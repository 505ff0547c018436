"""The options of a command, from the type of its request: names, forms of their values, defaults, descriptions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import tyro
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from ...core.units import Dimension, degrees, dimension_of

#: Annotates a field of settings whose name is left out, in options (``--cameras.views``) as in YAML files.
FLAT = tyro.conf.arg(name="")

#: Short options, and the ones that they stand for.
SHORT = {
    "--views": "--cameras.views",
    "--width": "--cameras.width",
    "--height": "--cameras.height",
    "--spp": "--picture.spp",
    "--noise": "--picture.noise",
    "--hdri-dir": "--environment.hdri-dir",
    "--network": "--network.name",
    "--encoder": "--network.context",
}
#: Options whose values may be separated by commas.
LISTS = ("--write",)
#: What stands for a value of a type in help texts.
_FORMS = {int: "INT", float: "FLOAT", str: "TEXT", Path: "PATH"}


class Words:
    """Annotates a field of texts with the words that it takes, for help and completion."""

    def __init__(self, *words: str) -> None:
        self.words = words


@dataclass(frozen=True)
class Option:
    """One option of a command, or one argument without a name."""

    name: str  #: with the leading hyphens; of an argument without a name, in capitals
    form: str  #: of its value, such as ``INT INT``; "" for a switch
    default: str  #: in words; "" where there is none
    description: str
    choices: tuple[str, ...]  #: the values that it may have, where they are few
    switch: bool

    @property
    def positional(self) -> bool:
        """Whether it is an argument without a name."""
        return not self.name.startswith("-")


@dataclass(frozen=True)
class Section:
    """Options that belong together."""

    title: str  #: "" for the request's own
    options: tuple[Option, ...]


def flat_groups(model: type[BaseModel]) -> dict[str, type[BaseModel]]:
    """Return the models of the fields that are annotated as `FLAT`, by field."""
    return {
        name: field.annotation
        for name, field in model.model_fields.items()
        if FLAT in field.metadata and isinstance(field.annotation, type)
    }


def sections(model: type[BaseModel], default: BaseModel | None = None) -> list[Section]:
    """Return all options of a request: its own first, then one section for each group of settings.

    Parameters
    ----------
    model : type
        The request.
    default : BaseModel, optional
        A request with the default values; by default those of the type.
    """
    own, groups = _collected(model, default, "")
    return [Section("", tuple(own)), *groups]


def option_names(model: type[BaseModel]) -> list[str]:
    """Return the names of all options of a request, without short ones."""
    return [option.name for section in sections(model) for option in section.options if not option.positional]


def _collected(model: type[BaseModel], default: BaseModel | None, prefix: str) -> tuple[list[Option], list[Section]]:
    own: list[Option] = []
    inlined: list[Option] = []  # of settings whose group has no name: behind the request's own
    groups: list[Section] = []
    flat = flat_groups(model)
    for name, field in model.model_fields.items():
        kind, value = field.annotation, _default(field, default, name)
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            inner = prefix if name in flat else f"{prefix}{name}."
            inside, below = _collected(kind, value if isinstance(value, BaseModel) else None, inner)
            if name in flat:
                inlined += inside
            elif inside:
                groups.append(Section(inner.rstrip("."), tuple(inside)))
            groups += below
        else:
            own.append(_option(prefix + name, field, value))
    return own + inlined, groups


def _default(field: FieldInfo, default: BaseModel | None, name: str) -> object:
    return getattr(default, name) if default is not None else field.get_default(call_default_factory=True)


def _option(name: str, field: FieldInfo, value: object) -> Option:
    positional, dimension = tyro.conf.Positional in field.metadata, dimension_of(field)
    words = next((item.words for item in field.metadata if isinstance(item, Words)), ())
    form = "{" + ",".join(words) + "}" if words else form_of(field.annotation)
    return Option(
        name=name.upper() if positional else "--" + name.replace("_", "-"),
        form=form.replace(_FORMS[float], dimension.upper()) if dimension else form,
        default="" if positional or field.is_required() else default_text(value, dimension),
        description=field.description or "",
        choices=words or _choices(field.annotation),
        switch=field.annotation is bool,
    )


def form_of(kind: Any) -> str:
    """Return what stands for the values of a type in help texts, such as ``INT INT``, ``PATH`` or ``{a,b}``."""
    origin, arguments = get_origin(kind), get_args(kind)
    if kind is bool:
        return ""
    if origin is Annotated:
        return form_of(arguments[0])
    if origin in (Union, UnionType):
        forms = [form_of(part) for part in arguments if part is not type(None)]
        return "|".join(dict.fromkeys(forms))
    if origin is Literal:
        return "{" + ",".join(map(str, arguments)) + "}"
    if origin in (tuple, list):
        several = origin is list or arguments[-1] is Ellipsis
        return f"{form_of(arguments[0])} ..." if several else " ".join(map(form_of, arguments))
    return next((form for base, form in _FORMS.items() if isinstance(kind, type) and issubclass(kind, base)), "VALUE")


def default_text(value: object, dimension: Dimension | None = None) -> str:
    """Return a default value as one would type it, "" for none: of an angle in degrees, such as ``30deg``."""
    if value is None or value == () or value == "":
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    values = value if isinstance(value, tuple | list) else (value,)
    if dimension == "angle":
        return " ".join(degrees(one) if isinstance(one, int | float) else str(one) for one in values)
    text = " ".join(map(_plain, values))
    return f"{text} m" if dimension == "length" else text


def _plain(value: object) -> str:
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    return f"'{text}'" if " " in text else text


def _choices(kind: Any) -> tuple[str, ...]:
    if get_origin(kind) is Literal:
        return tuple(map(str, get_args(kind)))
    return tuple(dict.fromkeys(choice for part in get_args(kind) for choice in _choices(part)))


def switch_names(option: Option) -> Iterator[str]:
    """Yield the two names of a switch, such as ``--picture.denoise`` and ``--picture.no-denoise``."""
    group, dot, last = option.name.removeprefix("--").rpartition(".")
    yield option.name
    yield f"--{group}{dot}no-{last}"
