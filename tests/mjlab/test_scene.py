"""Friction goes into the scene of any task, after what mjlab and the task put there."""

import mujoco
import numpy as np
import pytest

from tests.refusals import refusing

pytest.importorskip("mjlab", reason="the extra `mjlab` is not installed")
import mjlab.sim.sim
import mujoco_warp
import torch
from mjlab.actuator import BuiltinMotorActuatorCfg
from mjlab.actuator.actuator import TransmissionType
from mjlab.entity import EntityArticulationInfoCfg, EntityCfg
from mjlab.envs import ManagerBasedRlEnv, ManagerBasedRlEnvCfg, mdp
from mjlab.managers.event_manager import EventTermCfg
from mjlab.managers.observation_manager import ObservationGroupCfg, ObservationTermCfg
from mjlab.managers.scene_entity_config import SceneEntityCfg
from mjlab.scene import SceneCfg

import tendon_mj.mjlab
import tendon_mj.warp as tw
from tests.test_snippets import FINGER

PATH = FINGER.replace(' stiffness="2000"', "").format("")
MOTOR = BuiltinMotorActuatorCfg(
    target_names_expr=("flexor",), transmission_type=TransmissionType.TENDON, effort_limit=20.0
)


def task(spec_fn=None, finger=lambda: mujoco.MjSpec.from_string(PATH)):
    """Configuration of a task whose motor mjlab adds to the finger."""
    flexor = SceneEntityCfg("robot", tendon_names=("flex.*",))
    tension = ObservationTermCfg(func=tw.tension, params={"asset_cfg": flexor, "end": "output"})
    draw = {"ranges": {"friction": (0.1, 0.3)}, "asset_cfg": flexor}
    return ManagerBasedRlEnvCfg(
        scene=SceneCfg(
            num_envs=3,
            spec_fn=spec_fn,
            entities={
                "robot": EntityCfg(
                    spec_fn=finger, articulation=EntityArticulationInfoCfg(actuators=(MOTOR,))
                )
            },
        ),
        observations={"actor": ObservationGroupCfg({"tension": tension})},
        actions={
            "pull": mdp.TendonEffortActionCfg(entity_name="robot", actuator_names=("flexor",))
        },
        events={"friction": EventTermCfg(func=tw.draw_parameters, mode="reset", params=draw)},
        decimation=2,
    )


@pytest.mark.filterwarnings("ignore:add_friction. a cable cannot push")
def test_friction_comes_after_the_task_and_its_tensions_are_observed(monkeypatch):
    monkeypatch.setattr(mjlab.sim.sim, "mjwarp", mujoco_warp)  # as before the first scene
    seen = []
    cfg = task(spec_fn=lambda spec: seen.append([motor.name for motor in spec.actuators]))
    assert tendon_mj.mjlab.add_friction(cfg, "robot/*", friction=0.1) is cfg
    assert mjlab.sim.sim.mjwarp is mujoco_warp
    env = ManagerBasedRlEnv(cfg, "cpu")
    assert seen == [["robot/flexor"]]
    env.reset()
    for _ in range(3):
        observed, *_ = env.step(torch.full((3, 1), -10.0))
    friction = tw.sheaths_of(env.sim.wp_data).parameters["friction"].numpy()[:, 0]
    arrives = observed["actor"].numpy()[:, 0]
    assert np.unique(friction).size == 3
    assert ((arrives > 0.0) & (arrives < 10.0)).all()
    np.testing.assert_array_equal(np.argsort(arrives), np.argsort(friction)[::-1])


def test_friction_in_an_entity_is_too_early_for_its_motor_and_the_message_says_where():
    def finger():
        return tendon_mj.add_friction(mujoco.MjSpec.from_string(PATH), "flexor", friction=0.1)

    with refusing(tendon_mj.TendonError, "flexor", "SceneCfg.spec_fn"):
        ManagerBasedRlEnv(task(finger=finger), "cpu")
