"""Data of a diagnosis: one vector of residuals in units of noise, and the terms of its calibration.

Searching takes hundreds of simulations, judging a few. The search therefore takes twice the model's
step; `Problem.extrapolate` removes the error of that step, and only extrapolated residuals are
judged.

A parameter p in [session] has the value p_k in recording k, p_k ~ N(value, spread²). Each p_k is
fitted, with (p_k − value)/(3 spread) as one more residual: the stated spread is a guess, and the
data of a recording determine its value far better. The spread is then estimated from the values.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from tendon_mj.errors import InvalidValueError, RecordingError, UnknownNameError
from tendon_mj.lab.diagnosis.effects.effect import SystemDescription, Term, element
from tendon_mj.lab.noise import (
    encoder_step,
    estimate_noise,
    is_noisy,
    least_motion,
    noise_levels,
    range_ends,
    white_noise,
)
from tendon_mj.lab.parameter_names import (
    claims,
    expand,
    name_in_session,
    parameter_of,
    recording_of,
    values_in,
)
from tendon_mj.lab.recordings import Recording, Session
from tendon_mj.lab.replay import (
    DRAWN_BEND,
    EXTRA_BEND,
    Kind,
    Parameter,
    Series,
    Simulates,
    Simulator,
    suppress_mujoco_log,
    suppress_unsolved_warnings,
)
from tendon_mj.typing import FloatArray

MakeSimulator = Callable[[Sequence[Recording]], Simulates]

_BLOCK = 1.0  # typical length of a block [s]; several in each recording, and not too many
_ROWS = 2  # likewise, of rows that are rests
_FEWEST_BLOCKS, _MOST_BLOCKS = 4, 12
_FEWEST_RECORDINGS = 3
_TAIL = 0.25  # of every recording, held out if no other recording is given

_LONGEST = 2.0  # step of the search, times the model's own
_LARGEST_ERROR = 1.0  # of the long step, see `step_error`

_PIECES = 2, 4, 8  # of a guide
_FALLS = 2.0**-1.5  # error of lumping with twice as many guides over that before
SMALLEST_EXCESS = 0.2  # excess χ², 0.45 noise rms: less is not worth a name

_SLIDING = "joint", "kg"  # kind and unit of the armature of a joint that slides

_SHAKEN, _NEIGHBOURS = 8, 5  # simulations with other noise of the drives, and samples in a mean
_MOST_NOISE = 0.01  # of the range of a driven column

_PROBE = 0.05  # of the range of an uncertain parameter
_WIDER = 3.0  # prior standard deviation of a session's value over the stated spread
_SESSION_RANGE = 8.0  # stated spreads to either side
_SESSION_PROBE = 0.5  # of the stated spread


@dataclass(frozen=True, eq=False)
class Problem:
    """Recordings, the simulator of them, and the layout of their residuals.

    A residual is (simulated − measured)/noise, with what noise of the drives makes of the
    simulation in the noise; a simulated reading is cut off where its column
    is. Residuals are stacked by recording, then column, then sample. What more guides would change
    is added to them, as it is near the selected model: it depends weakly on the terms.
    """

    recordings: tuple[Recording, ...]  # measured data
    simulate: Simulates  # parameter sets → a series for every set, recording and measured column
    # for every recording (samples,) mask of the training data; the rest is held out
    train: tuple[NDArray[np.bool_], ...]
    # simulate with half the step, see extrapolate; None if it has no steps
    half_step: Simulates | None = None
    # parameters that every simulation has, below those of its own
    fixed: Mapping[str, float] = field(default_factory=dict)
    # for every recording: measured column → (samples,) `noise_of_drives`
    by_drives: tuple[Mapping[str, FloatArray], ...] = ()
    # (m,) by which more guides change each residual, see `with_more_guides`
    by_guides: FloatArray | float = 0.0
    # column → error of sheaths that are lumped into guides, over its range; likewise
    lumping: Mapping[str, float] = field(default_factory=dict)
    # (m,) change of the residual without that error; None if it was not measured
    lumped: FloatArray | None = None
    unused: frozenset[str] = frozenset()  # measured columns that are simulated and not fitted

    @cached_property
    def noise(self) -> tuple[dict[str, float], ...]:
        """Noise of every measured column of every recording [the column's unit]."""
        return tuple(noise_levels(recording) for recording in self.recordings)

    @cached_property
    def levels(self) -> tuple[dict[str, FloatArray], ...]:
        """(samples,) unit of the residuals of each column: its noise with that of the drives."""
        by_drives = self.by_drives or ({},) * len(self.recordings)
        return tuple(
            {c: np.hypot(level, by.get(c, np.zeros(r.time.size))) for c, level in noise.items()}
            for r, noise, by in zip(self.recordings, self.noise, by_drives, strict=True)
        )

    @cached_property
    def ends(self) -> tuple[dict[str, tuple[float, float]], ...]:
        """Ends of the range that each measured column is cut off at, ±inf if it is not."""
        return tuple(
            {c: range_ends(r.columns[c], m.noise) for c, m in r.measured.items()}
            for r in self.recordings
        )

    @cached_property
    def at_rest(self) -> bool:
        """Whether the rows of any recording are rests."""
        return any(recording.quasi_static for recording in self.recordings)

    @cached_property
    def in_train(self) -> NDArray[np.bool_]:
        """(m,) which residuals are training data."""
        return np.concatenate([self.train[k] & (c not in self.unused) for k, c, _ in self.signals])

    @cached_property
    def signals(self) -> list[tuple[int, str, slice]]:
        """(recording, column, its residuals) in the order of the residuals."""
        signals, first = [], 0
        for k, recording in enumerate(self.recordings):
            for column in recording.measured:
                signals.append((k, column, slice(first, first + recording.time.size)))
                first += recording.time.size
        return signals

    @cached_property
    def blocks(self) -> NDArray[np.int64]:
        """(m,) block of time of each residual, counted over all recordings.

        All columns share the blocks of their recording. Cross-validation leaves out one at a time.
        """
        labels, first = [], 0
        for recording in self.recordings:
            time = _clock(recording)
            block = _ROWS if recording.quasi_static else _BLOCK
            count = int(np.clip(round(time[-1] / block), _FEWEST_BLOCKS, _MOST_BLOCKS))
            own = np.minimum((time / time[-1] * count).astype(np.int64), count - 1) + first
            labels += [own] * len(recording.measured)
            first += count
        return np.concatenate(labels)

    @cached_property
    def recording_of(self) -> NDArray[np.int64]:
        """(m,) recording of each residual."""
        return np.repeat(
            np.arange(len(self.recordings)),
            [r.time.size * len(r.measured) for r in self.recordings],
        )

    @cached_property
    def parts(self) -> NDArray[np.int64]:
        """(m,) part of the data of each residual, which selection leaves out one at a time.

        Recordings if there are enough of different states, else blocks.
        """
        return self.recording_of if by_recording(self.recordings) else self.blocks

    def without(self, part: int) -> Problem:
        """The problem with one of its `parts` left out of the training data."""
        sample = {k: self.parts[rows] for k, _, rows in self.signals}
        train = tuple(mask & (sample[k] != part) for k, mask in enumerate(self.train))
        return replace(self, train=train)

    def residuals(self, parameter_sets: Sequence[Mapping[str, float]]) -> FloatArray:
        """(sets, m) residuals; a simulation that failed has infinite ones."""
        return self._residuals(self.simulate, parameter_sets)

    def extrapolate(self, parameters: Mapping[str, float], residual: FloatArray) -> FloatArray:
        """(m,) residual without the first-order error of the simulation's step.

        A simulation with step h errs by C h to first order, and 2 r_{h/2} − r_h does not
        (Richardson extrapolation). If rows are rests its error has no order, and the finer
        simulation is taken as it is.
        """
        if self.half_step is None:
            return residual
        finer = self._residuals(self.half_step, [parameters])[0]
        with np.errstate(invalid="ignore"):
            extrapolated: FloatArray = finer if self.at_rest else 2.0 * finer - residual
        return np.where(np.isfinite(extrapolated), extrapolated, np.inf)

    def without_tails(self) -> Problem:
        """The problem, of which fits simulate nothing after the training data but rests."""
        if not isinstance(self.simulate, Simulator):
            return self
        samples = [int(np.flatnonzero(mask)[-1]) + 1 for mask in self.train]
        return replace(self, simulate=self.simulate.up_to(samples))

    def _residuals(
        self, simulate: Simulates, parameter_sets: Sequence[Mapping[str, float]]
    ) -> FloatArray:
        names = {recording.name for recording in self.recordings}
        sets = [
            values_in(names, {**self.fixed, **values}, simulate.parameters)
            for values in parameter_sets
        ]
        answered = simulate(sets)
        check_answers(answered, len(sets), self.recordings, simulate)
        rows = []
        for answers in answered:
            parts = [
                (np.clip(answers[k][column], *self.ends[k][column]) - recording.columns[column])
                / level
                for k, recording in enumerate(self.recordings)
                for column, level in self.levels[k].items()
            ]
            row = np.concatenate(parts) + self.by_guides
            rows.append(row if np.isfinite(row).all() else np.full(row.shape, np.inf))
        return np.array(rows)


def make_problem(
    recordings: Sequence[Recording], simulate: Simulates, train: tuple[NDArray[np.bool_], ...]
) -> Problem:
    """The problem of recordings, with the noise of their drives in that of the readings."""
    by_drives = noise_of_drives(recordings, simulate)
    return Problem(tuple(recordings), simulate, train, by_drives=by_drives)


def noise_of_drives(
    recordings: Sequence[Recording], simulate: Simulates
) -> tuple[dict[str, FloatArray], ...]:
    """Measured column → (samples,) standard deviation by which noise of the drives moves it.

    The rig was driven without the noise of the encoder. A model that is driven with it goes back
    and forth at rests and turns, where a stiff cable moves the tension by many times the noise of
    a load cell. Simulations with drives that are read again show where, and by how much. If all
    drives are exact, or with another simulator than the package's, it is empty.
    """
    readers = [
        {c: reader for c in r.drive if (reader := _reader(r.columns[c]))} for r in recordings
    ]
    if not any(readers) or not isinstance(simulate, Simulator):
        return tuple({} for _ in recordings)
    random, again = np.random.default_rng(0), list[Recording]()
    for recording, own in zip(recordings, readers, strict=True):
        for k in range(_SHAKEN):
            read = {column: reader(random) for column, reader in own.items()}
            name, columns = f"{recording.name}, drive {k}", {**recording.columns, **read}
            again.append(replace(recording, name=name, columns=columns))
    with suppress_mujoco_log(), suppress_unsolved_warnings():
        (base,), (answers,) = simulate([{}]), Simulator(again, simulate.model)([{}])
    powers: list[dict[str, FloatArray]] = [{} for _ in recordings]
    for k, found in enumerate(base):
        for column, series in found.items():
            several = np.array([a[column] for a in answers[k * _SHAKEN : (k + 1) * _SHAKEN]])
            power = np.mean((several - series) ** 2, axis=0)
            powers[k][column] = np.sqrt(np.nan_to_num(uniform_filter1d(power, _NEIGHBOURS)))
    return tuple(powers)


def _reader(series: FloatArray) -> Callable[[np.random.Generator], FloatArray] | None:
    """What reads a driven column again: with as much noise, or at other marks of its encoder.

    At a sample before and after which it passes marks it may have been anywhere between two. None
    of a column that is exact, or an excitation that is all noise.
    """
    step = encoder_step(series)
    if step > 0.0:
        motion, passes = least_motion(series), np.abs(np.diff(series)) > 0.5 * step
        fast = np.append(passes, True) & np.append(True, passes)
        error = max(estimate_noise(series), step / math.sqrt(12.0))

        def at_other_marks(random: np.random.Generator) -> FloatArray:
            mark = random.uniform(0.0, step)
            there = least_motion(step * np.rint((motion - mark) / step) + mark)
            return np.where(fast, motion + random.normal(0.0, error, series.size), there)

        return at_other_marks
    noise = white_noise(series) if is_noisy(series) else 0.0
    if 0.0 < noise < _MOST_NOISE * float(np.ptp(series)):
        return lambda random: series + random.normal(0.0, noise, series.size)
    return None


def check_answers(
    answers: Sequence[Sequence[Series]],
    sets: int,
    recordings: Sequence[Recording],
    simulator: Simulates,
) -> None:
    """Refuse answers of a simulator to ``sets`` parameter sets that lack a series or a sample."""
    who = f"simulator {type(simulator).__name__!r}"
    if len(answers) != sets:
        raise InvalidValueError(f"{who} answered {len(answers)} of {sets} sets of parameters")
    for answer in answers:
        if len(answer) != len(recordings):
            raise InvalidValueError(
                f"{who} answered for {len(answer)} of {len(recordings)} recordings"
            )
        for recording, series in zip(recordings, answer, strict=True):
            where = f"{who}, recording {recording.name!r}"
            for column in recording.measured:
                shape = np.shape(series[column]) if column in series else "nothing"
                if shape != recording.time.shape:
                    raise InvalidValueError(
                        f"{where}, column {column!r}: answered {shape}, but the recording has"
                        f" {recording.time.shape} samples of it"
                    )


def by_recording(recordings: Sequence[Recording]) -> bool:
    """Return whether whole recordings are left out: three or more, of different states of the rig.

    Their states differ where [known] differs, or where something was set anew for each. In one
    state, recordings differ in their excitation, and one may be the only one that shows an effect.
    """
    first = recordings[0]
    differ = any(r.known != first.known or r.session for r in recordings)
    return differ and len(recordings) >= _FEWEST_RECORDINGS


def all_samples(recordings: Sequence[Recording]) -> tuple[NDArray[np.bool_], ...]:
    """For every recording (samples,) mask of all of it."""
    return tuple(np.ones(recording.time.size, bool) for recording in recordings)


def training_samples(
    train: Sequence[Recording], held_out: Sequence[Recording]
) -> tuple[NDArray[np.bool_], ...]:
    """For every recording (samples,) training mask, all but the tail if none is held out.

    Recordings of different states lose no tail: whole ones are left out for the proof.
    """
    if held_out or by_recording(train):
        return all_samples(train)
    return tuple(clock <= (1.0 - _TAIL) * clock[-1] for clock in map(_clock, train))


def _clock(recording: Recording) -> FloatArray:
    """(samples,) time from the first sample [s], or the number of the row where rows are rests."""
    if recording.quasi_static:
        return np.arange(recording.time.size, dtype=np.float64)
    since: FloatArray = recording.time - recording.time[0]
    return since


def search_step(problem: Problem) -> float | None:
    """Step of the search in steps of the model, 2 or 1; None for a simulator without steps.

    A longer step may end a move in another of the states in which friction holds. Rests are
    searched with the model's own step, which ``problem`` has.
    """
    own = problem.simulate
    if own.steps == 0:
        return None
    if problem.at_rest or own.in_steps(_LONGEST).steps == own.steps:  # or a sample at every step
        return 1.0
    tried = with_step(problem, _LONGEST)
    coarse = tried.residuals([{}])[0]
    with np.errstate(invalid="ignore"):
        correction = tried.extrapolate({}, coarse) - coarse
    return _LONGEST if step_error(correction) <= _LARGEST_ERROR else 1.0


def with_step(problem: Problem, factor: float | None) -> Problem:
    """The problem with a step ``factor`` times the model's; unchanged for None."""
    if factor is None:
        return problem
    simulate = problem.simulate.in_steps(factor)
    return replace(problem, simulate=simulate, half_step=simulate.in_steps(0.5))


def with_more_guides(problem: Problem, parameters: Mapping[str, float]) -> Problem:
    """The problem with what guides split in 2, 4 or 8 change, until twice as many change little.

    An error in proportion to n^−1.5 is 0.55 times the change of a residual by the last doubling.
    """
    if not isinstance(problem.simulate, Simulator):
        return problem
    own = left = problem.residuals([parameters])[0]
    corrected = problem
    for pieces in _PIECES:
        split = replace(problem, simulate=problem.simulate.split(pieces))
        after = split.residuals([parameters])[0]
        with np.errstate(invalid="ignore"):  # of simulations that failed
            error = (after - left) * _FALLS / (1.0 - _FALLS)
        if not np.isfinite(error).all() or not error.any():
            break
        shares = _shares(problem, error)
        corrected = replace(problem, by_guides=after - own, lumping=shares, lumped=error)
        if float(np.mean(error[problem.in_train] ** 2)) <= SMALLEST_EXCESS:
            break
        left = after
    return corrected


def _shares(problem: Problem, error: FloatArray) -> dict[str, float]:
    """Column → root mean square of an error (m,) [noise] over the column's range, the largest."""
    shares: dict[str, float] = {}
    for k, column, rows in problem.signals:
        rms = float(np.sqrt(np.mean(error[rows][problem.train[k]] ** 2)))
        level = float(np.mean(problem.levels[k][column]))
        span = float(np.ptp(problem.recordings[k].columns[column])) / level
        shares[column] = max(shares.get(column, 0.0), rms / span if span > 0.0 else 0.0)
    return shares


def step_error(correction: FloatArray) -> float:
    """Mean square by which halving the step changes a residual [noise variance].

    The ``correction`` (m,) of `Problem.extrapolate` is twice that change, and to first order all
    of the step's error; the change itself measures the error that the correction may have missed.
    Of rests it is that change, of which half may be left.
    """
    return float(np.mean((0.5 * correction) ** 2)) if np.isfinite(correction).all() else np.inf


def uncertain_terms(problem: Problem) -> tuple[Term, ...]:
    """Terms of the uncertain parameters; those that one name stands for share it, or have each one.

    A parameter that is named by itself, in any table, is not part of a name with wildcards.
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
                width = min(width, longest)  # a longer time acts like one as long as the recording
            probe = _PROBE * width
            if 0.0 < abs(u.value) < probe:  # a range of decades
                probe = 2.0 * _PROBE * abs(u.value)
            terms += [
                Term(alike, parameters[alike[0]].unit, u.value, u.low, u.high, probe)
                for alike in ([(t,) for t in targets] if u.each else [tuple(targets)])
                if alike
            ]
    return tuple(terms)


@dataclass(frozen=True)
class Spread:
    """Values of a parameter that was set again for each recording, and their spread."""

    stated: float  # standard deviation that the recordings state [unit]
    estimated: float  # root mean square deviation of the fitted values from the stated one [unit]
    unit: str  # of both and of the values
    values: Mapping[str, float]  # recording → fitted value [unit]


def session_terms(recordings: Sequence[Recording], simulate: Simulates) -> tuple[Term, ...]:
    """Terms of every recording's own values."""
    named = [recording for recording in recordings if recording.session]
    if named and not simulate.sessions:
        raise InvalidValueError(
            f"simulator {type(simulate).__name__!r} does not support values of single recordings,"
            f" which [session] of {named[0].name!r} requires; see `sessions` of tendon_mj.Simulates"
        )
    names = [recording.name for recording in recordings]
    for recording in named:
        if names.count(recording.name) > 1:
            raise RecordingError(
                f"recording {recording.name!r}: two recordings have this name, so that the values"
                " set anew for each, in [session], cannot be told apart; rename one file"
            )
    parameters = simulate.parameters
    return tuple(
        Term(
            targets=(name_in_session(name, recording.name),),
            unit=parameters[name].unit,
            inert=own.value,
            low=max(own.value - _SESSION_RANGE * own.spread, parameters[name].low),
            high=own.value + _SESSION_RANGE * own.spread,
            probe=_SESSION_PROBE * own.spread,
            spread=_WIDER * own.spread,
        )
        for recording in named
        for name, own in _set_anew(recording, parameters).items()
    )


def _set_anew(recording: Recording, parameters: Mapping[str, Parameter]) -> dict[str, Session]:
    """Parameter → its entry in [session], except those that another table names."""
    claimed, entries = claims(recording, parameters), expand(recording.session, parameters)
    for name in entries:
        if name not in parameters:
            where = f"recording {recording.name!r}, [session]"
            raise UnknownNameError("parameter", name, parameters, where)
    return {name: own for name, own in entries.items() if claimed[name][0] == "session"}


def spreads(terms: Sequence[Term], values: Sequence[float] | np.ndarray) -> dict[str, Spread]:
    """Parameter → how much it differed between recordings, from the fitted values of the terms."""
    rows_of: dict[str, list[tuple[Term, float]]] = {}
    for term, value in zip(terms, values, strict=True):
        if term.spread > 0.0:
            rows_of.setdefault(parameter_of(term.targets[0]), []).append((term, float(value)))
    return {
        parameter: Spread(
            stated=rows[0][0].spread / _WIDER,
            estimated=float(np.sqrt(np.mean([(v - term.inert) ** 2 for term, v in rows]))),
            unit=rows[0][0].unit,
            values={recording_of(term.targets[0]): v for term, v in rows},
        )
        for parameter, rows in rows_of.items()
    }


def describe_system(problem: Problem) -> SystemDescription:
    """Describe the model and the recordings to the catalogue."""
    first, parameters = problem.recordings[0], problem.simulate.parameters
    fitted = [
        name
        for recording in problem.recordings
        for name in expand({**recording.uncertain, **recording.session}, parameters)
    ]
    joints, motors = (_elements(parameters, kind) for kind in ("joint", "motor"))
    driven, inputs = problem.simulate.joints, tuple(name for _, name in first.driven)
    return SystemDescription(
        values={name: parameter.value for name, parameter in parameters.items()},
        known=_known(problem),
        uncertain=frozenset({*fitted, *_drawn_bends(fitted)}),
        spans=_spans(problem.recordings),
        inputs=inputs,
        free_joints=tuple(joint for joint in joints if not driven.get(joint)),
        motors=tuple(name for name in inputs if name in motors),
        slides=frozenset(
            element(name)
            for name, p in parameters.items()
            if name.endswith(".armature") and (p.kind, p.unit) == _SLIDING
        ),
        joints={name: p.joints for name, p in parameters.items() if p.joints},
        reference={name: p.reference for name, p in parameters.items() if p.reference},
        columns=tuple(names for names in first.drive.values() if not isinstance(names, str)),
    )


def _spans(recordings: Sequence[Recording]) -> dict[str, float]:
    """Sensor → largest less smallest measured value, 1 where it is constant."""
    spans: dict[str, float] = {}
    for recording in recordings:
        for column, measured in recording.measured.items():
            span = float(np.ptp(recording.columns[column]))
            spans[measured.sensor] = max(spans.get(measured.sensor, 0.0), span) or 1.0
    return spans


def _known(problem: Problem) -> frozenset[str]:
    """Parameters that a recording calls known.

    A known `extra_bend`, the same in all recordings, makes the bend known: the drawn one too.
    """
    tables = [expand(r.known, problem.simulate.parameters) for r in problem.recordings]
    alike = [n for n, value in tables[0].items() if all(t.get(n) == value for t in tables)]
    return frozenset({*_drawn_bends(alike)}.union(*tables))


def _drawn_bends(names: Iterable[str]) -> list[str]:
    """Drawn bends of the sheaths that have their extra bend among the names."""
    parts = [name.rpartition(".") for name in names]
    return [f"{sheath}.{DRAWN_BEND}" for sheath, _, parameter in parts if parameter == EXTRA_BEND]


def _elements(parameters: Mapping[str, Parameter], kind: Kind) -> list[str]:
    return sorted({element(name) for name, p in parameters.items() if p.kind == kind})
