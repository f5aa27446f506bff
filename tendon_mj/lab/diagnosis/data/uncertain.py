"""What the recordings call uncertain, as terms of a fit."""

from __future__ import annotations

from tendon_mj.lab.diagnosis.data.problem import Problem
from tendon_mj.lab.diagnosis.effects.effect import Term
from tendon_mj.lab.replay import claims

_PROBE = 0.05  # of the range


def uncertain_terms(problem: Problem) -> tuple[Term, ...]:
    """Terms of the uncertain parameters; those that one name stands for share it, or have each one.

    A parameter that is named by itself, in any table, is no part of a name with wildcards.

    Raises:
        InvalidValueError: two names or tables speak of one parameter alike.
        UnknownNameError: wildcards that no parameter fits.
    """
    parameters, terms = problem.simulate.parameters, list[Term]()
    first = problem.recordings[0]
    longest = max(float(recording.time[-1] - recording.time[0]) for recording in problem.recordings)
    claimed = claims(first, parameters)
    for name, u in first.uncertain.items():
        if u.high > u.low:
            targets = sorted(t for t, by in claimed.items() if by == ("uncertain", name))
            width = u.high - u.low
            if any(parameters[target].unit == "s" for target in targets):
                width = min(width, longest)  # a time beyond it does what one as long as it does
            probe = _PROBE * width
            if 0.0 < abs(u.value) < probe:  # a range of decades
                probe = 2.0 * _PROBE * abs(u.value)
            terms += [
                Term(alike, parameters[alike[0]].unit, u.value, u.low, u.high, probe)
                for alike in ([(t,) for t in targets] if u.each else [tuple(targets)])
                if alike
            ]
    return tuple(terms)
