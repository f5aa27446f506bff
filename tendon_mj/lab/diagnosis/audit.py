"""Evidence next to a verdict: its sensitivity to the noise, correlations, whiteness, provenance.

For another noise nothing is fitted or simulated again: least squares finds the same values whatever
the noise is, if it changes for all signals alike. An error of E times the noise is E/f times a
noise that is f times as large; an excess χ² of steps and guides is 1/f² of its value. Scatter
between sessions of the rig is taken to be f times as large too. With these numbers the criteria of
the verdict are applied again, to the same findings. Whether a search with another noise would have
found others is not known.
"""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from tendon_mj.lab.diagnosis.limits import LARGEST_EXCESS, SMALLEST_EXCESS
from tendon_mj.lab.diagnosis.result import BeforeAfter, Diagnosis
from tendon_mj.lab.diagnosis.statistics import correlation_matrix
from tendon_mj.lab.diagnosis.verdict import ErrorReduction, Evidence, Verdict, decide
from tendon_mj.lab.diagnosis.wording import reason
from tendon_mj.lab.recordings import Recording, files_in, table_beside
from tendon_mj.models import model_path
from tendon_mj.typing import FloatArray

_FACTORS = 0.5, 1.0, 2.0
_FARTHEST = 8.0  # factor up to which the end of a verdict is searched
_RATIO = 2.0 ** (1.0 / 16.0)  # between the factors that are tried

_HIGH = 0.9  # |ρ| from which two values are said to compensate each other

_LAGS = 40  # at most
_LAG_SHARE = 0.25  # of the samples, at most
_QUANTILE = 1.96  # of a normal distribution: 95 % of the lags of white noise lie within
_CHANCE = 0.01  # probability with which white noise has fewer lags within the band

_PACKAGES = ("tendon-mj", "mujoco", "numpy", "scipy")


@dataclass(frozen=True)
class NoiseCase:
    """The criteria of a verdict for another noise."""

    factor: float  # noise over the stated one
    # rms error on held-out data [that noise and reproducibility]
    before: float
    after: float
    closed: float  # share of the error above that which is removed; 1 if all is
    # that the criteria give for the same findings; None if an error remains to which no finding
    # belongs, so that a search would have to decide
    verdict: Verdict | None
    reason: str  # the criterion that decides, in a sentence


@dataclass(frozen=True)
class NoiseSensitivity:
    """Dependence of a verdict on the noise."""

    cases: tuple[NoiseCase, ...]  # in the order of the factors
    # the verdict is the same from low to high times the stated noise
    low: float
    high: float
    farthest: float = _FARTHEST  # largest factor that was tried; its reciprocal is the smallest


def noise_sensitivity(
    diagnosis: Diagnosis, factors: Sequence[float] = _FACTORS
) -> NoiseSensitivity:
    """Apply the criteria of a finished diagnosis to other noises, ``factors`` times the stated."""
    evidence = diagnosis.evidence
    # alternatives do not depend on the noise alone: without them
    verdict = (_judge(evidence) or "unknown") if diagnosis.alternatives else diagnosis.verdict
    low, high = (_reach(evidence, verdict, ratio) for ratio in (1.0 / _RATIO, _RATIO))
    return NoiseSensitivity(tuple(_case(evidence, factor) for factor in factors), low, high)


def _case(evidence: Evidence, factor: float) -> NoiseCase:
    scaled = with_noise(evidence, factor)
    errors, verdict = scaled.extrapolated, _judge(scaled)
    closed = min(errors.reducible_closed, 1.0) if errors.before > 1.0 else 1.0
    return NoiseCase(factor, errors.before, errors.after, closed, verdict, reason(scaled, verdict))


def with_noise(evidence: Evidence, factor: float) -> Evidence:
    """The evidence in units of a noise that is ``factor`` times the stated one."""
    power = factor**2
    lumping, step = evidence.lumping / power, evidence.step / power
    excess = (1.0 + evidence.excess) / power - 1.0
    limit = max(SMALLEST_EXCESS, step, lumping)
    return replace(
        evidence,
        calibrated=excess <= limit if factor != 1.0 else evidence.calibrated,
        held_out=_scaled(evidence.held_out, factor),
        weighed=_scaled(evidence.weighed, factor),
        extrapolated=_scaled(evidence.extrapolated, factor),
        zero_step=evidence.zero_step / factor,
        reproducibility={c: factor * d for c, d in evidence.reproducibility.items()},
        limit=limit,
        largest=max(LARGEST_EXCESS, lumping),
        excess=excess,
        step=step,
        lumping=lumping,
    )


def _scaled(errors: ErrorReduction, factor: float) -> ErrorReduction:
    signals = {c: (b, a, noise * factor) for c, (b, a, noise) in errors.signals.items()}
    return replace(
        errors, before=errors.before / factor, after=errors.after / factor, signals=signals
    )


def _judge(evidence: Evidence) -> Verdict | None:
    """The verdict by its criteria; None if an error remains that no finding is of."""
    if evidence.calibrated and evidence.extrapolated.before**2 - 1.0 <= evidence.limit:
        return "nothing missing"
    return decide(evidence) if evidence.kinds else None


def _reach(evidence: Evidence, verdict: Verdict, ratio: float) -> float:
    """The last factor, going from 1 in steps of a ratio, at which the verdict is the same."""
    factor = 1.0
    while 1.0 / _FARTHEST * 1.001 < factor < _FARTHEST / 1.001:
        if _judge(with_noise(evidence, factor * ratio)) != verdict:
            break
        factor *= ratio
    return factor


@dataclass(frozen=True)
class Correlations:
    """Correlations of estimates: which of the fitted parameters compensate each other."""

    names: tuple[str, ...]  # of the parameters; of those that share one number, the first
    matrix: tuple[tuple[float, ...], ...]  # (n, n) correlation coefficients [-]

    @property
    def high(self) -> list[tuple[str, str, float]]:
        """Pairs that are correlated by more than 0.9, and the coefficient."""
        return [
            (one, other, self.matrix[j][k])
            for j, one in enumerate(self.names)
            for k, other in enumerate(self.names[:j])
            if abs(self.matrix[j][k]) > _HIGH
        ]


def parameter_correlations(diagnosis: Diagnosis) -> Correlations | None:
    """Correlations of the values that hold in all recordings and that the data determine.

    None if a diagnosis was not made by `diagnose`, or there are fewer than two such values.
    """
    if diagnosis.search is None:
        return None
    context, selection = diagnosis.search
    fit = selection.final.fit
    chosen = fit.free & fit.shared
    if int(chosen.sum()) < 2:
        return None
    matrix = correlation_matrix(context.problem, fit, chosen)
    names = tuple(t.targets[0] for t, used in zip(fit.terms, chosen, strict=True) if used)
    return Correlations(names, tuple(tuple(map(float, row)) for row in matrix))


@dataclass(frozen=True, eq=False)
class Autocorrelation:
    """Autocorrelation of a residual."""

    lags: FloatArray  # (n,) [s], from one sample on
    values: FloatArray  # (n,) ρ(lag), 1 at lag 0 [-]
    band: float  # 95 % of the values of white noise lie within ± this [-]

    @property
    def inside(self) -> float:
        """Share of the lags with a value within the band."""
        return float(np.mean(np.abs(self.values) <= self.band))

    @property
    def white(self) -> bool:
        """Whether as many lags lie within the band as of white noise."""
        count = self.values.size
        return bool(count * self.inside >= scipy.stats.binom.ppf(_CHANCE, count, 0.95))


def autocorrelation(time: FloatArray, residual: FloatArray) -> Autocorrelation:
    """ρ_k = Σ e_i e_{i+k} / Σ e_i², of the residual (n,) less its mean.

    Lags are whole samples, given in median intervals of ``time`` (n,) [s].
    """
    error = residual - residual.mean()
    count = max(1, min(_LAGS, int(_LAG_SHARE * error.size)))
    power = float(error @ error)
    steps = np.arange(1, count + 1)
    sums = np.array([error[:-k] @ error[k:] for k in steps])
    values = np.asarray(sums / power if power > 0.0 else np.zeros(count), np.float64)
    lags = np.asarray(steps * np.median(np.diff(time)), np.float64)
    return Autocorrelation(lags, values, _QUANTILE / float(np.sqrt(error.size)))


def residual_autocorrelations(
    row: BeforeAfter,
) -> dict[str, tuple[Autocorrelation, Autocorrelation]]:
    """Measured column → autocorrelation of its residual before and after."""

    def of(simulated: Recording, column: str) -> Autocorrelation:
        error = simulated.columns[column] - row.measured.columns[column]
        return autocorrelation(row.measured.time, error)

    return {c: (of(row.before, c), of(row.after, c)) for c in row.measured.measured}


@dataclass(frozen=True)
class Provenance:
    """Versions, command, date and files of a result."""

    date: str  # ISO 8601, with the offset of local time
    versions: Mapping[str, str]  # "python" and packages → version
    command: str = ""  # as it was typed; empty if there was none
    # file as it was given → SHA-256 of its bytes, in hexadecimal digits
    files: Mapping[str, str] = field(default_factory=dict)

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        return vars(self) | {"versions": dict(self.versions), "files": dict(self.files)}


def files_of(
    paths: Iterable[Path], description: Path | None, recordings: Iterable[Recording]
) -> list[Path]:
    """Files that a diagnosis of recordings read: their data, descriptions, and models.

    A path is of a file of data, of its TOML, or the stem of both; ``description`` is the TOML of
    recordings that have not one each. A model's own includes are not among the files.
    """
    files = list[Path]()
    for path in paths:
        table, toml = table_beside(path)
        files += [*files_in(table), description or toml]
    files += [model_path(model) for model in {r.model: None for r in recordings}]
    return list(dict.fromkeys(files))


def collect_provenance(command: str = "", files: Iterable[str | Path] = ()) -> Provenance:
    """Provenance of a result that is made now, by a command as typed, from files to be hashed."""
    versions = {"python": platform.python_version()}
    return Provenance(
        date=datetime.now().astimezone().isoformat(timespec="seconds"),
        versions=versions | {name: version(name) for name in _PACKAGES},
        command=command,
        files={str(file): hashlib.sha256(Path(file).read_bytes()).hexdigest() for file in files},
    )
