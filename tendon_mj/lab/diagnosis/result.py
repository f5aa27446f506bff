"""Result of a diagnosis: a verdict, its evidence in numbers, and the final model.

A row of the ranking of candidates.

Recordings beside their simulations by the model before and after a diagnosis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from tendon_mj.lab.data_check import DataWarning
from tendon_mj.lab.diagnosis.data import Spread, by_recording
from tendon_mj.lab.diagnosis.effects.effect import Effect
from tendon_mj.lab.diagnosis.evidence import ErrorReduction, Evidence, Verdict
from tendon_mj.lab.diagnosis.regimes import Located
from tendon_mj.lab.diagnosis.selection import Selection, SelectionContext
from tendon_mj.lab.progress import Progress, silent
from tendon_mj.lab.recordings import Recording, write_recording
from tendon_mj.lab.replay import (
    Simulates,
    as_recording,
    described_values,
    expand,
    patch_model,
    recording_of,
    values_for,
)


@dataclass(frozen=True)
class Value:
    """A fitted parameter and its 95 % interval.

    Attributes:
        value, low, high: estimate and ends of the interval [unit].
        unit: of all three.
        before: value in the model as described [unit].
        determined: whether the data determine it; else ``low`` and ``high`` are its range.
        at_end: whether it is calibrated, and at an end of its range.
    """

    value: float
    low: float
    high: float
    unit: str
    before: float
    determined: bool = True
    at_end: bool = False

    @property
    def suffix(self) -> str:
        """Unit to write after the value; empty for a ratio."""
        return f" {self.unit}" if self.unit not in ("", "-") else ""


@dataclass(frozen=True)
class Finding:
    """An effect that is missing, or a parameter that was wrong.

    Attributes:
        identifier, name, equation: from the catalogue.
        where: elements it is on.
        kind: "missing", or "parameter" for a number that the model has at another value.
        confidence: that it is this one and none of the rivals, 0 … 1.
        rivals: identifiers of effects that the data cannot tell from it.
        elsewhere: elements on which the data cannot tell the same effect from it.
        statement: what was found in words, with the value; see `state_finding`.
        parameter: name of the parameter that is its strength; the first, where it has several.
        recording: the one that it happened in, of an event; else empty.
    """

    identifier: str
    name: str
    equation: str
    where: str
    kind: str
    confidence: float
    rivals: tuple[str, ...]
    elsewhere: tuple[str, ...] = ()
    statement: str = ""
    parameter: str = ""
    recording: str = ""


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Result of a diagnosis.

    Attributes:
        verdict: one of those of the module `tendon_mj.lab.diagnosis.diagnose`.
        sentence: the verdict in words.
        findings: named effects and parameters, in the order of how much they explain. Empty
            unless the verdict is "named", "parameter" or "partly".
        closest: identifiers that explained most where the verdict is "unknown". They are not
            proven; ``parameters``, ``model`` and the errors after are of the model with them.
        excluded: identifiers of effects that were not considered.
        ranking: every candidate for the first finding that explains anything, the fitted ones
            first.
        calibrated: fitted parameters that the recordings call uncertain.
        parameters: fitted parameters of the findings, or of what is closest.
        sessions: parameter → what was set anew for each recording, and its spread.
        reproducibility: column → standard deviation between sessions, beyond noise [its unit].
        train, held_out: errors on training data and on held-out data.
        located, remaining: misfit of the calibrated and of the final model, on training data.
        proof: misfit of both on held-out data.
        before: every parameter → value of the calibrated model.
        model: every parameter → value of the final model. In both, ``<parameter> @ <recording>`` is
            what was set anew for a recording.
        seconds: duration of the diagnosis [s].
        catalogue: identifier → effect, of all that could have been named.
        simulator: of the held-out recordings; where there are none, of all.
        recordings, held_out_recordings: data of the diagnosis; without the second, each of the
            first was held out in turn, or the last quarter of each.
        search: training data and the models that were compared on them, with which
            `suggest_experiment` goes on; None for a diagnosis that `diagnose` did not make.
        evidence: what the verdict was decided by; None likewise.
        warnings: of what may make the result wrong, in whole sentences.
        checks: warnings about the recordings, from before any fit; they are among ``warnings``.
            Where one of them ``blocks``, an effect is named only if it leaves no more than noise.
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
    reproducibility: Mapping[str, float]
    train: ErrorReduction
    held_out: ErrorReduction
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
    evidence: Evidence | None = field(default=None, repr=False)
    warnings: tuple[str, ...] = ()
    checks: tuple[DataWarning, ...] = ()

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
        """Lowest confidence of the findings; 1 where nothing was named."""
        return min((finding.confidence for finding in self.findings), default=1.0)

    @property
    def weighed(self) -> ErrorReduction:
        """Errors on held-out data in the unit of the verdict, noise and reproducibility together.

        It is the noise where nothing is known of the reproducibility.
        """
        return self.evidence.stated if self.evidence else self.held_out

    @property
    def bars(self) -> dict[str, float]:
        """Column → unit of the verdict on held-out data [noise]; empty where it is the noise."""
        if self.weighed.unit == self.held_out.unit:
            return {}
        noise = {column: level for column, (_, _, level) in self.held_out.signals.items()}
        return {c: bar / noise[c] for c, (_, _, bar) in self.weighed.signals.items()}

    @property
    def proven(self) -> bool:
        """Whether held-out data prove what was found, be it in part."""
        return self.verdict != "unknown"

    @property
    def withheld(self) -> bool:
        """Whether no effect is named, for a fault of the recordings, and an error remains."""
        return self.verdict == "unknown" and any(warning.blocks for warning in self.checks)

    @property
    def changed(self) -> bool:
        """Whether the final model has more than what was uncertain fitted, proven or not."""
        return bool(self.findings or self.closest)

    @property
    def left_out(self) -> str:
        """What the selection leaves out one at a time, "recording" or "block"."""
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
        """Simulate the held-out recordings, or all where there are none, before and after.

        Before, only what was uncertain is fitted.
        """
        before = {name: self.before[name] for name in self.calibrated}
        after = {name: value for name, value in self.fitted.items() if not recording_of(name)}
        shown = self.held_out_recordings or self.recordings
        names = [recording.name for recording in shown]
        own = [
            {name: value for name, value in values.items() if recording_of(name) in names}
            for values in (self.before, self.model)
        ]
        return simulate_before_after(
            shown, self.simulator, {**before, **own[0]}, {**after, **own[1]}, progress
        )

    def write_model(self, path: str | Path) -> Path:
        """Write the recordings' model with what was found and what the rig is known to have.

        What is known differently from recording to recording, was set anew for each, or happened in
        one of them, as a slip, is left as the model has it. Where nothing is proven, it is the
        model with what is closest.

        Intervals that the data determine are in the file too, by which `replay_recording` knows
        not to let a recording's guesses overrule what was found.

        Args:
            path: MJCF file to write, in an existing folder.

        Raises:
            UnknownNameError: the recordings' model is no MJCF model, as with a simulator of one's
                own, or does not have a parameter that was found.
            TendonError: see `tendon_mj.lab.replay.patch.patch_model`.
        """
        first, names = self.recordings[0], self.simulator.parameters
        fitted = {name: value for name, value in self.fitted.items() if not recording_of(name)}
        found = {**self.calibrated, **self.parameters}
        intervals = {
            name: (found[name].low, found[name].high)
            for name, value in fitted.items()
            if found[name].determined and found[name].low <= value <= found[name].high
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
                "regimes": [vars(found) for found in self.located.bins],
                "remaining": self.remaining.sentence,
            },
            "seconds": self.seconds,
        }


def _regimes(before: Located, after: Located) -> list[dict[str, Any]]:
    left = {(found.regime, found.label): found.rms for found in after.bins}
    return [
        {
            "regime": found.regime,
            "label": found.label,
            "time": found.time,
            "before": found.rms,
            "after": left[found.regime, found.label],
        }
        for found in before.bins
    ]


@dataclass(frozen=True)
class Ranked:
    """A candidate for the first finding.

    Attributes:
        identifier, where: effect and elements.
        explains: share of the calibrated model's excess χ² that it removes by screening [-].
        left: cross-validated rms error [noise]; None where it was not fitted, as others promised
            more.
        at_end: end of its range at which its strength stands, so that it names nothing [unit].
        unit: of its strength.
    """

    identifier: str
    where: str
    explains: float
    left: float | None
    at_end: float | None = None
    unit: str = ""


_LONGEST_NAME = 200  # bytes


class BeforeAfter(NamedTuple):
    """A recording and two simulations of it.

    Attributes:
        measured: the recording.
        before: by the model with only what was uncertain fitted.
        after: by the final model.
    """

    measured: Recording
    before: Recording
    after: Recording


def simulate_before_after(
    recordings: Sequence[Recording],
    simulator: Simulates,
    before: Mapping[str, float],
    after: Mapping[str, float],
    progress: Progress = silent,
) -> list[BeforeAfter]:
    """Simulate recordings with two sets of parameters.

    Args:
        recordings: those that ``simulator`` simulates.
        simulator: of the model.
        before, after: the parameters that are set.
        progress: called with a label, how much is done, and of how much.
    """
    label = "simulate before and after"
    progress(label, 0, 1)
    answers = simulator([before, after])
    progress(label, 1, 1)
    return [
        BeforeAfter(
            recording,
            as_recording(recording, first, _applied(recording, simulator, before)),
            as_recording(recording, second, _applied(recording, simulator, after)),
        )
        for recording, first, second in zip(recordings, *answers, strict=True)
    ]


def _applied(
    recording: Recording, simulator: Simulates, values: Mapping[str, float]
) -> dict[str, float]:
    """Every parameter that a simulation of the recording was given."""
    return {
        **described_values(recording, simulator.parameters),
        **values_for(recording.name, values),
    }


def write_before_after(simulated: Sequence[BeforeAfter], folder: Path) -> list[Path]:
    """Write simulations as recordings, ``<k>_<name>_before.csv`` and ``<k>_<name>_after.csv``.

    Args:
        simulated: of one diagnosis.
        folder: that exists.

    Returns:
        Paths of the CSVs, whose names are cut where a file's name cannot be so long; the
        description of each lies beside it.
    """
    return [
        write_recording(recording, folder / f"{k}_{_short(row.measured.name)}_{when}.csv")
        for k, row in enumerate(simulated)
        for when, recording in (("before", row.before), ("after", row.after))
    ]


def _short(name: str) -> str:
    """The beginning of a name, as much as leaves room for more in the 255 bytes of a file's."""
    return name.encode()[:_LONGEST_NAME].decode(errors="ignore")
