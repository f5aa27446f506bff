"""Choice of tendons by name, by several names or by pattern."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from typing import NamedTuple

import mujoco

from tendon_mj.attach.names import free_name
from tendon_mj.errors import InvalidValueError, UnknownNameError


class Chosen(NamedTuple):
    """A tendon that was asked for.

    Attributes:
        element: of the spec.
        name: of the tendon; the one that it is to be given where it has none.
        by_name: whether its name was given, and not a pattern.
    """

    element: mujoco.MjsTendon
    name: str
    by_name: bool


def check_spec(spec: object) -> None:
    """Refuse what is no `MjSpec`, such as the path or the compiled model that it is made from.

    Raises:
        InvalidValueError: says what it is.
    """
    if not isinstance(spec, mujoco.MjSpec):
        raise InvalidValueError(
            f"spec must be a mujoco.MjSpec, not {type(spec).__name__}: read the MJCF with"
            " mujoco.MjSpec.from_file, and compile it afterwards"
        )


def asks_for_several(spec: mujoco.MjSpec, tendon: str | Sequence[str]) -> bool:
    """Whether this is a list of names or a pattern, and not the name of a tendon."""
    return not isinstance(tendon, str) or (is_pattern(tendon) and spec.tendon(tendon) is None)


def is_pattern(tendon: str) -> bool:
    """Whether a string has characters that stand for others: ``*``, ``?`` or ``[…]``."""
    return any(character in tendon for character in "*?[")


def choose_tendons(spec: mujoco.MjSpec, tendon: str | Sequence[str]) -> list[Chosen]:
    """Tendons that a name, several names or patterns mean, in the model's order.

    A name that a tendon has is that tendon's, even with characters of a pattern. A pattern that
    matches any name, such as ``*``, also means those without a name, which are to be called
    ``tendon_<k>``, k being the tendon's place in the model.

    Raises:
        UnknownNameError: a name that no tendon has.
        InvalidValueError: a pattern that matches none, or no name at all.
    """
    is_one = isinstance(tendon, str) or not isinstance(tendon, Iterable)
    wanted = [tendon] if is_one else list(tendon)
    if not wanted:
        raise InvalidValueError("no tendon is named: give a name, several, or a pattern")
    elements = list(spec.tendons)
    known = {element.name: k for k, element in enumerate(elements) if element.name}
    chosen: dict[int, bool] = {}  # place in the model → by its name
    for one in wanted:
        if not isinstance(one, str):
            raise InvalidValueError(f"{one!r} is not the name of a tendon")
        if one in known:
            chosen[known[one]] = True
            continue
        found = [k for k, e in enumerate(elements) if is_pattern(one) and fnmatchcase(e.name, one)]
        if not found and not is_pattern(one):
            raise UnknownNameError("tendon", one, known)
        if not found:
            there = ", ".join(map(repr, known)) or "none with a name"
            raise InvalidValueError(
                f"pattern {one!r} means no tendon of the model (its tendons: {there})"
            )
        for k in found:
            chosen.setdefault(k, False)
    taken = set(known)
    names = {}
    for k in sorted(chosen):
        names[k] = elements[k].name or free_name(taken, f"tendon_{k}")
        taken.add(names[k])
    return [Chosen(elements[k], names[k], chosen[k]) for k in names]
