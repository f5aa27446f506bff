"""`tendon-mj init`, `check` and `replay`: a description, a check and a simulation of recordings."""

from __future__ import annotations

import copy
import math
import warnings
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import mujoco
import tyro
from rich.progress import track

from tendon_mj.cli.options import OutFile, Recordings, Repeated, flat, given_files
from tendon_mj.cli.output import Output, console, print_table, print_warnings
from tendon_mj.errors import InvalidValueError, RecordingError, TendonWarning
from tendon_mj.lab.data_check import (
    Checked,
    check_recording,
    doubt_of_signals,
    timing_warnings,
)
from tendon_mj.lab.noise import noise_levels
from tendon_mj.lab.parameter_names import expand, matching
from tendon_mj.lab.recordings import Recording, read_recording, tables_in, write_recording
from tendon_mj.lab.replay import (
    Adjustable,
    Misfit,
    Parameter,
    load_recorded,
    read_intervals,
    replay_error,
    replay_recording,
    stated_values,
)
from tendon_mj.lab.units import column_unit, plain, quantity
from tendon_mj.models import load_model
from tendon_mj.show import init as write_description
from tendon_mj.show import replay_figure

ValuesOf = Literal["description", "model"]
DESCRIBED, KEPT = "as described", "with the model's values"
_WITHOUT = "friction 0"


class _Variant(NamedTuple):
    """A simulation: its model, and parameters in place of the stated ones."""

    model: str
    changed: Mapping[str, float]


def init(model: tyro.conf.Positional[str], out: OutFile[Path | None] = None) -> Path:
    """Write a description of recordings of a model: all its sensors and actuators, to be filled in.

    Args:
        model: MJCF file, or a model of the package: bench, joint, finger, finger_spring.
        out: TOML file to write. By default it has the model's name and is in the current folder.
            An existing file is not overwritten.

    Example:
        tendon-mj init my_rig.xml --out pull.toml
    """
    path, compiled = write_description(model, out), load_model(model)
    console.print(
        f"Wrote {path}, to be filled in: actuators {compiled.nactuator}, sensors"
        f" {compiled.nsensor}; then: tendon-mj check RECORDING.csv --description {path}"
    )
    return path


def check(
    recordings: Recordings,
    out: Path = Path("out/check"),
    description: Path | None = None,
    model: str | None = None,
    values_of: ValuesOf | None = None,
    settle: float | None = None,
) -> dict[str, object]:
    """Draw recordings over their model before anything is fitted, and warn of faults.

    Args:
        recordings: CSV, Parquet or MCAP files, bags of ROS, episodes of LeRobot
            (DATASET/episode_3), or folders of them. Each has its TOML file next to it, unless
            --description gives one for all.
        out: Folder for result.json and a picture of each recording.
        description: TOML file that describes the columns of all recordings.
        model: Model to simulate in place of the recordings' own: a name or an MJCF file.
        values_of: Values to use where the description and the model differ. By default a --model
            keeps its own in place of [uncertain], and of [known] if it differs there from the
            recordings' own model; so does any model what a diagnosis fitted and wrote into it.
            Otherwise the description's. Columns (commands, sensors) are always as described,
            unless the model states them.
        settle: Time before the first sample in which the model comes to the first drive value. By
            default the description's.

    Example:
        tendon-mj check pull.csv
    """
    recordings = tuple(table for path in recordings for table in tables_in(path))
    output = Output(out, given=given_files(recordings, description, [model]))
    if not recordings:
        raise RecordingError("check needs at least one recording")
    read, of_tables = _read_all(recordings, description)
    shared = load_model(model) if model else None
    compiled = [shared or load_recorded(one) for one in read]
    described = [_as_described(values_of, *pair) for pair in zip(read, compiled, strict=True)]
    for text in of_tables:
        console.print(f"warning: {text}")
    pairs = list(zip(read, described, strict=True))
    checked = [
        check_recording(recording, shared, described=stated, settle=settle)
        for recording, stated in track(pairs, "simulate", console=console)
    ]
    for one in checked:
        if one.simulated is not None and one.recording.measured:
            figure = replay_figure(one.recording, {"model as stated": one.simulated})
            output.figure(one.recording.name, figure)
        _print_errors(one.recording, _misfits(one))
        print_warnings(one.warnings)
    if doubt := doubt_of_signals(read):
        console.print(doubt)
    result: dict[str, object] = {
        "recordings": [_checked(one) for one in checked],
        "table_warnings": of_tables,
    }
    return output.finish(result, _check_sentence(checked, len(of_tables)))


def replay(
    recording: tyro.conf.Positional[Path],
    out: Path = Path("out/replay"),
    description: Path | None = None,
    model: Annotated[Repeated[str], tyro.conf.arg(metavar="MODEL [MODEL ...]")] = (),
    values_of: ValuesOf | None = None,
    settle: float | None = None,
    change: Repeated[str] = (),
) -> dict[str, object]:
    """Simulate a recording with and without friction, or on several models, and draw all with it.

    Args:
        recording: CSV, Parquet or MCAP file, bag of ROS or episode of LeRobot with its TOML file
            next to it, unless --description gives another.
        out: Folder for result.json, the simulated recordings and the picture.
        description: TOML file that describes the columns of the recording.
        model: Models to simulate in place of the recording's own: names or MJCF files. Several are
            compared, each with its own physics and without a variant of friction 0.
        values_of: Values to use where the description and the model differ. By default a --model
            keeps its own in place of [uncertain], and of [known] if it differs there from the
            recording's own model; so does any model what a diagnosis fitted and wrote into it.
            Otherwise the description's. Columns (commands, sensors) are always as described,
            unless the model states them.
        settle: Time before the first sample in which the model comes to the first drive value. By
            default the description's.
        change: More variants to simulate, of one change or several, such as "*.friction=0.1".

    Example:
        tendon-mj replay rig.csv --change "*.friction=0.1"
    """
    models = flat(model)
    writes = ("simulated_[0-9]*.csv", "simulated_[0-9]*.toml")
    given = given_files([recording], description, models or [None])
    output = Output(out, writes=writes, given=given)
    measured = read_recording(recording, description)
    if not measured.measured:
        raise RecordingError(f"{recording}: no column is [measured], so nothing can be compared")
    print_warnings(timing_warnings(measured))
    compiled = {name: load_model(name) for name in models}
    own = {} if models else {measured.model: load_recorded(measured)}
    variants, described = dict[str, _Variant](), dict[str, bool | None]()
    parameters = dict[str, Mapping[str, Parameter]]()  # of each model
    for name, one in (compiled or own).items():
        described[name] = _as_described(values_of, measured, one)
        keeps = not described[name] and bool(read_intervals(one) or values_of)
        label = name if len(models) > 1 else KEPT if keeps else DESCRIBED
        variants[label] = _Variant(name, {})
        known = parameters[name] = Adjustable(copy.copy(one)).parameters()
        frictions = [parameter for parameter in known if parameter.endswith(".friction")]
        if frictions and len(models) < 2:
            variants[_WITHOUT] = _Variant(name, dict.fromkeys(frictions, 0.0))
        for text in flat(change):
            longer = f"{name}, {text}" if len(models) > 1 else text
            variants[longer] = _Variant(name, parse_change(text, known, "--change"))
    differ = _differences(parameters) if values_of is None else set[str]()
    simulated, warned = dict[str, Recording](), dict[str, None]()  # in order
    for label, variant in track(variants.items(), "replay", console=console):
        name = variant.model
        stated = expand({**measured.session, **measured.known}, parameters[name])
        if kept := sorted(differ & stated.keys()):
            text = f"the models differ in {', '.join(kept)}: each keeps its own values"
            warned[f"{text}, and not the description's"] = None
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            simulated[label] = replay_recording(
                _without(measured, kept, parameters[name]),
                compiled.get(name),
                parameters=variant.changed,
                described=described[name],
                settle=settle,
            )
        warned |= dict.fromkeys(f"warning: {name}: {one.message}" for one in caught)
        if name in compiled:
            applied = {n: v for n, v in simulated[label].known.items() if n not in variant.changed}
            warned |= dict.fromkeys(_changes(name, applied, parameters[name]))
            simulated[label] = replace(simulated[label], model=name)
    for text in warned:
        console.print(text)
    errors = {label: replay_error(measured, answer) for label, answer in simulated.items()}
    noise = noise_levels(measured)
    over_noise = {
        label: math.sqrt(sum((e.rmse / noise[c]) ** 2 for c, e in of.items()) / len(of))
        for label, of in errors.items()
    }
    for k, answer in enumerate(simulated.values()):
        output.add(write_recording(answer, out / f"simulated_{k}.csv"))
    columns = [measured.written(column) for column in measured.measured]
    rows = []
    for label, of in errors.items():
        texts = [f"{_rms_text(e, c)}{e.of_range}" for c, e in of.items()]
        rows.append([label, *texts, plain(over_noise[label])])
    print_table(["rms error", *columns, "all [noise]"], rows)
    result: dict[str, object] = {
        label: {c: {"rmse": e.rmse, "share_of_range": e.share_of_range} for c, e in of.items()}
        for label, of in errors.items()
    }
    output.figure("replay", replay_figure(measured, simulated))
    replayed = {"recording": str(recording), "source": measured.source}
    output.result({**replayed, "rmse": result, "over_noise": over_noise})
    ending = (
        _comparison_sentence(over_noise)
        if len(models) > 1
        else _replay_sentence(measured, errors, next(iter(errors)))
    )
    output.close(ending)
    return result


def _as_described(
    values_of: ValuesOf | None, recording: Recording, model: mujoco.MjModel
) -> bool | None:
    """``values_of`` as ``described`` of `replay_recording`.

    If the values of the description and those of a diagnosis that wrote the model differ, the
    console reports which are used.
    """
    fitted = read_intervals(model)
    if fitted and values_of != "model" and (recording.known or recording.uncertain):
        name, first = recording.name, next(iter(fitted))
        console.print(
            f"{name}: the values that a diagnosis wrote into the model, such as {first}, are kept"
            " over the description's (--values-of description overrules them)"
            if values_of is None
            else f"warning: {name}: the description overrules the values that a diagnosis wrote"
            f" into the model, such as {first}; without --values-of description they are kept"
        )
    if values_of == "model":
        parameters = Adjustable(copy.copy(model)).parameters()
        said, used = (stated_values(recording, model, parameters, d) for d in (True, False))
        if unused := sorted(said.keys() - used.keys()):
            console.print(
                f"{recording.name}: the model's values are used, and not the description's, of"
                f" {', '.join(unused)}"
            )
    return None if values_of is None else values_of == "description"


def _read_all(paths: Sequence[Path], description: Path | None) -> tuple[list[Recording], list[str]]:
    """The recordings, with numbers where they share a name, and the warnings about their tables."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", TendonWarning)
        read = [read_recording(path, description) for path in paths]
    if len({one.name for one in read}) < len(read):
        read = [replace(one, name=f"{k}_{one.name}") for k, one in enumerate(read)]
    return read, [str(one.message) for one in caught if issubclass(one.category, TendonWarning)]


def _misfits(one: Checked) -> dict[str, Misfit]:
    return {} if one.simulated is None else replay_error(one.recording, one.simulated)


def _print_errors(recording: Recording, errors: Mapping[str, Misfit]) -> None:
    for column, error in errors.items():
        console.print(
            f"{recording.name}: {recording.written(column)} rms error"
            f" {_rms_text(error, column)}{error.of_range}"
        )


def _rms_text(error: Misfit, column: str) -> str:
    return quantity(error.rmse, column_unit(column))


def _checked(one: Checked) -> dict[str, object]:
    errors = _misfits(one)
    return {
        "name": one.recording.name,
        "source": one.recording.source,
        "model": one.recording.model,
        "samples": int(one.recording.time.size),
        "simulated": one.simulated is not None,
        "rmse": {column: error.rmse for column, error in errors.items()},
        "share_of_range": {column: error.share_of_range for column, error in errors.items()},
        "warnings": [warning.result() for warning in one.warnings],
    }


def _check_sentence(checked: Sequence[Checked], of_tables: int) -> str:
    count, recordings = of_tables + sum(len(one.warnings) for one in checked), len(checked)
    of = "1 recording" if recordings == 1 else f"{recordings} recordings"
    if not count:
        shares = [e.share_of_range for one in checked for e in _misfits(one).values()]
        shares = [share for share in shares if math.isfinite(share)]
        off = f"; the model is off by up to {max(shares):.0%} of a column's range" if shares else ""
        return f"Checked {of}: no faults found{off}. tendon-mj diagnose explains the rest."
    plural = "1 warning" if count == 1 else f"{count} warnings"
    return f"Checked {of}: {plural}. A diagnosis would take such faults for properties of the rig."


def _replay_sentence(
    measured: Recording, errors: Mapping[str, Mapping[str, Misfit]], stated: str
) -> str:
    """The error of every column, as stated and without friction."""
    parts = []
    for column in measured.measured:
        part = f"{measured.written(column)} by {_rms_text(errors[stated][column], column)}"
        if _WITHOUT in errors:
            part += f" (without friction {_rms_text(errors[_WITHOUT][column], column)})"
        parts.append(part)
    return f"{stated.capitalize()}, the simulation misses {', '.join(parts)}, rms."


def _differences(parameters: Mapping[str, Mapping[str, Parameter]]) -> set[str]:
    """Parameters that several models state differently."""
    first, *others = parameters.values()
    return {
        name
        for other in others
        for name in first.keys() & other.keys()
        if first[name].value != other[name].value
        and not (first[name].is_plain(name) or other[name].is_plain(name))
    }


def _without(recording: Recording, differ: Collection[str], names: Collection[str]) -> Recording:
    """A recording that states none of these parameters as known or of its session."""
    if not differ:
        return recording
    known, session = expand(recording.known, names), expand(recording.session, names)
    return replace(
        recording,
        known={name: value for name, value in known.items() if name not in differ},
        session={name: value for name, value in session.items() if name not in differ},
    )


def _changes(
    model: str, applied: Mapping[str, float], parameters: Mapping[str, Parameter]
) -> list[str]:
    """A sentence on what the description changes of a model's physics; none if nothing."""
    written = {
        name: (quantity(value, of.unit), quantity(of.value, of.unit))
        for name, value in applied.items()
        if not (of := parameters[name]).is_plain(name)
    }
    listed = [f"{n} = {new} (model: {old})" for n, (new, old) in written.items() if new != old]
    return [f"{model}: the description sets {', '.join(listed)}"] if listed else []


def _comparison_sentence(over_noise: Mapping[str, float]) -> str:
    """The error of every variant in units of the noise, the smallest first."""
    ranked = sorted(over_noise.items(), key=lambda one: one[1])
    parts = [f"{label} by {plain(times)}" for label, times in ranked]
    return f"The simulations miss the recording by this many times its noise: {', '.join(parts)}."


def parse_change(text: str, known: Collection[str], option: str) -> dict[str, float]:
    """Parameters of ``name=value,…``; a pattern means all that it matches; a plain name wins."""
    plain: dict[str, float] = {}
    wild: dict[str, float] = {}
    for part in text.split(","):
        name, equals, value = part.rpartition("=")
        try:
            number = float(value)
        except ValueError:
            equals = ""
        if not equals:
            raise InvalidValueError(f"{option} {text!r}: {part!r} is not like name=value")
        if not math.isfinite(number):
            raise InvalidValueError(f"{option} {text!r}: {part!r} is not finite; give a number")
        names = matching(name.strip(), known, f"{option} {text!r}")
        chosen = plain if names == [name.strip()] else wild
        for one in names:
            if chosen.setdefault(one, number) != number:
                raise InvalidValueError(
                    f"{option} {text!r}: {one} is given {chosen[one]:g} and {number:g}; for two"
                    f" variants write them apart: {option} a=1 a=2"
                )
    return wild | plain
