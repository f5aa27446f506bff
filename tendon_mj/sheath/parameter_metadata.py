"""Description of a physical parameter: symbol, unit, range and one line of text.

A field of a dataclass carries its description; messages, docstrings, tables and the order in which
compiled code stores the values are derived from the fields.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, Field, fields
from typing import Any, NamedTuple

from tendon_mj.errors import InvalidValueError

_KEY = "parameter"
_LARGEST = 1e30  # in size: products of parameters beyond may not be finite


class Range(NamedTuple):
    """Interval of allowed values, from ``low`` to ``high``.

    Attributes:
        low: lowest value.
        closed: whether ``low`` itself is allowed.
        high: bound that a value has to stay below.
    """

    low: float = 0.0
    closed: bool = True
    high: float = math.inf

    def admits(self, value: float) -> bool:
        """Whether a value is finite and within the range."""
        above = value > self.low or (self.closed and value == self.low)
        return math.isfinite(value) and above and value < self.high

    def bounds(self) -> list[str]:
        """The finite bounds as text."""
        said = []
        if self.low > -math.inf:
            said.append(f"{'≥' if self.closed else '>'} {self.low:g}")
        if self.high < math.inf:
            said.append(f"< {self.high:g}")
        return said

    def __str__(self) -> str:
        return " and ".join(["finite", *self.bounds()])


ANY = Range(-math.inf, False)
POSITIVE = Range(0.0, False)


class Parameter(NamedTuple):
    """Description of a parameter.

    Attributes:
        symbol: in the equations.
        unit: SI; "-" where there is none.
        text: its meaning in one line.
        range: allowed values.
        scale: name of the parameter without which this one has no meaning; empty: none.
        default: value where it is not given; None: required, or taken from elsewhere.
        required: whether it has to be given.
    """

    symbol: str
    unit: str
    text: str
    range: Range
    scale: str = ""
    default: float | None = None
    required: bool = False

    def line(self) -> str:
        """Symbol, text and unit as in a docstring."""
        return f"{self.symbol}, {self.text} [{self.unit}]."


def described(
    symbol: str, unit: str, text: str, allowed: Range | None = None, scale: str = ""
) -> dict[str, Any]:
    """Metadata of a dataclass field that is a parameter; ``allowed`` is ≥ 0 unless given."""
    return {_KEY: Parameter(symbol, unit, text, Range() if allowed is None else allowed, scale)}


def parameters_of(described_class: Any) -> dict[str, Parameter]:
    """Parameters of a dataclass by name, in the order of its fields."""
    return {field.name: _complete(field) for field in fields(described_class)}


def _complete(field: Field[Any]) -> Parameter:
    found: Parameter = field.metadata[_KEY]
    if field.default is MISSING:
        return found._replace(required=True)
    return found._replace(default=field.default)


def attribute_lines(parameters: Mapping[str, Parameter], indent: str) -> str:
    """Lines ``name: symbol, text [unit].`` of a docstring."""
    return "\n".join(f"{indent}{name}: {found.line()}" for name, found in parameters.items())


def in_place(where: str) -> str:
    """Prefix of a message; empty where no place is named."""
    return f"{where}: " if where else ""


def check_in_range(
    parameters: Mapping[str, Parameter], name: str, value: float, where: str = ""
) -> None:
    """Refuse a value outside its range.

    Raises:
        InvalidValueError: names the parameter, the value, its range and unit.
    """
    found = parameters[name]
    if not found.range.admits(value):
        raise InvalidValueError(
            f"{in_place(where)}{name} = {value:g} [{found.unit}] must be {found.range}"
        )
    smallest = 1.0 / _LARGEST if found.range == POSITIVE else 0.0  # what must not be 0 divides
    if not smallest <= abs(value) <= _LARGEST:
        least = -_LARGEST if found.range.low < 0.0 else smallest
        raise InvalidValueError(
            f"{in_place(where)}{name} = {value:g} [{found.unit}] is no size that can be computed"
            f" with, {least:g} to {_LARGEST:g}"
        )
