"""Report of the study: result.json, summary and table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from experiments.positioning_system import published
from experiments.positioning_system.descriptions import NAMES
from experiments.positioning_system.study import TOLD, Described, Study

# parameter → name, unit, published value
NUMBERS = {
    "screw.damping": ("viscous friction", "N s/m", published.VISCOUS),
    "screw.frictionloss": ("dry friction", "N", published.COULOMB),
    "carriage.mass": ("mass", "kg", published.MASS),
}
MODELS = {
    "before": "frictionless, mass fitted",
    "after": "found",
    "published": "published",
    "sysid": "`mujoco.sysid`, mass alone",
    TOLD: "`mujoco.sysid`, told the structure",
}


def result(study: Study) -> dict[str, object]:
    """Nested dictionary of numbers in SI units."""
    position, force = study.measurement.reproducibility()
    stiffness, damping, left = study.measurement.servo_gains()
    return {
        "published": {
            "mass_kg": published.MASS,
            "viscous_Ns_per_m": published.VISCOUS,
            "coulomb_N": published.COULOMB,
            "offset_N": published.OFFSET,
            "servo": {
                "kp_N_per_m": published.SERVO_STIFFNESS,
                "kv_Ns_per_m": published.SERVO_DAMPING,
            },
        },
        "servo": {"kp_N_per_m": stiffness, "kv_Ns_per_m": damping, "left_N": left},
        "reproducibility": {"position_m": position, "motor_force_N": force},
        "described": {
            name: {
                "diagnosis": one.diagnosis.result(),
                "held_out": one.errors,
                "sysid": [fit.result() for fit in one.sysid] if one.sysid else None,
            }
            for name, one in study.described.items()
        },
    }


def summary(study: Study) -> Iterator[str]:
    """Yield the lines."""
    for name, one in study.described.items():
        diagnosis = one.diagnosis
        numbers = ", ".join(
            f"{what} {diagnosis.model[parameter]:.4g} {unit} (published {told:g})"
            for parameter, (what, unit, told) in NUMBERS.items()
        )
        worst = max(
            one.errors["after"][c] / one.errors["published"][c] for c in one.errors["after"]
        )
        yield (
            f"{NAMES[name]}: {diagnosis.verdict}, {', '.join(diagnosis.effects)}; {numbers}, offset"
            f" {offset(diagnosis.model):.2f} N ({published.OFFSET:g}); held-out error {worst:.2f}"
            f" times the published model's (asked {published.ERROR_RATIO:g})"
        )


def table(study: Study) -> str:
    """The whole page."""
    return "\n".join([*_numbers(study), "", *_errors(study), "", *_sentences(study), ""])


def offset(parameters: Mapping[str, float]) -> float:
    """Offset of the motor's force [N], wherever the model has it."""
    mass = parameters["carriage.mass"]
    return (
        parameters.get("force.offset", 0.0)
        - parameters.get("motor.command_offset", 0.0)
        - mass * parameters.get("gravity.x", 0.0)
    )


def _numbers(study: Study) -> Iterator[str]:
    yield (
        "| description | verdict | findings | "
        + " | ".join(f"{name} [{unit}]" for name, unit, _ in NUMBERS.values())
        + " | offset [N] |"
    )
    yield "|---" * (4 + len(NUMBERS)) + "|"
    for name, one in study.described.items():
        findings = ", ".join(
            f"`{f.identifier}`" + (f" (or `{'`, `'.join(f.rivals)}`)" if f.rivals else "")
            for f in one.diagnosis.findings
        )
        cells = [_value(one, parameter) for parameter in NUMBERS]
        given = f"{offset(one.diagnosis.model):.2f}"
        verdict = one.diagnosis.verdict
        yield f"| {NAMES[name]} | `{verdict}` | {findings} | {' | '.join(cells)} | {given} |"
        if one.sysid:
            values = {name: value for name, (value, _, _) in one.sysid[1].values.items()}
            cells = [f"{values[parameter]:.4g}" for parameter in NUMBERS]
            given = f"{offset(values):.2f}"
            yield f"| … {MODELS[TOLD]} | – | – | {' | '.join(cells)} | {given} |"
    told = " | ".join(f"{value:g}" for *_, value in NUMBERS.values())
    yield f"| published | – | – | {told} | {published.OFFSET:g} |"


def _value(one: Described, parameter: str) -> str:
    fitted = {**one.diagnosis.parameters, **one.diagnosis.calibrated}.get(parameter)
    if fitted is None:
        return "–"
    off = fitted.value / NUMBERS[parameter][2] - 1.0
    return f"{fitted.value:.4g} ({fitted.low:.4g} … {fitted.high:.4g}), {off:+.1%}"


def _errors(study: Study) -> Iterator[str]:
    units = [
        (name, column) for name, one in study.described.items() for column in one.recording.measured
    ]
    heads = [f"{name}: {signal(name, column)}" for name, column in units]
    yield "| held-out error, rms | " + " | ".join(heads) + " |"
    yield "|---" * (1 + len(units)) + "|"
    for model, label in MODELS.items():
        cells = []
        for name, column in units:
            errors = study.described[name].errors
            if model not in errors:
                cells.append("–")
                continue
            ratio = errors[model][column] / errors["published"][column]
            shown = scale(name, column) * errors[model][column]
            cells.append(f"{shown:.3g} ({ratio:.3g})")
        yield f"| {label} | {' | '.join(cells)} |"


def signal(name: str, column: str) -> str:
    """Measured column and the unit in which its errors are written."""
    unit = "N" if column == "motor_force_N" else "mm" if name == "force" else "µm"
    return f"{column.split('_')[0] if column == 'position_m' else 'force'} [{unit}]"


def scale(name: str, column: str) -> float:
    """Factor from SI to that unit."""
    return 1.0 if column == "motor_force_N" else 1e3 if name == "force" else 1e6


def _sentences(study: Study) -> Iterator[str]:
    for name, one in study.described.items():
        yield f"- {NAMES[name]} ({one.diagnosis.seconds:.0f} s): {one.diagnosis.sentence}"
