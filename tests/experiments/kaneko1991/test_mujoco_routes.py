"""The plugin in MuJoCo repeats the sheath alone, and refuses what it cannot simulate."""

import numpy as np
import pytest

from experiments.kaneko1991 import mujoco_routes, routes
from experiments.kaneko1991.loop import tension_sine
from experiments.kaneko1991.paper_tendon import PaperTendon
from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.lab.replay import rollout_named_sensors
from tests.refusals import refusing

TENDON = PaperTendon(friction=0.15, output_stiffness=8e3)


def test_plugin_repeats_the_static_friction_of_the_sheath_alone():
    sticky = PaperTendon(friction=0.1, static_friction=0.3)
    time, load = tension_sine(1.0, 15.0, 20.0, 1.25, 500)
    sheath = routes.sheath_alone(sticky, load, "tension", 20)
    plugin = mujoco_routes.plugin(sticky, time, sheath.input_displacement, 20)
    assert plugin.output_tension == pytest.approx(sheath.output_tension, rel=1e-9)
    assert plugin.input_tension == pytest.approx(sheath.input_tension, rel=1e-9)


def test_an_unstable_simulation_is_refused():
    model = mujoco_routes.plugin_model(TENDON, 64, 5e-3)
    reel = 1e-3 * np.sin(np.arange(2000) * 0.1)
    with refusing(TendonError, "became unstable"):
        rollout_named_sensors(model, reel)


def test_elements_start_from_rest():
    time = np.arange(3) * 0.1
    with refusing(InvalidValueError, "must be T_0"):
        mujoco_routes.mujoco_elements(TENDON, time, time + 25.0, "tension", 4, 1.0, 1.0)
