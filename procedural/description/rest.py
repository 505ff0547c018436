"""How the objects of a scene came to rest, where a simulation put them into their places."""

from __future__ import annotations

from pydantic import Field

from ...core.model import Model


class Rest(Model):
    """The record of a pile."""

    attempt: int = Field(ge=1, description="Number of the pile that came to rest; earlier ones were drawn again")
    given_up: bool = Field(
        default=False,
        exclude_if=lambda given_up: not given_up,
        description="Whether no pile came to rest in as many attempts, so that all objects stand apart",
    )
    fell_again: int = Field(
        ge=0, description="Falls that were drawn again, as the object left the table or did not come to rest"
    )
    seconds: float = Field(ge=0.0, description="Simulated time [s]")
    moved: float = Field(ge=0.0, description="The most that any point moved in the last second [m]")
    contacts: tuple[tuple[int, int], ...] = Field(
        description="Pairs of objects that touch, by instance id, the smaller first; 1 is the table. Parts of a "
        "vessel touch as the vessel"
    )


def no_rest(attempts: int) -> Rest:
    """Return the record of objects that stand apart, as no pile came to rest."""
    return Rest(attempt=attempts, given_up=True, fell_again=0, seconds=0.0, moved=0.0, contacts=())


def touched(rest: Rest, id: int) -> tuple[int, ...]:
    """Return the ids of what an object touches, sorted; 1 is the table."""
    return tuple(sorted({one for pair in rest.contacts if id in pair for one in pair if one != id}))
