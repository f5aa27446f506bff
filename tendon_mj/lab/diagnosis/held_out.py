"""Held-out data as fitted models simulate them, in one of three ways.

* Recordings that were held out: all of each.
* None, and recordings of different states of the rig: each by a model that is fitted to the others.
* None, and recordings of one state: the last quarter of each.

Values that were set anew for a recording are fitted to it, by every model alike. An event of one
recording is in no other one: a recording in which one was found is judged next to those that were
held out, and with the event as it was fitted to it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.diagnosis.data import Problem, by_recording, session_terms, with_step
from tendon_mj.lab.diagnosis.effects.effect import Term
from tendon_mj.lab.diagnosis.fitting import Fit, fit
from tendon_mj.lab.replay import recording_of
from tendon_mj.typing import FloatArray

_REFIT = 6  # evaluations: a model changes little when one recording is left out
_SESSION = 8  # evaluations, of a few numbers that hardly depend on each other


@dataclass(frozen=True, eq=False)
class Unseen:
    """Held-out data as one model simulates them."""

    extrapolated: FloatArray  # (m,) residual for a step of zero
    correction: FloatArray  # (m,) extrapolated less simulated residual
    stated: FloatArray  # (m,) residual with the model's own step
    # values set anew for each recording outside the training data, <parameter> @ <recording> →
    # value
    sessions: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Data of a proof."""

    problem: Problem  # training data, with the step of the search
    own: Problem  # training data with the model's own step
    proof: Problem  # held-out recordings with the model's own step; own where there are none
    step: float | None  # of the search, see with_step
    base: Mapping[str, float]  # parameter → value of the model
    _refits: dict[int, tuple[Fit, list[Fit]]] = field(default_factory=dict, init=False)

    @property
    def has_recordings(self) -> bool:
        """Whether recordings were held out."""
        return self.proof is not self.own

    @property
    def leaves_one_out(self) -> bool:
        """Whether each recording is held out in turn."""
        return not self.has_recordings and by_recording(self.own.recordings)

    @property
    def mask(self) -> NDArray[np.bool_]:
        """(m,) residuals of ``proof`` that are held out."""
        if self.has_recordings or self.leaves_one_out:
            return np.ones(self.proof.in_train.size, bool)
        return ~self.own.in_train

    def simulate(self, fitted: Fit) -> Unseen:
        """Simulate the held-out data with a model that was fitted to the training data."""
        if self.has_recordings:
            return self._recordings(fitted)
        if self.leaves_one_out:
            return self._each_by_the_others(fitted)
        parameters = fitted.parameters(self.base)
        stated = self.own.residuals([parameters])[0]
        return Unseen(fitted.residual, fitted.correction, stated, {})

    def _recordings(self, fitted: Fit) -> Unseen:
        shared, judged = _shared(fitted, self.base), with_step(self.proof, self.step)
        shared |= _events(fitted, self.base, {r.name for r in self.proof.recordings})
        terms = session_terms(self.proof.recordings, self.proof.simulate)
        alone = _fit_sessions(judged, shared, terms)
        sessions = alone.parameters(self.base)
        stated = self.proof.residuals([{**shared, **sessions}])[0]
        return Unseen(alone.residual, alone.correction, stated, sessions)

    def _each_by_the_others(self, fitted: Fit) -> Unseen:
        rows = self.problem.recording_of
        parts = np.empty((3, rows.size))
        for k, refitted in enumerate(self.refits(fitted)):
            recording = self.problem.recordings[k]
            shared = _shared(refitted, self.base) | _events(fitted, self.base, {recording.name})
            terms = [t for t in fitted.calibrated if recording_of(t.targets[0]) == recording.name]
            masks = [np.full(t.size, j == k) for j, t in enumerate(self.problem.train)]
            alone = _fit_sessions(replace(self.problem, train=tuple(masks)), shared, terms)
            stated = self.own.residuals([{**shared, **alone.parameters(self.base)}])[0]
            own = rows == k
            parts[:, own] = alone.residual[own], alone.correction[own], stated[own]
        return Unseen(parts[0], parts[1], parts[2], {})

    def refits(self, fitted: Fit) -> list[Fit]:
        """The model fitted to all recordings but each; none where all are of one state."""
        if not by_recording(self.problem.recordings):
            return []
        if id(fitted) not in self._refits:  # kept with the fit, so that its id stays its own
            refits = [self._without(k, fitted) for k in range(len(self.problem.recordings))]
            self._refits[id(fitted)] = fitted, refits
        return self._refits[id(fitted)][1]

    def _without(self, left_out: int, fitted: Fit) -> Fit:
        """The model fitted to all recordings but one."""
        masks = [mask & (k != left_out) for k, mask in enumerate(self.problem.train)]
        return fit(
            replace(self.problem, train=tuple(masks)),
            self.base,
            fitted.calibrated,
            fitted.effects,
            fitted.values,
            correction=fitted.correction,
            evaluations=_REFIT,
        )


def _shared(fitted: Fit, base: Mapping[str, float]) -> dict[str, float]:
    """Parameter → value that holds in all recordings."""
    return {n: value for n, value in fitted.parameters(base).items() if not recording_of(n)}


def _events(fitted: Fit, base: Mapping[str, float], names: Collection[str]) -> dict[str, float]:
    """Parameter → value of the events of a model in recordings of these names."""
    written = fitted.parameters(base)
    own = {n for e in fitted.effects for t in e.terms for n in t.write(0.0, {**base, **written})}
    return {n: v for n, v in written.items() if n in own and recording_of(n) in names}


def _fit_sessions(problem: Problem, shared: Mapping[str, float], terms: Sequence[Term]) -> Fit:
    """Fit the values of single recordings, with all others fixed; or simulate them."""
    start = np.array([term.inert for term in terms])
    return fit(replace(problem, fixed=shared), {}, terms, (), start, evaluations=_SESSION)
