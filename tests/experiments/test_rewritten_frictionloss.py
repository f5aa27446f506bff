"""A frictionloss rewritten in every step is a sheath on one joint, and is none on a soft cable."""

import json
import math
from functools import cache, partial

import numpy as np
import pytest

from experiments.command import run_experiment
from experiments.rewritten_frictionloss import (
    bends,
    cable_strokes,
    compare_motion,
    joint_spec,
    rewritten_frictionloss,
)
from tendon_mj import theory, view_sheath
from tendon_mj.models import Bench
from tests.rigs import compiled, simulated, two_links

BENCH = Bench()
WOUND = BENCH.axial_stiffness / BENCH.length  # K_w [N/m]


@cache
def moved(timestep):
    return compare_motion(partial(joint_spec, timestep), duration=2.0)


def off(timestep, variant):
    """Largest difference of the angle over its travel."""
    return moved(timestep).differences[variant].largest / moved(timestep).travel


def test_on_one_joint_behind_one_bend_it_moves_as_a_sheath_does():
    assert off(1e-3, "from the present state") < 1e-3
    assert off(1e-3, "without friction") > 0.1
    assert off(1e-3, "default solver settings") > 0.01, "a soft constraint creeps"


@pytest.mark.parametrize("variant", ["from the present state", "from the step before"])
def test_what_is_left_of_the_difference_vanishes_with_the_step(variant):
    assert off(2.5e-4, variant) < 0.4 * off(1e-3, variant)


@pytest.mark.parametrize("rewritten", [False, True])
def test_on_an_elastic_cable_it_has_another_stiffness_than_a_sheath_and_loses_twice_the_motion(
    rewritten,
):
    cable = cable_strokes(BENCH, rewritten=rewritten)
    for stroke, lam in ((cable.winding, BENCH.exponent), (cable.paying_out, -BENCH.exponent)):
        law = theory.apparent_stiffness(lam, BENCH.axial_stiffness, BENCH.length)
        lumped = WOUND * math.exp(-lam)
        assert stroke.stiffness == pytest.approx(lumped if rewritten else law, rel=0.02)
        held = theory.reversal_backlash(
            BENCH.exponent, stroke.held, BENCH.axial_stiffness, BENCH.length
        )
        twice = 2.0 * stroke.held * math.sinh(BENCH.exponent) / WOUND
        assert stroke.lost == pytest.approx(twice if rewritten else held, rel=0.1)


def test_the_bend_of_a_path_over_sites_and_geoms_is_that_of_a_sheath():
    law = {"friction": 0, "guides": 10, "arc_guides": 4}
    text = two_links("a b wheel@s c ball@t e", law=law, actuator='<motor name="pull" tendon="t"/>')
    model = compiled(text)
    data = simulated(model, qpos=np.array([0.3, 0.5, 0.0, 0.0]))
    assert bends(model, data)[0] == pytest.approx(view_sheath(model, data, "t").bend_angle.sum())


def test_the_command_writes_its_results_without_a_hand_too(tmp_path, monkeypatch, capsys):
    monkeypatch.delenv("TENDON_MJ_MODELS", raising=False)
    out = ["--out", str(tmp_path), "--rounds", "1"]
    assert run_experiment(rewritten_frictionloss, "rewritten_frictionloss", out) == 0
    result = json.loads((tmp_path / "result.json").read_text())
    assert [*result["motion_deg"]] == [*result["cost_s"]] == ["joint"]
    assert "K_ap" in capsys.readouterr().out
