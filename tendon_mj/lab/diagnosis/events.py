"""Times and size of events, such as a slip of the cable, from the residual that a fit leaves.

An event of size a at time t_s in one recording changes its residual from then on. For every t_s the
reduction of χ² is computed from one simulation, in which the event is at the first sample: with g
its trace per size, g_s the trace from t_s on and 0 before, Q a basis of the fit's Jacobian and r
the residual,

    e(t_s) = −a (2 g_sᵀ P r + a g_sᵀ P g_s),    a = −g_sᵀ P r/(g_sᵀ P g_s),    P = 1 − Q Qᵀ,

with a no larger than the range of the drive. If its trace is faint, the best a would be one that
no rig bears.

Friction forgets where the drive was before its last reversal, so that g_s is right but for the time
until the next one. Events that promise enough are therefore simulated at times between samples
about the best, with several durations, ever closer: what is read while the cable slips, or while
the rig comes to rest after it, may be many times the noise.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tendon_mj.lab.diagnosis.data import Problem
from tendon_mj.lab.diagnosis.effects.effect import Candidate, Constant, Term
from tendon_mj.lab.diagnosis.fitting import Fit
from tendon_mj.lab.parameter_names import name_in_session
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import suppress_unsolved_warnings
from tendon_mj.typing import FloatArray

_PROBE = 0.02  # of the range of the drive
_MOST = 2  # events that are simulated in one search
_NEAR = 0.97  # of the Δχ² of the best time, to be simulated too
# In intervals between two samples: begins, about that of the scan, and durations that are tried
# first, those of the second set where the first explain enough, and how near the last ones lie.
_BEGINS = -4.0, -2.0, -1.0, -0.4, 0.0, 0.4, 1.0
_DURATIONS, _RESOLVED = ((1.0, 6.0), (0.0, 2.5, 15.0)), 0.05
_MOST_TIMES = 8  # other begins, where the scan is not sure
_FEWEST = 5  # samples before and after an event
_AS_GOOD = 4.0  # Δχ² of a time that is within the interval, over the mean square of the rest
_ROWS = 3  # samples about an event, in which a driven column may jump instead
_ALIKE = 0.3  # of an event, up to which such a jump is the same
_CLEARLY = 1.1  # times the Δχ² that a step of one reading's zero explains, for it to be an event


@dataclass(frozen=True, eq=False)
class _Event:
    """An event of one candidate in one recording, and the Δχ² that it explains."""

    candidate: Candidate
    recording: int
    time: float  # at which it begins [s]
    size: float
    explained: float
    ends: tuple[float, float]  # between which it may be, by the scan [s]
    duration: float = 0.0  # [s]


@suppress_unsolved_warnings()
def find_events(
    problem: Problem,
    base: Mapping[str, float],
    fitted: Fit,
    candidates: Sequence[Candidate],
    taken: Collection[str],
    least: float,
) -> list[Candidate]:
    """Candidates of events in single recordings, each with its time, that explain enough.

    A step of one reading's zero is not an event of a drive; where it explains as much, nothing is
    returned.

    ``candidates`` are events in no particular recording, ``taken`` parameters that the model's
    effects write, and ``least`` is the reduction of the reduced χ² that is enough [-].
    """
    names = Counter(recording.name for recording in problem.recordings)
    if not candidates or not problem.simulate.sessions:
        return []
    scan = _Scan(problem, base, fitted)
    enough = least * int(problem.in_train.sum())
    seen = [
        event
        for candidate in candidates
        for event in scan.events(candidate)
        if event.explained > enough
        and names[problem.recordings[event.recording].name] == 1
        and scan.name(candidate, event.recording) not in taken
    ]
    best = sorted(seen, key=lambda event: -event.explained)[:_MOST]
    located = [scan.locate(event, enough) for event in best]
    return [made for made in located if made is not None]


class _Scan:
    """Residuals of a fit, and the Δχ² of events in them."""

    def __init__(self, problem: Problem, base: Mapping[str, float], fitted: Fit) -> None:
        self.problem, self.fitted = problem, fitted
        self.used = problem.in_train
        self.values = fitted.parameters(base)
        slopes = fitted.jacobian[self.used]
        lengths = np.sqrt((slopes**2).sum(axis=0))
        slopes = slopes[:, lengths > 0.0] / lengths[lengths > 0.0]
        left, sizes, _ = np.linalg.svd(slopes, full_matrices=False)
        self.basis = left[:, sizes > 1e-6]  # of directions that compensate each other, one
        residual = fitted.residual[self.used]
        self.residual = residual - self.basis @ (self.basis.T @ residual)
        self.owner = problem.recording_of[self.used]
        clocks = [problem.recordings[k].time[problem.train[k]] for k, _, _ in problem.signals]
        self.times = np.concatenate(clocks)
        self.column = np.repeat(np.arange(len(clocks)), [clock.size for clock in clocks])

    def name(self, candidate: Candidate, recording: int, ending: str = "") -> str:
        """Name of an event's size in one recording, or with an ``ending`` of its time."""
        (target,) = candidate.targets
        return name_in_session(target + ending, self.problem.recordings[recording].name)

    def events(self, candidate: Candidate) -> list[_Event]:
        """The best event of each recording, from one simulation of all."""
        recordings = self.problem.recordings
        most = self._range(candidate)
        probe = _PROBE * most
        given = dict(self.values)
        for k, recording in enumerate(recordings):
            given[self.name(candidate, k)] = probe
            given[self.name(candidate, k, "_time")] = float(recording.time[0])
        (row,) = self.problem.residuals([given])
        if not (probe > 0.0 and np.isfinite(row).all()):
            return []
        trace = (row + self.fitted.correction - self.fitted.residual)[self.used] / probe
        events = []
        for k in range(len(recordings)):
            explained, sizes = self._explained(trace * (self.owner == k), k, most)
            best = int(np.argmax(explained))
            top, time = float(explained[best]), recordings[k].time
            near = np.flatnonzero(explained >= min(_NEAR * top, top - _AS_GOOD * self.left(top)))
            ends = float(time[max(near[0] - 2, 0)]), float(time[min(near[-1] + 1, time.size - 1)])
            when = float(0.5 * (time[max(best - 1, 0)] + time[best]))
            events.append(_Event(candidate, k, when, float(sizes[best]), top, ends))
        return events

    def _range(self, candidate: Candidate) -> float:
        """Range of the drive of the candidate's actuator [its control]."""
        (target,) = candidate.targets
        driven = (self._driven(target, recording) for recording in self.problem.recordings)
        return max((float(np.ptp(series)) for series in driven if series.size), default=0.0)

    def _driven(self, target: str, recording: Recording) -> FloatArray:
        """(n,) column that drives a candidate's actuator [its control]; empty without one."""
        actuator = target.rpartition(".")[0]
        scale = self.problem.simulate.parameters[f"{actuator}.command_scale"].value
        columns = [column for column, name in recording.driven if name == actuator]
        return scale * recording.columns[columns[0]] if columns else np.zeros(0)

    def _is_of_column(self, event: _Event) -> bool:
        """Return whether an event makes the drive jump back: an encoder that lost its zero."""
        recording = self.problem.recordings[event.recording]
        (target,) = event.candidate.targets
        changes = np.diff(self._driven(target, recording))
        row = int(np.searchsorted(recording.time, event.time))
        near = slice(max(0, row - _ROWS), row + _ROWS)
        around = changes[max(0, row - 4 * _ROWS) : row + 4 * _ROWS]
        jumped = changes[near] - float(np.median(around))
        return bool(np.any(np.abs(jumped + event.size) < _ALIKE * abs(event.size)))

    def _explained(
        self, trace: FloatArray, recording: int, most: float = np.inf
    ) -> tuple[FloatArray, FloatArray]:
        """(n,) Δχ² and size of an event before each sample of a recording, from its trace (m,).

        ``most`` is the largest size.
        """
        time = self.problem.recordings[recording].time
        own = np.flatnonzero(trace)
        samples = np.searchsorted(time, self.times[own])

        def after(values: FloatArray) -> FloatArray:
            """(n,) sums over the residuals from each sample on."""
            return np.bincount(samples, values, time.size)[::-1].cumsum()[::-1]

        basis = [after(trace[own] * column[own]) for column in self.basis.T]
        power = after(trace[own] ** 2)
        alone = power - sum((column**2 for column in basis), np.zeros(time.size))
        along = after(trace[own] * self.residual[own])
        last = int(self.problem.train[recording].sum()) - _FEWEST
        place = np.arange(time.size)
        visible = (alone > 1e-3 * power) & (power > 0.0) & (place >= _FEWEST) & (place <= last)
        alone = np.where(visible, alone, 1.0)
        size = np.where(visible, np.clip(-along / alone, -most, most), 0.0)
        return -size * (2.0 * along + size * alone), size

    def left(self, explained: float) -> float:
        """Mean square of the rest of the residual, at least that of noise."""
        return max(1.0, (float(self.residual @ self.residual) - explained) / self.residual.size)

    def locate(self, event: _Event, enough: float) -> Candidate | None:
        """The candidate at the time that explains most, by simulations of it at several times.

        None if it explains less than ``enough``, or not clearly more than a step of one zero.
        """
        interval = float(np.median(np.diff(self.problem.recordings[event.recording].time)))
        low, high = event.ends
        count = int(min(2 * round((high - low) / interval), _MOST_TIMES))
        begins = [event.time + share * interval for share in _BEGINS]
        begins += np.linspace(low, high, count).tolist()
        least = max(enough, _CLEARLY * self._step_of_a_zero(event.recording))
        tried, best, step = dict[tuple[float, float], _Event](), event, 0.5 * interval
        for durations in _DURATIONS:
            grid = [(when, share * interval) for when in begins for share in durations]
            tried |= self._simulate(event, grid)
            best = max(tried.values(), key=lambda one: one.explained, default=event)
            if not tried or best.explained < least:
                return None
        while step > _RESOLVED * interval:
            moves = [(a * step, b * step) for a in (-1.0, -0.5, 0.0, 0.5, 1.0) for b in (-1, 0, 1)]
            near = [(best.time + a, max(best.duration + b, 0.0)) for a, b in moves]
            tried |= self._simulate(best, [at for at in dict.fromkeys(near) if at not in tried])
            best = max(tried.values(), key=lambda one: one.explained)
            step *= 0.5
        if self._is_of_column(best):
            return None
        first = float(self.problem.recordings[event.recording].time[0]) - interval
        (from_start,) = self._simulate(best, [(first, 0.0)]).values() or (None,)
        as_good = best.explained - _AS_GOOD * self.left(best.explained)
        if from_start is not None and from_start.explained > as_good:
            return None  # another zero, which the recording has from its start
        return self._candidate(best, list(tried.values()))

    def _simulate(
        self, event: _Event, times: Sequence[tuple[float, float]]
    ) -> dict[tuple[float, float], _Event]:
        """Begin and duration → the event there, if its simulation did not fail."""
        endings = ("", "_time", "_duration")
        names = [self.name(event.candidate, event.recording, ending) for ending in endings]
        sets = [{**self.values, **dict(zip(names, (event.size, *at), strict=True))} for at in times]
        most = self._range(event.candidate)
        own, before = self.owner == event.recording, self.fitted.correction - self.fitted.residual
        events = {}
        for at, row in zip(times, self.problem.residuals(sets), strict=True):
            if not np.isfinite(row).all():
                continue
            trace = (row + before)[self.used] * own / event.size
            free = trace - self.basis @ (self.basis.T @ trace)
            alone, along = float(free @ free), float(free @ self.residual)
            if alone > 0.0 and along != 0.0:
                size = min(max(-along / alone, -most), most)
                explained = -size * (2.0 * along + size * alone)
                events[at] = replace(
                    event, time=at[0], duration=at[1], size=size, explained=explained
                )
        return events

    def _step_of_a_zero(self, recording: int) -> float:
        """Largest Δχ² that a step of one reading's zero in the recording explains."""
        return max(
            float(self._explained((self.column == j).astype(float), recording)[0].max())
            for j, (k, _, _) in enumerate(self.problem.signals)
            if k == recording
        )

    def _candidate(self, best: _Event, tried: Sequence[_Event]) -> Candidate:
        """Candidate of the best of several events, with an interval of its time."""
        recording, template = self.problem.recordings[best.recording], best.candidate
        least = best.explained - _AS_GOOD * self.left(best.explained)
        alike = [one for one in tried if one.explained > least]
        begins, begin, time = [one.time for one in alike], best.time, recording.time
        after = int(np.clip(np.searchsorted(time, begin), 1, time.size - 1))
        early, late = float(time[after - 1]), float(time[after])  # no nearer than these
        durations = [one.duration for one in alike]
        times = begin, min(*begins, early), max(*begins, late)
        ends = min(*durations, best.duration - late + early), best.duration + late - early
        lasting = best.duration, max(ends[0], 0.0), max(*durations, ends[1])
        span, (term,) = self._range(template), template.terms
        when, long = (self.name(template, best.recording, e) for e in ("_time", "_duration"))
        sign = 1.0 if best.size > 0.0 else -1.0
        located = Term(
            targets=(self.name(template, best.recording),),
            unit=term.unit,
            inert=term.inert,
            low=min(0.0, sign * span),
            high=max(0.0, sign * span),
            probe=min(abs(best.size), span),
            constants=(Constant(when, *times), Constant(long, *lasting)),
        )
        where = f"{template.where} in {recording.name}"
        return replace(template, where=where, terms=(located,))
