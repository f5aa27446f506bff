"""Servos with cables: the simulation by fronts of slip, its laws, its agreement with a model."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from experiments.servos.simulation import Servo, simulate
from experiments.servos.suite import EFFECTS, make_case, summary
from tendon_mj import read_recording, replay_recording
from tendon_mj.lab.data_check import check_recording

RIG = Servo(
    kp=3.0,
    kv=0.1,
    efficiency=0.8,
    armature=0.002,
    friction=0.1,
    bend=3.0,
    length=0.5,
    axial_stiffness=8e3,
    pretension=25.0,
    radius=0.01,
    mass=0.1,
    centre_of_mass=0.1,
    inertia=0.0015,
    damping=0.01,
)


def test_a_servo_lifts_with_what_its_gear_and_its_cables_lose_and_holds_with_less() -> None:
    """Under a pretension P two cables lose 2Pμφ r, and the gear 1/η of what it passes on."""
    time = np.arange(0.0, 30.0, 0.02)
    goal = np.radians(40.0) * np.interp(time, [0.0, 14.0, 16.0, 30.0], [0.0, 1.0, 1.0, 0.0])
    _, torque, angle = simulate(RIG, goal, 0.02).T
    load = RIG.mass * 9.81 * RIG.centre_of_mass * np.sin(angle)
    lost = 2.0 * RIG.pretension * RIG.friction * RIG.bend * RIG.radius
    back = 2.0 - 1.0 / RIG.efficiency
    lifting, lowering = (np.abs(time - at) < 2.0 for at in (11.0, 24.0))
    lifted = (load + lost) / RIG.efficiency
    assert torque[lifting] == pytest.approx(lifted[lifting], rel=0.06)
    loads = load - lost  # below 0 the motor has to push the joint down
    lowered = np.where(loads > 0.0, loads * back, loads / RIG.efficiency)
    assert torque[lowering] == pytest.approx(lowered[lowering], abs=0.01)


@pytest.mark.parametrize("hidden", EFFECTS)
def test_a_replay_with_the_true_numbers_leaves_little_but_the_noise(
    hidden: str, tmp_path: Path
) -> None:
    truth = make_case(tmp_path, list(EFFECTS).index(hidden), "all")
    recording = read_recording(tmp_path / "train.csv", tmp_path / "joint.toml")
    values = {
        "servo.kp": truth["kp"],
        "joint_gear_sheath.gear_friction": 1.0 / truth["efficiency"] - 1.0,
        "joint_motor.armature": truth["armature"],
        "motor_torque.scale": truth["scale"],
    }
    for cable in ("joint_cable_sheath", "joint_cable_back_sheath"):
        values |= {f"{cable}.{name}": truth[name] for name in ("friction", "pretension")}
        values[f"{cable}.reel_play"] = truth["play"] / truth["radius"]
    replayed = replay_recording(recording, parameters=values)
    for column, measured in recording.measured.items():
        read = recording.columns[column]
        beyond_noise = np.mean((replayed.columns[column] - read) ** 2) - measured.noise**2
        assert beyond_noise < (0.004 * np.ptp(read)) ** 2


def test_the_description_of_the_page_is_one_of_these_rigs(tmp_path: Path) -> None:
    make_case(tmp_path, 6, "all")
    page = Path(__file__).parents[2] / "docs" / "no_tendons.md"
    (described,) = re.findall(r"```toml\n(.*?)```", page.read_text("utf-8"), re.S)
    (tmp_path / "joint.toml").write_text(described, encoding="utf-8")
    recording = read_recording(tmp_path / "train.csv", tmp_path / "joint.toml")
    assert check_recording(recording).warnings == ()


def test_a_summary_counts_what_was_named() -> None:
    cases = [
        {"hidden": "gear", "effects": ["gear_friction", "creep"], "verdict": "named"},
        {"hidden": "gear", "effects": [], "verdict": "unknown"},
        {"hidden": "nothing", "effects": [], "verdict": "nothing missing"},
    ]
    lines = summary(cases).splitlines()
    assert "gear: 1 of 2 right; wrong names ['creep']; named, unknown" in lines
    assert "nothing: 1 of 1 right; wrong names []; nothing missing" in lines
