"""Options whose values have units, such as ``--cameras.distance 40cm 0.8m``, as plain numbers for the parser."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pydantic import BaseModel

from ...core.errors import InputError
from ...core.units import Dimension, dimension_of, quantity


def without_units(prog: str, model: type[BaseModel], arguments: Sequence[str], flat: object) -> list[str]:
    """Return a command line on which lengths are plain numbers in metres, and angles in radians.

    Parameters
    ----------
    prog : str
        The command, for the error line.
    model : type
        The request.
    arguments : sequence of str
        The command line, options by their full names.
    flat : object
        Annotates the fields of the request whose name is left out in options.

    Raises
    ------
    InputError
        Where a value has an unknown unit, or one of something else.
    """
    dimensions = dict(_dimensions(model, flat))
    option, result = "", []
    for argument in arguments:
        name, equals, value = argument.partition("=")
        if argument.startswith("--"):
            option = name.removeprefix("--").replace("_", "-")
            if equals and option in dimensions:
                argument = f"{name}={_number(prog, option, value, dimensions[option])}"
        elif option in dimensions:
            argument = _number(prog, option, argument, dimensions[option])
        result.append(argument)
    return result


def _number(prog: str, option: str, text: str, dimension: Dimension) -> str:
    try:
        value = quantity(text, dimension)
    except ValueError as error:
        expected, _, found = str(error).removeprefix("expected ").rpartition(", found ")
        raise InputError(f"{prog}: {option.replace('-', '_')}", expected, found) from error
    return text if value is text else repr(value)


def _dimensions(model: type[BaseModel], flat: object, prefix: str = "") -> Iterator[tuple[str, Dimension]]:
    """Yield the options that are lengths or angles, without the leading hyphens."""
    for name, field in model.model_fields.items():
        kind, option = field.annotation, prefix + name.replace("_", "-")
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            yield from _dimensions(kind, flat, prefix if flat in field.metadata else f"{option}.")
        elif (dimension := dimension_of(field)) is not None:
            yield option, dimension
