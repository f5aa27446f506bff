"""Baseline of a diagnosis: a fit of the same recordings by `mujoco.sysid` alone.

The parameters that the recordings call uncertain are fitted in the model as it is: as
`sysid.Parameter`s with the recordings' ranges, by `sysid.optimize` with its own least squares, on
residuals weighted as it weights them (each column by its own size), with its own 95 % intervals.

The simulation is ours. `sysid` recompiles an `MjSpec` for every parameter set and then rolls out
from a stored full state; the parameters of a sheath live in that state, so restoring it would
overwrite them with the compiled-in values, and the history of its friction begins before the first
sample. So its residual function is replaced, as `sysid.optimize` allows, by one that calls a
`Simulator`, which sets parameters in the state, settles first, and runs parameter sets in parallel.
"""

from __future__ import annotations

import io
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_mj.errors import TendonError
from tendon_mj.lab.diagnosis.data import (
    MakeSimulator,
    Problem,
    all_samples,
    by_recording,
    make_problem,
    training_samples,
    uncertain_terms,
)
from tendon_mj.lab.diagnosis.verdict import measure_errors
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Simulator, suppress_unsolved_warnings
from tendon_mj.typing import FloatArray

_DIFFERENCE = 1e-5  # of a range; its own 1e-8 finds the same, but is near the simulations' rounding
_DAMPING_FACTOR = 10.0  # its own 10^0.1 tries 140 ever smaller steps if none is left to take
_TOLERANCE = 1e-5  # of the step, in ranges: far inside any interval
_ITERATIONS = 30
_FAILED = 1e3  # residual of a failed simulation, in sizes of the measured column


@dataclass(frozen=True)
class SysidResult:
    """Result of a fit."""

    # parameter → (value, low, high), with the 95 % interval that sysid states [SI]
    values: Mapping[str, tuple[float, float, float]]
    # error over all columns, each in units of its own noise [-], as in Diagnosis: on training data
    # and on held-out data
    train_rms: float
    held_out_rms: float
    signals: Mapping[str, float]  # column → held-out error [the column's unit]
    seconds: float  # duration of the fit [s]
    note: str  # caveat for the reader

    def __repr__(self) -> str:
        """The values and the errors, in two lines."""
        values = ", ".join(f"{name} = {value:.4g}" for name, (value, _, _) in self.values.items())
        return (
            f"SysidResult: {values or 'no parameters'}\n  rms error"
            f" [noise]: {self.train_rms:.2f} on training data, {self.held_out_rms:.2f} on held-out"
            " data"
        )

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        return {
            "parameters": {
                name: {"value": value, "low": low, "high": high}
                for name, (value, low, high) in self.values.items()
            },
            "train": self.train_rms,
            "held_out": self.held_out_rms,
            "signals": dict(self.signals),
            "seconds": self.seconds,
            "note": self.note,
        }


def sysid_is_there() -> bool:
    """Return whether `mujoco.sysid` can be used; without its dependencies it is empty, or none."""
    try:
        from mujoco import sysid
    except ImportError:  # before MuJoCo 3.17 without its dependencies
        return False
    return hasattr(sysid, "optimize")


def fit_with_sysid(
    train: Sequence[Recording],
    held_out: Sequence[Recording] = (),
    progress: Progress = silent,
    *,
    simulator: MakeSimulator = Simulator,
) -> SysidResult:
    """Fit the uncertain parameters of recordings with `mujoco.sysid`, and measure the errors.

    Args:
        train: recordings to fit.
        held_out: recordings that are not fitted; without any, the last quarter of each of
            ``train``, or if these are of different states of the rig each of them in turn.
        progress: called with a label, how much is done, and of how much.
        simulator: makes the simulator of recordings.

    Raises:
        TendonError: `mujoco.sysid` is not installed; the message says how it comes.
    """
    if not sysid_is_there():
        raise TendonError(
            "mujoco.sysid lacks its dependencies: pip install 'tendon-mj[sysid]', or leave the"
            " comparison out (--no-sysid)"
        )
    began = time.perf_counter()
    problem = make_problem(train, simulator(train), training_samples(train, held_out))
    values = _optimize(problem, progress)
    fitted = {name: value for name, (value, _, _) in values.items()}
    residual = problem.residuals([fitted])[0]
    seen = measure_errors(problem, residual, residual, problem.in_train)
    if held_out:
        proof = make_problem(held_out, simulator(held_out), all_samples(held_out))
        unseen = proof.residuals([fitted])[0]
        errors = measure_errors(proof, unseen, unseen, np.ones(unseen.size, bool))
    elif by_recording(train):
        unseen = _each_by_the_others(problem, simulator, progress)
        errors = measure_errors(problem, unseen, unseen, np.ones(unseen.size, bool))
    else:
        errors = measure_errors(problem, residual, residual, ~problem.in_train)
    return SysidResult(
        values=values,
        train_rms=seen.after,
        held_out_rms=errors.after,
        signals={column: after for column, (_, after, _) in errors.signals.items()},
        seconds=time.perf_counter() - began,
        note=_note(train, values),
    )


def _each_by_the_others(
    problem: Problem, simulator: MakeSimulator, progress: Progress
) -> FloatArray:
    """(m,) residual of each recording with the values fitted to the others."""
    residual = np.empty(problem.recording_of.size)
    for k in range(len(problem.recordings)):
        others = [r for j, r in enumerate(problem.recordings) if j != k]
        rest = make_problem(others, simulator(others), all_samples(others))
        fitted = {name: value for name, (value, _, _) in _optimize(rest, progress).items()}
        rows = problem.recording_of == k
        residual[rows] = problem.residuals([fitted])[0][rows]
    return residual


@suppress_unsolved_warnings()
def _optimize(problem: Problem, progress: Progress) -> dict[str, tuple[float, float, float]]:
    """Parameter → value and ends of its interval; empty if nothing is uncertain.

    Parameters go through the fit as shares of their ranges, so that its one step of differences
    suits a coefficient as well as a stiffness.
    """
    terms = uncertain_terms(problem)
    ranges = {term.targets[0]: term for term in terms}
    if not ranges:
        return {}
    from mujoco import sysid  # loads plotly

    parameters = sysid.ParameterDict()
    for name, u in ranges.items():
        parameters.add(sysid.Parameter(name, (u.inert - u.low) / (u.high - u.low), 0.0, 1.0))
    parameters.move_off_bounds()
    calls = 0

    def natural(share: float, name: str) -> float:
        return float(ranges[name].low + share * (ranges[name].high - ranges[name].low))

    def residuals(x: FloatArray, params: Any) -> tuple[list[FloatArray], None, None]:
        nonlocal calls
        points = x.reshape(len(ranges), -1)
        progress("mujoco.sysid", min(calls, 2 * _ITERATIONS - 1), 2 * _ITERATIONS)
        calls += 1
        sets = []
        for point in points.T:
            shares = zip(params.keys(), point, strict=True)
            sets.append({name: natural(s, n) for n, s in shares for name in ranges[n].targets})
        rows = [np.concatenate(_weighted(problem, answers)) for answers in problem.simulate(sets)]
        stacked = np.stack(rows, axis=1)
        return [stacked if x.ndim > 1 else stacked[:, 0]], None, None

    fitted, outcome = sysid.optimize(
        parameters,
        residuals,
        optimizer="mujoco",
        verbose=False,
        max_iters=_ITERATIONS,
        eps=_DIFFERENCE,
        xtol=_TOLERANCE,
        mu_factor=_DAMPING_FACTOR,
        output=io.StringIO(),
    )
    last, _, _ = residuals(fitted.as_vector(), fitted)
    _, halves = sysid.calculate_intervals(last, outcome.jac)
    progress("mujoco.sysid", 2 * _ITERATIONS, 2 * _ITERATIONS)
    return {
        target: (
            natural(share, name),
            natural(max(share - half, 0.0), name),
            natural(min(share + half, 1.0), name),
        )
        for name, share, half in zip(fitted.keys(), fitted.as_vector(), halves, strict=True)
        for target in ranges[name].targets
    }


def _weighted(problem: Problem, answers: Sequence[Mapping[str, FloatArray]]) -> list[FloatArray]:
    """Training residuals of every recording as sysid weights them."""
    from mujoco import sysid

    weighted = []
    for recording, kept, series in zip(problem.recordings, problem.train, answers, strict=True):
        columns = list(recording.measured)
        measured = np.stack([recording.columns[c][kept] for c in columns], axis=1)
        simulated = np.stack([series[c][kept] for c in columns], axis=1)
        error = sysid.signal_modifier.weighted_diff(simulated, measured)
        share = sysid.signal_modifier.normalize_residual(error, measured)
        weighted.append(np.nan_to_num(share, nan=_FAILED, posinf=_FAILED).ravel())
    return weighted


def _note(train: Sequence[Recording], values: Mapping[str, object]) -> str:
    if not values:
        return f"the recordings of {train[0].model!r} call nothing uncertain: nothing was fitted"
    note = (
        "structure of the model as it is; intervals as sysid states them, which treat every sample"
        " as independent and the model as correct"
    )
    if any(recording.session for recording in train):
        note += "; values set anew for each recording are those that [session] states"
    return note
