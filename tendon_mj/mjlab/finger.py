"""Task of mjlab: a finger follows a flexion through sheaths whose friction nobody tells it."""

from __future__ import annotations

import math
from typing import Any

import mjlab.sim.sim
import mujoco
import torch
from mjlab.actuator.xml_actuator import XmlActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg, EntityCfg
from mjlab.envs import ManagerBasedRlEnvCfg, mdp
from mjlab.managers.event_manager import EventTermCfg
from mjlab.managers.observation_manager import ObservationGroupCfg, ObservationTermCfg
from mjlab.managers.reward_manager import RewardTermCfg
from mjlab.managers.scene_entity_config import SceneEntityCfg
from mjlab.managers.termination_manager import TerminationTermCfg
from mjlab.scene import SceneCfg
from mjlab.sim import MujocoCfg, SimulationCfg
from mjlab.viewer import ViewerConfig

from tendon_mj.models import JOINTS, TENDONS, Finger, build_finger
from tendon_mj.warp import draw_parameters, take_sheaths, tension

_FINGER = Finger()
_MOTORS = tuple(f"{tendon}_motor" for tendon in TENDONS)
_PERIOD = 2.0  # of the flexion [s]
_FLEXION = 1.0  # its mean and amplitude, of the three joints together [rad]
_TOLERANCE = 0.2  # error of flexion at which the reward is 1/e [rad]


def target_flexion(env: Any) -> Any:
    """(worlds, 1) flexion of the three joints together that is to be reached now [rad]."""
    time = env.episode_length_buf[:, None] * env.step_dt
    return _FLEXION * (1.0 - torch.cos(2.0 * math.pi / _PERIOD * time))


def following(env: Any, asset_cfg: SceneEntityCfg) -> Any:
    """(worlds,) reward between 0 and 1 of a flexion that is near its target."""
    angles = env.scene[asset_cfg.name].data.joint_pos[:, asset_cfg.joint_ids]
    error = angles.sum(dim=1) - target_flexion(env)[:, 0]
    return torch.exp(-((error / _TOLERANCE) ** 2))


def _spec() -> mujoco.MjSpec:
    """The finger; options are those of `MujocoCfg`, and mjlab warns of others."""
    take_sheaths(mjlab.sim.sim)
    spec = build_finger(_FINGER)
    spec.option.timestep, spec.option.integrator = 0.002, mujoco.mjtIntegrator.mjINT_EULER
    return spec


def follow_cfg(play: bool = False) -> ManagerBasedRlEnvCfg:
    """Configuration of the task; with ``play`` episodes do not end.

    The policy knows what a hand's motors do: angles of the spools and input tensions. The critic
    knows the joints and output tensions, too. Each world draws its friction at every reset.
    """
    motors, joints = (SceneEntityCfg("robot", joint_names=names) for names in (_MOTORS, JOINTS))
    actor = {
        "spools": ObservationTermCfg(func=mdp.joint_pos_rel, params={"asset_cfg": motors}),
        "input_tension": ObservationTermCfg(func=tension, params={"end": "input"}, scale=0.1),
        "target": ObservationTermCfg(func=target_flexion),
        "action": ObservationTermCfg(func=mdp.last_action),
    }
    critic = actor | {
        "joints": ObservationTermCfg(func=mdp.joint_pos_rel, params={"asset_cfg": joints}),
        "output_tension": ObservationTermCfg(func=tension, params={"end": "output"}, scale=0.1),
    }
    ranges = {"*.friction": (0.05, 0.3)}
    pulls = XmlActuatorCfg(target_names_expr=_MOTORS)
    robot = EntityCfg(spec_fn=_spec, articulation=EntityArticulationInfoCfg(actuators=(pulls,)))
    return ManagerBasedRlEnvCfg(
        scene=SceneCfg(num_envs=64, entities={"robot": robot}),
        observations={"actor": ObservationGroupCfg(actor), "critic": ObservationGroupCfg(critic)},
        actions={
            "spools": mdp.JointPositionActionCfg(
                entity_name="robot", actuator_names=_MOTORS, scale=0.5
            )
        },
        events={
            "scene": EventTermCfg(func=mdp.reset_scene_to_default, mode="reset"),
            "friction": EventTermCfg(func=draw_parameters, mode="reset", params={"ranges": ranges}),
        },
        rewards={
            "following": RewardTermCfg(func=following, weight=1.0, params={"asset_cfg": joints})
        },
        terminations={"time_out": TerminationTermCfg(func=mdp.time_out, time_out=True)},
        sim=SimulationCfg(mujoco=MujocoCfg(timestep=_FINGER.timestep, disableflags=("contact",))),
        viewer=ViewerConfig(distance=0.4),
        decimation=20,
        episode_length_s=1e9 if play else 2.0 * _PERIOD,
    )
