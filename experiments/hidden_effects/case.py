"""One hidden case: draw the rig, find the strength, record, write it down."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from experiments.hidden_effects import catalogue, excitation
from experiments.hidden_effects.hidden import Hidden
from experiments.hidden_effects.joint_rig import JOINT_EFFECTS, JointRig
from experiments.hidden_effects.rig import Rig
from experiments.hidden_effects.strength import Found, find, projector
from tendon_mj.recordings import Measured, Recording, write_recording

FloatArray = NDArray[np.float64]
R = TypeVar("R", Rig, JointRig)

ROUNDING = 1.0 / 3.0  # of the noise: quantisation of the readings
LEAST_TENSION = 0.05  # of the pretension
NUDGE = 1.01  # by which a parameter changes to see what it does


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What a case is to be.

    Attributes:
        kind: "effect", "pair", "parameter", "nothing", "outside" or "joint".
        names: of what is hidden.
        target: wanted ratio of residual to noise, for each of them [-].
        noise: standard deviation over the range of each measured column [-].
        exclude: effects to take out of the catalogue when diagnosing.
        seed: of all that is drawn.
    """

    kind: str
    names: tuple[str, ...]
    target: float
    noise: float
    exclude: tuple[str, ...]
    seed: tuple[int, ...]


def make_case(plan: Plan, folder: Path) -> dict[str, Any]:
    """Write the recordings of a case and ``case.json``, and return its key."""
    rng = np.random.default_rng(plan.seed)
    if plan.kind == "joint":
        joint = JointRig(**_drawn(JointRig, rng))
        things = [JOINT_EFFECTS[name](rng) for name in plan.names]
        return _make(plan, folder, rng, joint, things, tuple(joint.side.uncertain))
    bench, uncertain = _bench(plan, rng)
    drawn = [_draw(plan.kind, name)(rng) for name in plan.names]
    return _make(plan, folder, rng, bench, drawn, uncertain)


def _make(
    plan: Plan,
    folder: Path,
    rng: np.random.Generator,
    rig: R,
    hidden: Sequence[Hidden[R]],
    uncertain: tuple[str, ...],
) -> dict[str, Any]:
    scale = 0.9 * rig.pretension / rig.side.ranges["pretension"].value * rig.side.travel
    for _ in range(6):
        training: list[FloatArray] = excitation.train(rng, scale)
        held_out: list[FloatArray] = excitation.held_out(rng, scale)
        baseline = rig.run(training, fine=False)
        noise = plan.noise * np.ptp(np.concatenate(baseline, axis=1), axis=1)
        found = [_find(plan, rig, one, training, baseline, noise, uncertain) for one in hidden]
        truth = rig
        for one, strength in zip(hidden, found, strict=True):
            truth = one.apply(truth, strength.strength)
        readings = truth.run([*training, *held_out])
        tensions = [k for k, c in enumerate(rig.side.sensors) if c.endswith("_N")]
        least = float(min(r[tensions].min() for r in readings))
        if least > LEAST_TENSION * rig.pretension:
            break
        scale *= 0.85  # it went slack
    names = [f"train_{k + 1}" for k in range(len(training))]
    names += [f"held_out_{k + 1}" for k in range(len(held_out))]
    folder.mkdir(parents=True, exist_ok=True)
    model = rig.write_model(folder.parent)
    for name, drive, reading in zip(names, [*training, *held_out], readings, strict=True):
        bare = record(rig, model, rng, name, drive, reading, noise)
        stated = {p: rig.side.ranges[n] for n in uncertain for p in rig.side.uncertain[n]}
        recording = dataclasses.replace(bare, known=_known(plan, rig), uncertain=stated)
        write_recording(recording, folder / name)
    public = json.dumps({"exclude": plan.exclude}) + "\n"
    (folder / "case.json").write_text(public, encoding="utf-8")
    true: dict[str, float] = {}
    for one, strength in zip(hidden, found, strict=True):
        true |= one.numbers(truth, strength.strength)
    return {
        "kind": plan.kind,
        "hidden": list(plan.names),
        "exclude": list(plan.exclude),
        "target": plan.target,
        "noise": plan.noise,
        "ratio": [f.ratio for f in found],
        "reached": all(f.reached for f in found),
        "strength": [f.strength for f in found],
        "parameters": true,
        "calibrated": {p: getattr(truth, n) for n in uncertain for p in rig.side.uncertain[n]},
        "least_tension_N": least,
    }


def _draw(kind: str, name: str) -> catalogue.Draw:
    if name == "sheath_friction":
        return catalogue.SHEATH_FRICTION
    if kind == "parameter":
        return catalogue.PARAMETERS[name]
    return (catalogue.EFFECTS | catalogue.STRANGE)[name]


def _drawn(rig: type[Rig] | type[JointRig], rng: np.random.Generator) -> dict[str, Any]:
    return {name: float(rng.uniform(*span)) for name, span in rig.side.drawn.items()}


def _bench(plan: Plan, rng: np.random.Generator) -> tuple[Rig, tuple[str, ...]]:
    """The bench before anything is hidden, and what its recordings call uncertain of it."""
    drawn = _drawn(Rig, rng)
    if plan.names == ("sheath_friction",):
        return Rig(friction=0.0, pretension=drawn["pretension"]), ("pretension",)
    uncertain = list(drawn)
    if plan.kind == "parameter":
        wrong = plan.names[0]
        stated = {"bend_angle": "friction"}.get(wrong, wrong)  # only their product shows
        if stated in drawn:
            uncertain.remove(stated)
            drawn[stated] = getattr(Rig, stated)
    return Rig(**drawn), tuple(uncertain)


def _find(
    plan: Plan,
    rig: R,
    hidden: Hidden[R],
    drives: Sequence[FloatArray],
    baseline: Sequence[FloatArray],
    noise: FloatArray,
    uncertain: tuple[str, ...],
) -> Found:
    """The strength that leaves the plan's ratio once the uncertain numbers are calibrated."""

    def whitened(other: R) -> FloatArray:
        runs = other.run(drives, fine=False)
        return np.concatenate(
            [((a - b) / noise[:, None]).ravel() for a, b in zip(runs, baseline, strict=True)]
        )

    def nudged(name: str) -> FloatArray:
        return whitened(dataclasses.replace(rig, **{name: NUDGE * getattr(rig, name)}))

    left = projector([nudged(name) for name in uncertain])

    def ratio(strength: float) -> float:
        residual = left(whitened(hidden.apply(rig, strength)))
        return float(np.sqrt(np.mean(residual**2)))

    return find(ratio, plan.target, hidden.low, hidden.high, hidden.start)


def record(
    rig: Rig | JointRig,
    model: str,
    rng: np.random.Generator,
    name: str,
    drive: FloatArray,
    reading: FloatArray,
    noise: FloatArray,
) -> Recording:
    """Readings with noise and quantisation, as a recording that knows nothing of its rig."""
    side = rig.side
    columns, measured = {side.drive: drive}, {}
    for (column, sensor), values, sigma in zip(side.sensors.items(), reading, noise, strict=True):
        digit = float(f"{ROUNDING * sigma:.2g}")
        noisy = values + rng.normal(0.0, sigma, len(values))
        columns[column] = np.round(np.round(noisy / digit) * digit, 9)
        measured[column] = Measured(sensor, float(f"{sigma:.4g}"))
    return Recording(
        name=name,
        model=model,
        source="made by tendon-mj, not measured: experiments/hidden_effects; Apache-2.0",
        time=excitation.clock(len(drive) / rig.rate, rig.rate)[: len(drive)],
        columns=columns,
        drive={side.drive: side.actuator},
        measured=measured,
    )


def _known(plan: Plan, rig: Rig | JointRig) -> dict[str, float]:
    """What the rig's maker measured: never a number that is wrong, or that the effect is."""
    known = dict(rig.side.known)
    if plan.kind == "parameter":
        known.pop(f"sheath.{plan.names[0]}", None)
    if plan.names in (("sheath_friction",), ("bend_angle",)):
        known["sheath.friction"] = rig.friction
    return known
