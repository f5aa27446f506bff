"""What was set anew for each recording, as terms of a fit.

A parameter p in [session] has the value p_k in recording k, p_k ~ N(value, spread²). Each p_k is
fitted, with (p_k − value)/(3 spread) as one more residual: the stated spread is a guess, and the
data of a recording determine its value far better. The spread is then estimated from the values.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tendon_mj.errors import InvalidValueError, RecordingError, UnknownNameError
from tendon_mj.lab.diagnosis.effects.effect import Term
from tendon_mj.lab.recordings import Recording, Session
from tendon_mj.lab.replay import (
    Parameter,
    Simulates,
    claims,
    expand,
    name_in_session,
    parameter_of,
    recording_of,
)

_WIDER = 3.0  # prior standard deviation over the stated spread
_RANGE = 8.0  # stated spreads to either side
_PROBE = 0.5  # of the stated spread


@dataclass(frozen=True)
class Spread:
    """What was set anew for each recording, and how much it differed.

    Attributes:
        stated: standard deviation that the recordings state [unit].
        estimated: root mean square deviation of the fitted values from the stated one [unit].
        unit: of both and of the values.
        values: recording → fitted value [unit].
    """

    stated: float
    estimated: float
    unit: str
    values: Mapping[str, float]


def session_terms(recordings: Sequence[Recording], simulate: Simulates) -> tuple[Term, ...]:
    """Terms of every recording's own values.

    Raises:
        RecordingError: two recordings with such values have one name.
        InvalidValueError: the simulator takes no values for single recordings.
        UnknownNameError: no such parameter.
    """
    named = [recording for recording in recordings if recording.session]
    if named and not simulate.sessions:
        raise InvalidValueError(
            f"simulator {type(simulate).__name__!r} takes no values for single recordings, which"
            f" [session] of {named[0].name!r} needs; see `sessions` of tendon_mj.Simulates"
        )
    names = [recording.name for recording in recordings]
    for recording in named:
        if names.count(recording.name) > 1:
            raise RecordingError(
                f"recording {recording.name!r}: two recordings have this name, so that what was set"
                " anew for each, in [session], cannot be told apart; rename one file"
            )
    return tuple(
        Term(
            targets=(name_in_session(parameter, recording.name),),
            unit=simulate.parameters[parameter].unit,
            inert=own.value,
            low=max(own.value - _RANGE * own.spread, simulate.parameters[parameter].low),
            high=own.value + _RANGE * own.spread,
            probe=_PROBE * own.spread,
            spread=_WIDER * own.spread,
        )
        for recording in named
        for parameter, own in _set_anew(recording, simulate.parameters).items()
    )


def _set_anew(recording: Recording, parameters: Mapping[str, Parameter]) -> dict[str, Session]:
    """Parameter → what [session] says of it, but for those that another table names themselves."""
    claimed, told = claims(recording, parameters), expand(recording.session, parameters)
    for parameter in told:
        if parameter not in parameters:
            where = f"recording {recording.name!r}, [session]"
            raise UnknownNameError("parameter", parameter, parameters, where)
    return {parameter: own for parameter, own in told.items() if claimed[parameter][0] == "session"}


def spreads(terms: Sequence[Term], values: Sequence[float] | np.ndarray) -> dict[str, Spread]:
    """Parameter → how much it differed between recordings, from the fitted values of the terms."""
    found: dict[str, list[tuple[Term, float]]] = {}
    for term, value in zip(terms, values, strict=True):
        if term.spread > 0.0:
            found.setdefault(parameter_of(term.targets[0]), []).append((term, float(value)))
    return {
        parameter: Spread(
            stated=rows[0][0].spread / _WIDER,
            estimated=float(np.sqrt(np.mean([(v - term.inert) ** 2 for term, v in rows]))),
            unit=rows[0][0].unit,
            values={recording_of(term.targets[0]): v for term, v in rows},
        )
        for parameter, rows in found.items()
    }
