"""What may change in a rig: the parameters of its model, and the effects that it may come to have.

Each is a number x with an effect on the residual r, which is J = ∂r/∂x to first order at the
calibrated model, for each recording by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

from tendon_mj.lab.diagnosis import Candidate, Term
from tendon_mj.lab.fleet.number import Number
from tendon_mj.lab.replay import name_in_session


@dataclass(frozen=True)
class Watched:
    """A number that may change from one day to the next.

    Attributes:
        number: its names.
        term: the number, with the parameters that it writes.
        shape: further terms of an effect, which are the same on all days.
        value: at which the derivative is taken [the term's unit].
    """

    number: Number
    term: Term
    shape: tuple[Term, ...]
    value: float

    @property
    def probe(self) -> float:
        """A small change, on the side that the range allows [the term's unit]."""
        step = min(self.term.probe, self.term.high - self.term.low)
        return step if self.term.high - self.value >= step else -step

    def moved(self, change: float) -> tuple[tuple[Term, ...], tuple[float, ...]]:
        """The terms and their values with the number changed."""
        return (self.term, *self.shape), (self.value + change, *self.number.shape)


def watched_numbers(
    calibrated: Sequence[Term], values: Sequence[float], candidates: Sequence[Candidate]
) -> tuple[Watched, ...]:
    """The numbers of a calibrated model that may change.

    Args:
        calibrated: terms that hold in all recordings; values: of these.
        candidates: effects on the model, one number for each of their starts.
    """
    found = [
        Watched(_number(term, ""), term, (), float(value))
        for term, value in zip(calibrated, values, strict=True)
    ]
    for candidate in candidates:
        strength, *shape = candidate.terms
        for starts in product(*(t.starts or (t.inert,) for t in shape)):
            number = _number(strength, candidate.identifier, starts)
            found.append(Watched(number, strength, tuple(shape), strength.inert))
    return tuple(found)


def _number(term: Term, identifier: str, shape: tuple[float, ...] = ()) -> Number:
    return Number(", ".join(term.targets), identifier, term.unit, term.probe, shape)


def per_recording(watched: Watched, names: Sequence[str]) -> tuple[Term, ...]:
    """A term for each recording, which writes the number there alone."""
    term = watched.term
    return tuple(
        replace(term, targets=tuple(name_in_session(t, name) for t in term.targets), spread=0.0)
        for name in names
    )
