"""Each threshold holds at its edge: what lies just beyond it counts, what lies within does not."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import SimpleNamespace as Made
from typing import Any

import numpy as np
import pytest

from tendon_mj.lab.data_check import DataWarning
from tendon_mj.lab.diagnosis import (
    ErrorReduction,
    Fit,
    Term,
    Value,
    diagnose,
    fit,
    search_step,
    session_terms,
)
from tendon_mj.lab.diagnosis.alternatives import _alternative
from tendon_mj.lab.diagnosis.audit import Correlations, autocorrelation
from tendon_mj.lab.diagnosis.check import check_recordings
from tendon_mj.lab.diagnosis.data import _reader, with_step
from tendon_mj.lab.diagnosis.events import _Scan
from tendon_mj.lab.diagnosis.limits import least_share
from tendon_mj.lab.diagnosis.regimes import _cut, _reversals, locate, regimes
from tendon_mj.lab.diagnosis.reproducibility import _repeat
from tendon_mj.lab.diagnosis.search import screen
from tendon_mj.lab.diagnosis.selection import SelectionContext
from tendon_mj.lab.diagnosis.statistics import cross_validate
from tendon_mj.lab.diagnosis.verdict import Evidence
from tendon_mj.lab.diagnosis.wording import state
from tendon_mj.lab.diagnosis.workflow import _is_too_long, _step_matters
from tendon_mj.lab.progress import silent
from tendon_mj.lab.recordings import Recording, Session
from tests.lab.diagnosis.linear_rig import context, effect
from tests.lab.diagnosis.test_statistics import linear
from tests.lab.diagnosis.toy import Stepped, Toy, problem_of, recording, rig, ringing
from tests.refusals import refused

MADE = recording("a", 1, {})
DRIVE = "input_displacement_m"
ONE = problem_of(Toy, [MADE])
ROWS = np.arange(600)
WAVE, NOISE = np.sin(0.01 * ROWS), np.random.default_rng(1).normal(size=600)


def driven(column: np.ndarray, **more: Any):
    """The recording with another driven column."""
    return replace(MADE, columns={**MADE.columns, DRIVE: column}, **more)


def differs(rms: float = 0.0, later: float = 0.0) -> bool:
    """Return whether a drive is another one, by a share of its range, or of the time."""
    drive = MADE.columns[DRIVE]
    other = driven(drive + rms * np.ptp(drive) * (-1.0) ** ROWS, time=MADE.time * (1.0 + later))
    return not _repeat(MADE, other)


def sentence(before: float, after: float, **more: Any) -> str:
    errors = ErrorReduction(before, after, 1.0, {})
    judged = {"held_out": errors, "weighed": errors, "extrapolated": errors, "limit": 0.2, **more}
    return state("nothing missing", (), Evidence(**judged))


def moves(speed: float) -> bool:
    """Return whether a share of the highest speed is a motion."""
    drive = np.cumsum(np.repeat([1.0, speed, -1.0], 200))
    return bool((regimes([driven(drive)])[0][0].bins[250:350] == 2).all())


def stands_out(share: float) -> bool:
    """Return whether a share of the excess in one of two columns is reported."""
    residual = np.sqrt(1.0 + 9.0 * np.repeat([share, 1.0 - share], ROWS.size))
    return "those of" in locate(ONE, residual, ONE.in_train).sentence


def traced(trace: float, probes: float = 1.0) -> bool:
    """Return whether an effect with this mean square trace, so many probes away, is seen."""
    made = context({"a": {"a": trace**0.5}}, {"a": 1.0}, [])
    candidate = replace(effect("a"), terms=(Term(("a",), "-", 0.0, -1.0, 1.0, 1.0 / probes),))
    fit = made.fit_model((), ()).fit
    return bool(screen(made.problem, {}, fit, [candidate], lambda *_: None, {}, ()))


def of_a_column(size: float = 1.0, rows: int = 0) -> bool:
    """Return whether a drive that jumps by a share of an event, rows away, is the event."""
    event = Made(recording=0, candidate=Made(targets=("a.slip",)), time=2.995, size=-1.0)
    jump = size * (300 + rows <= ROWS)
    return _Scan._is_of_column(Made(problem=ONE, _driven=lambda *_: jump), event)  # type: ignore[arg-type]


def another(share: float) -> bool:
    """Return whether a value is another one by a share of it, and not an end of its interval."""
    here, there = (Value(v, 0.0, 2.0, "-", 0.0) for v in (1.0, 1.0 + share))
    return _alternative(effect("a"), "", {"a": (here, there)}).fitted


FORCE = Term(("sheath.constant_friction",), "N", 0.0, -50.0, 50.0, 1.0)


def is_too_long(rig: type[Stepped], **changed: float) -> bool:
    """Return whether the step of a rig is too long, of which a fit has ``changed`` residuals."""
    data = with_step(problem_of(lambda r: rig(r, error=0.0), [MADE]), 1.0)
    made = SelectionContext(data, {}, (FORCE,), (), 0.0, 0.0, silent)
    fitted = fit(data, {}, (FORCE,), (), np.zeros(1))
    series = {name: np.full(fitted.residual.size, value) for name, value in changed.items()}
    return _is_too_long(1.0, made, replace(fitted, **series), data)


def changes(share: float) -> bool:
    """Return whether a step is too long of which half changes a share of the mean square."""
    return is_too_long(Stepped, residual=10.0, correction=20.0 * share**0.5)


class Ringing(Stepped):
    """A toy that rings in its own step, and a share as much in half of it."""

    size, less = 0.05, 0.0  # [N]

    def _one(self, changed: Mapping[str, float], recording: Recording) -> dict[str, np.ndarray]:
        size = self.size * (1.0 if self.step == 1.0 else self.less)
        return ringing(super()._one(changed, recording), changed, size)


def mends(less: float, size: float = 0.05) -> bool:
    """Return whether a step in which a model rings is too long if half of it has so much less."""
    return is_too_long(type("Rig", (Ringing,), {"size": size, "less": 1.0 - less}))


def far(excess: float) -> bool:
    """Return whether an excess is too large for a shorter step to matter, at a limit of 1."""
    fit = Made(correction=np.zeros(9))
    made = Made(detection_limit=1.0, problem=Made(in_train=np.ones(9, bool)))
    chosen = Made(effects=[None], final=Made(excess=excess, fit=fit))
    return not _step_matters(made, chosen, "unknown")  # type: ignore[arg-type]


def own_step(error: float) -> bool:
    """Return whether a search takes the model's step, as twice that errs by a mean square."""
    made = [recording("a", 1, {}, noise=0.01)]
    trial = Stepped(made, error=1.0)
    ((one,),), ((two,),) = trial([{}]), trial.in_steps(2.0)([{}])
    rms = np.sqrt(np.mean([((one[c] - two[c]) / 0.01) ** 2 for c in one]))
    return search_step(problem_of(lambda r: Stepped(r, error=error**0.5 / rms), made)) == 1.0


def proportionate(times: float) -> bool:
    """Return whether a noise of so many times the range of its column is taken."""
    column = "input_tension_N"
    noise = times * float(np.ptp(MADE.columns[column]))
    measured = {column: replace(MADE.measured[column], noise=noise)}
    return not refused(lambda: check_recordings([replace(MADE, measured=measured)], []))


def refits(times: float = 9.0, share: float = 0.2, count: int = 1) -> int:
    """Refits of so many parts of which slopes foretell so much more, worth a share of all."""
    parts, matrix = ONE.parts, np.zeros((ONE.parts.size, 4))
    for k in range(4):
        rows, ends = parts == k, (parts == 5) & (np.arange(parts.size) % 4 == k)
        matrix[rows, k] = np.sqrt((times**0.5 - 1.0) * ends.sum() / rows.sum())
        matrix[ends, k] = 1.0
    rest = (times - 1.0) / share - count * times
    residual = (parts < count) + rest**0.5 * (parts == 4)
    terms = tuple(Term((f"p{k}",), "-", 0.0, -50.0, 50.0, 1.0) for k in range(4))
    bounds = np.outer([-50.0, 50.0], np.ones(4))
    zeros, none = np.zeros(4), np.zeros(parts.size)
    fit, calls = Fit(terms, (), zeros, residual, none, matrix, zeros, bounds), list[int]()
    cross_validate(ONE, fit, lambda part: calls.append(part) or fit)
    return len(calls)


def faulty(error: float) -> bool:
    """Return whether an effect that leaves so many noises is taken for a fault of a column."""
    strange = 0.05 * np.sqrt(2.0 * (error**2 - 1.0))  # amplitude of what nothing explains [N]
    train, held_out = rig(1, {"sheath.constant_friction": 3.0}, strange)
    fault = DataWarning("odd", "r0", "odd", "mend it", blocks=True)
    return not diagnose(train, held_out, Toy, checks=[fault]).effects


def is_free(distance: float) -> bool:
    """Return whether a term so many probes from its bound is free."""
    matrix = np.random.default_rng(1).normal(size=(ONE.blocks.size, 2))
    fitted = linear(ONE, matrix, matrix[:, 0])
    return bool(replace(fitted, scaled=np.array([50.0 - distance, 0.0])).free[0])


def samples(count: int) -> bool:
    columns = {c: series[::9][:count] for c, series in MADE.columns.items()}
    few = replace(MADE, time=MADE.time[::9][:count], columns=columns)
    return not refused(lambda: check_recordings([few], [MADE]))


# what → whether it counts, and sizes within and beyond its threshold
EDGES: dict[str, tuple[Callable[[float], object], float, float]] = {
    "correlation": (lambda r: Correlations(("a", "b"), ((1.0, r), (r, 1.0))).high, 0.85, 0.95),
    "lags": (lambda n: autocorrelation(ROWS, np.sin(ROWS)).lags.size < n, 40, 41),
    "a worthwhile share": (lambda share: share >= least_share(ONE), 0.04, 0.06),
    "another drive": (differs, 0.007, 0.013),
    "other times": (lambda share: differs(later=share), 0.7e-3, 1.4e-3),
    "a reversal": (lambda share: _reversals(np.array([0.0, 1.0, 1.0 - share, 1.0])), 0.015, 0.025),
    "motion": (moves, 0.015, 0.025),
    "an end of a bin": (
        lambda x: _cut("speed", ROWS, "m", x, 1.0).labels[0][:2] != "0 ",
        7e-5,
        1.3e-4,
    ),
    "bins": (lambda count: len(_cut("speed", ROWS, "m", 0.0, 1.0).labels) < count, 6, 7),
    "what stands out": (stands_out, 0.7, 0.8),
    "a trace": (traced, 0.7e-8, 1.4e-8),
    "a trace of a few probes": (lambda probes: not traced(2e-8, probes), 5e8, 2e9),
    "a part foretold badly": (refits, 3.0, 5.0),
    "a part worth a refit": (lambda share: refits(share=share), 0.07, 0.13),
    "parts": (lambda count: refits(count=count) < count, 3, 4),
    "a fault of a column": (faulty, 1.1, 1.3),
    "off a bound": (is_free, 0.7e-3, 1.4e-3),
    "noise of a drive": (lambda share: not _reader(WAVE + 2.0 * share * NOISE), 0.006, 0.014),
    "another value": (another, 0.15, 0.25),
    "a jump of the drive": (of_a_column, 0.6, 0.8),
    "a jump elsewhere": (lambda rows: not of_a_column(rows=rows), 3, 4),
    "a step that changes much": (changes, 0.07, 0.13),
    "ringing that half of the step mends": (mends, 0.4, 0.6),
    "ringing": (lambda size: mends(1.0, size), 1.5e-3, 4e-3),
    "a rest beyond the step": (far, 1.6, 2.4),
    "a step too long": (own_step, 0.7, 1.4),
    "noise in proportion": (proportionate, 0.7e-12, 1.4e-12),
    "noise out of proportion": (lambda times: not proportionate(times), 0.7e3, 1.4e3),
    "enough samples": (samples, 49, 50),
    "noise that may be right": (lambda error: "too large" not in sentence(error, error), 0.6, 0.8),
    "steps": (lambda error: "shorter" in sentence(error, error, zero_step=1.0), 1.4, 1.6),
}


@pytest.mark.parametrize("what", EDGES)
def test_it_counts_from_a_threshold_on(what: str) -> None:
    counts, within, beyond = EDGES[what]
    assert not counts(within)
    assert counts(beyond)


@pytest.mark.parametrize(("seconds", "blocks"), [(1.5, 4), (4.0, 4), (8.0, 8), (30.0, 12)])
def test_blocks_last_a_second_but_for_the_shortest_and_the_longest(
    seconds: float, blocks: int
) -> None:
    made = replace(MADE, time=MADE.time / MADE.time[-1] * seconds)
    assert np.unique(problem_of(Toy, [made]).blocks).size == blocks


def test_a_value_set_anew_is_sought_within_eight_spreads_and_expected_within_three() -> None:
    made = replace(MADE, session={"output_tension.offset": Session(1.0, 0.3)})
    (term,) = session_terms([made], Made(sessions=True, parameters=ONE.simulate.parameters))  # type: ignore[arg-type]
    numbers = (term.high - term.inert) / 0.3, term.spread / 0.3, term.probe / 0.3
    assert numbers == pytest.approx((8.0, 3.0, 0.5))
