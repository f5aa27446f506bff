"""Result of a diagnosis: a verdict, its evidence in numbers, the final model, and simulations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from tendon_mj.lab import renderers
from tendon_mj.lab.data_check import DataWarning
from tendon_mj.lab.diagnosis.data import Spread, by_recording
from tendon_mj.lab.diagnosis.effects.effect import Effect
from tendon_mj.lab.diagnosis.fitting import Fit
from tendon_mj.lab.diagnosis.regimes import Located
from tendon_mj.lab.diagnosis.selection import Selection, SelectionContext
from tendon_mj.lab.diagnosis.verdict import ErrorReduction, Evidence, Verdict
from tendon_mj.lab.parameter_names import expand, recording_of, values_for
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording, write_recording
from tendon_mj.lab.replay import Simulates, as_recording, described_values, patch_model
from tendon_mj.lab.units import estimated_percent


@dataclass(frozen=True)
class Value:
    """A fitted parameter and its 95 % interval."""

    # estimate and ends of the interval [unit]
    value: float
    low: float
    high: float
    unit: str  # of all three
    before: float  # value in the model as described [unit]
    determined: bool = True  # whether the data determine it; else low and high are its range
    at_end: bool = False  # whether it is calibrated, and at an end of its range

    @property
    def suffix(self) -> str:
        """Unit to write after the value; empty for a ratio."""
        return f" {self.unit}" if self.unit not in ("", "-") else ""


@dataclass(frozen=True)
class Finding:
    """An effect that is missing, or a parameter that was wrong."""

    # from the catalogue
    identifier: str
    name: str
    equation: str
    where: str  # elements it is on
    kind: str  # "missing", or "parameter" for a number that the model has at another value
    confidence: float  # that it is this one and none of the rivals, 0 … 1
    rivals: tuple[str, ...]  # identifiers of effects that the data cannot tell from it
    # elements on which the data cannot tell the same effect from it
    elsewhere: tuple[str, ...] = ()
    statement: str = ""  # the finding in words, with its value; see state_finding
    # name of the parameter that is its strength; the first, where it has several
    parameter: str = ""
    recording: str = ""  # the one that it happened in, of an event; else empty

    @property
    def summary(self) -> str:
        """The finding in words, with its value where it is on one element and no other."""
        if self.statement and not self.elsewhere:
            return self.statement
        return f"{self.name} ({' or '.join((self.where, *self.elsewhere))})"


@dataclass(frozen=True)
class Alternative:
    """A model with one more effect, or one other, that explains the data as well."""

    identifier: str  # of the effect; empty if another number is not at the end of its range
    statement: str  # the effect or that number, in words
    values: Mapping[str, float]  # parameters that it moves → their values there
    fitted: bool = False  # whether these fit best; else they are the ends of their intervals
    decided_by: str = ""  # what decides, but for the effect's next experiment
    fit: Fit | None = field(default=None, repr=False)  # of that effect; not in `Diagnosis.result`

    def result(self) -> dict[str, Any]:
        """Fields for a result.json."""
        return {name: value for name, value in vars(self).items() if name != "fit"}


@dataclass(frozen=True)
class Ranked:
    """A candidate for the first finding."""

    # effect and elements
    identifier: str
    where: str
    explains: float  # share of the calibrated model's excess χ² that it removes by screening [-]
    # cross-validated rms error [noise]; None if it was not fitted, as others promised more
    left: float | None
    # end of its range at which its strength stands, so that it names nothing [unit]
    at_end: float | None = None
    unit: str = ""  # of its strength


class BeforeAfter(NamedTuple):
    """A recording and two simulations of it."""

    measured: Recording  # the recording
    before: Recording  # by the model with only the uncertain parameters fitted
    after: Recording  # by the final model


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Result of a diagnosis.

    Attributes:
        verdict: see `tendon_mj.lab.diagnosis.workflow`.
        sentence: the verdict in words.
        findings: named effects and parameters, in the order of how much they explain. Empty
            unless the verdict is "named", "parameter" or "partly".
        closest: identifiers that explained most where the verdict is "unknown". They are not
            proven; ``parameters``, ``model`` and the errors after are of the model with them.
        excluded: identifiers of effects that were not considered.
        ranking: every candidate for the first finding that explains anything, the fitted ones
            first.
        calibrated: fitted parameters that the recordings call uncertain.
        parameters: fitted parameters of the findings, or of the closest effects.
        sessions: parameter → its values set anew for each recording, and their spread.
        train: errors on training data [noise].
        evidence: errors on held-out data and their limits, by which the verdict was decided.
        located, remaining: misfit of the calibrated and of the final model, on training data.
        proof: misfit of both on held-out data.
        before: every parameter → value of the calibrated model.
        model: every parameter → value of the final model. In both, ``<parameter> @ <recording>`` is
            a value set anew for a recording.
        seconds: duration of the diagnosis [s].
        catalogue: identifier → effect, of all that could have been named.
        simulator: of the held-out recordings; if there are none, of all.
        recordings, held_out_recordings: data of the diagnosis; without the second, each of the
            first was held out in turn, or the last quarter of each.
        search: training data and the models that were compared on them, for `suggest_experiment`;
            None for a diagnosis that `diagnose` did not make.
        warnings: of possible errors in the result, in whole sentences.
        checks: warnings about the recordings, from before any fit; they are among ``warnings``.
            If one of them ``blocks``, an effect is named only if it leaves no more than noise.
        alternatives: models that explain the data as well, by values outside of the intervals that
            hold without them; those stated include them.
    """

    verdict: Verdict
    sentence: str
    findings: tuple[Finding, ...]
    closest: tuple[str, ...]
    excluded: tuple[str, ...]
    ranking: tuple[Ranked, ...]
    calibrated: Mapping[str, Value]
    parameters: Mapping[str, Value]
    sessions: Mapping[str, Spread]
    train: ErrorReduction
    evidence: Evidence
    located: Located
    remaining: Located
    proof: tuple[Located, Located]
    before: Mapping[str, float]
    model: Mapping[str, float]
    seconds: float
    catalogue: Mapping[str, Effect] = field(repr=False)
    simulator: Simulates = field(repr=False)
    recordings: tuple[Recording, ...] = field(repr=False)
    held_out_recordings: tuple[Recording, ...] = field(repr=False)
    search: tuple[SelectionContext, Selection] | None = field(default=None, repr=False)
    warnings: tuple[str, ...] = ()
    checks: tuple[DataWarning, ...] = ()
    alternatives: tuple[Alternative, ...] = ()

    def __repr__(self) -> str:
        """The verdict, the findings and the errors, in a few lines."""
        errors = self.held_out
        sure = f", confidence {estimated_percent(self.confidence)}" if self.findings else ""
        lines = [f"Diagnosis: {self.verdict}{sure}"]
        lines += [f.summary for f in self.findings]
        lines += [
            f"rms error on held-out data [{errors.unit}]: {errors.before:.2f} before,"
            f" {errors.after:.2f} after",
            f"{len(self.calibrated) + len(self.parameters)} fitted parameters: to_dataframe();"
            f" warnings: {len(self.warnings)}",
        ]
        return "\n  ".join(lines)

    def _repr_html_(self) -> str:
        """The first screen of the report, for a notebook; simulates the recordings shown."""
        return renderers["diagnosis"](self)

    def to_dataframe(self) -> pd.DataFrame:
        """Fitted parameters, those of the findings first, with their 95 % intervals [unit].

        Columns are value, low, high, unit, before, determined, at_end (see `Value`) and finding,
        whether the parameter belongs to a finding or to one of the closest effects.
        """
        rows = {
            name: vars(value) | {"finding": name in self.parameters}
            for name, value in {**self.parameters, **self.calibrated}.items()
        }
        columns = [*(f.name for f in fields(Value)), "finding"]
        table = pd.DataFrame.from_dict(rows, orient="index", columns=columns)
        return table.rename_axis("parameter")

    @property
    def effects(self) -> list[str]:
        """Identifiers of the findings, each once."""
        return list(dict.fromkeys(finding.identifier for finding in self.findings))

    @property
    def indistinguishable(self) -> list[list[str]]:
        """Groups of identifiers that the data cannot tell apart."""
        return [
            [finding.identifier, *finding.rivals] for finding in self.findings if finding.rivals
        ]

    @property
    def confidence(self) -> float:
        """Lowest confidence of the findings; without any, that no alternative is right."""
        nothing = 1.0 / (1.0 + len(self.alternatives))
        return min((finding.confidence for finding in self.findings), default=nothing)

    @property
    def held_out(self) -> ErrorReduction:
        """Errors on held-out data [noise]."""
        return self.evidence.held_out

    @property
    def weighed(self) -> ErrorReduction:
        """Errors on held-out data in the unit of the verdict, noise and reproducibility together.

        It is the noise where the reproducibility is unknown.
        """
        return self.evidence.weighed

    @property
    def reproducibility(self) -> Mapping[str, float]:
        """Column → standard deviation between sessions, beyond noise [its unit]."""
        return self.evidence.reproducibility

    @property
    def bars(self) -> dict[str, float]:
        """Column → scale of the verdict on held-out data [noise]; empty if that is the noise."""
        if self.weighed.unit == self.held_out.unit:
            return {}
        noise = {column: level for column, (_, _, level) in self.held_out.signals.items()}
        return {c: bar / noise[c] for c, (_, _, bar) in self.weighed.signals.items()}

    @property
    def proven(self) -> bool:
        """Whether held-out data prove the findings, be it in part."""
        return self.verdict != "unknown"

    @property
    def withheld(self) -> bool:
        """Whether no effect is named, for a fault of the recordings, and an error remains."""
        return self.verdict == "unknown" and any(warning.blocks for warning in self.checks)

    @property
    def changed(self) -> bool:
        """Whether the final model has more than the calibrated one, proven or not."""
        return bool(self.findings or self.closest)

    @property
    def left_out(self) -> str:
        """Part of the data that the selection leaves out at a time, "recording" or "block"."""
        return "recording" if by_recording(self.recordings) else "block"

    @property
    def leaves_one_out(self) -> bool:
        """Whether each recording was held out in turn, for a model fitted to the others."""
        return not self.held_out_recordings and by_recording(self.recordings)

    @property
    def fitted(self) -> dict[str, float]:
        """Every parameter that was fitted, as the final model has it [its SI unit]."""
        return {name: self.model[name] for name in (*self.calibrated, *self.parameters)}

    def simulate(self, progress: Progress = silent) -> list[BeforeAfter]:
        """Simulate the held-out recordings (all, if none) with the models before and after.

        In the model before, only the uncertain parameters are fitted.
        """
        shown = self.held_out_recordings or self.recordings
        names = [recording.name for recording in shown]
        before, after = (
            {n: v for n, v in values.items() if not recording_of(n)}
            | {n: v for n, v in model.items() if recording_of(n) in names}
            for values, model in (
                ({name: self.before[name] for name in self.calibrated}, self.before),
                (self.fitted, self.model),
            )
        )
        label, parameters = "simulate before and after", self.simulator.parameters
        progress(label, 0, 1)
        answers = self.simulator([before, after])
        progress(label, 1, 1)
        simulated = []
        for values, answer in zip((before, after), answers, strict=True):
            for recording, series in zip(shown, answer, strict=True):
                described = described_values(recording, parameters)
                applied = described | values_for(recording.name, values)
                simulated.append(as_recording(recording, series, applied))
        count = len(shown)
        return list(map(BeforeAfter, shown, simulated[:count], simulated[count:]))

    def write_model(self, path: str | Path) -> Path:
        """Write the recordings' model with the fitted and the known values.

        Values that differ from recording to recording, were set anew for each, or belong to one of
        them, as a slip, are left as the model has them. If nothing is proven, it is the model
        with the closest effects. Intervals that the data determine are in the file too, by which
        `replay_recording` knows not to let a recording's guesses overrule fitted values.

        Args:
            path: MJCF file to write, in an existing folder.

        Raises:
            UnknownNameError: the recordings' model is not an MJCF model, as with a user's own
                simulator, or lacks a fitted parameter.
            TendonError: see `tendon_mj.lab.replay.patch_model`.
        """
        first, names = self.recordings[0], self.simulator.parameters
        fitted = {name: value for name, value in self.fitted.items() if not recording_of(name)}
        entries = {**self.calibrated, **self.parameters}
        intervals = {
            name: (entries[name].low, entries[name].high)
            for name, value in fitted.items()
            if entries[name].determined and entries[name].low <= value <= entries[name].high
        }
        guesses = {n: u.value for n, u in expand(first.uncertain, names).items()}
        known = [expand(recording.known, names) for recording in self.recordings]
        alike = {n: v for n, v in known[0].items() if all(k.get(n) == v for k in known)}
        values = {**alike, **guesses, **fitted}
        return patch_model(first.model, values, path, intervals=intervals)

    def result(self) -> dict[str, Any]:
        """Plain numbers and words, as in `result.json`."""
        return {
            "verdict": self.verdict,
            "proven": self.proven,
            "sentence": self.sentence,
            "warnings": list(self.warnings),
            "checks": [warning.result() for warning in self.checks],
            "effects": self.effects,
            "confidence": self.confidence,
            "findings": [vars(finding) for finding in self.findings],
            "indistinguishable": self.indistinguishable,
            "closest": list(self.closest),
            "alternatives": [alternative.result() for alternative in self.alternatives],
            "excluded": list(self.excluded),
            "ranking": [vars(ranked) for ranked in self.ranking],
            "parameters": {name: vars(value) for name, value in self.parameters.items()},
            "calibrated": {name: vars(value) for name, value in self.calibrated.items()},
            "sessions": {name: vars(spread) for name, spread in self.sessions.items()},
            "reproducibility": dict(self.reproducibility),
            "leaves_one_out": self.leaves_one_out,
            "gap": {
                "train": self.train.result(),
                "held_out": self.held_out.result() | {"regimes": _regimes(*self.proof)},
                "weighed": self.weighed.result(),
            },
            "where": {
                "sentence": self.located.sentence,
                "half_below_Hz": self.located.frequency,
                "regimes": [vars(place) for place in self.located.bins],
                "remaining": self.remaining.sentence,
            },
            "seconds": self.seconds,
        }


def _regimes(before: Located, after: Located) -> list[dict[str, Any]]:
    rms = {(place.regime, place.label): place.rms for place in after.bins}
    regimes = []
    for place in before.bins:
        errors = {"before": place.rms, "after": rms[place.regime, place.label]}
        bin_of = {"regime": place.regime, "label": place.label, "time": place.time}
        regimes.append(bin_of | errors)
    return regimes


def write_before_after(simulated: Sequence[BeforeAfter], folder: Path) -> list[Path]:
    """Write simulations as recordings, ``<k>_<name>_before.csv`` and ``<k>_<name>_after.csv``."""
    return [
        write_recording(recording, folder / f"{k}_{row.measured.name}_{when}.csv")
        for k, row in enumerate(simulated)
        for when, recording in (("before", row.before), ("after", row.after))
    ]
