"""An environment of mjlab in which each world draws the friction of its tendon at every reset."""

import mujoco
import torch
from mjlab.actuator.actuator import TransmissionType
from mjlab.actuator.xml_actuator import XmlActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg, EntityCfg
from mjlab.envs import ManagerBasedRlEnv, ManagerBasedRlEnvCfg, mdp
from mjlab.managers.event_manager import EventTermCfg
from mjlab.managers.observation_manager import ObservationGroupCfg, ObservationTermCfg
from mjlab.scene import SceneCfg
from mjlab.sim import MujocoCfg, SimulationCfg

import tendon_mj.mjlab
import tendon_mj.warp

FINGER = """<mujoco>
  <worldbody>
    <site name="motor" pos="-.05 0 .01"/><site name="palm" pos="0 .01 .01"/>
    <body><joint name="knuckle" axis="0 0 1" stiffness=".2" damping=".02"/>
      <geom type="capsule" size=".006" fromto="0 0 0 .04 0 0" mass=".02"/>
      <site name="near" pos=".01 .012 .01"/><site name="far" pos=".03 .006 .01"/>
    </body>
  </worldbody>
  <tendon><spatial name="flexor"><site site="motor"/><site site="palm"/>
    <site site="near"/><site site="far"/></spatial></tendon>
  <actuator><motor name="pull" tendon="flexor" ctrlrange="-20 0"/></actuator>
</mujoco>"""
pull = XmlActuatorCfg(target_names_expr=("flexor",), transmission_type=TransmissionType.TENDON)
finger = EntityCfg(
    spec_fn=lambda: mujoco.MjSpec.from_string(FINGER),
    articulation=EntityArticulationInfoCfg(actuators=(pull,)),
)
event = tendon_mj.warp.draw_parameters
drawn = EventTermCfg(func=event, mode="reset", params={"ranges": {"*.friction": (0.05, 0.3)}})
moved = EventTermCfg(  # the cable is laid differently from time to time
    func=event,
    mode="interval",
    interval_range_s=(0.1, 0.3),
    params={"ranges": {"*.extra_bend": (0.0, 0.5)}},
)
seen = ObservationTermCfg(func=tendon_mj.warp.tension, params={"end": "output"})
cfg = ManagerBasedRlEnvCfg(
    scene=SceneCfg(num_envs=4, entities={"robot": finger}),
    observations={"actor": ObservationGroupCfg({"arrives": seen})},
    actions={"pull": mdp.TendonEffortActionCfg(entity_name="robot", actuator_names=("flexor",))},
    events={"friction": drawn, "bend": moved},
    sim=SimulationCfg(mujoco=MujocoCfg(timestep=0.002, disableflags=("contact",))),
    decimation=5,
)
tendon_mj.mjlab.add_friction(cfg, "robot/*", friction=0.1)  # before the environment is made
env = ManagerBasedRlEnv(cfg, "cpu")
env.reset()
for _ in range(50):
    observations, *_ = env.step(torch.full((4, 1), -10.0))
sheaths = tendon_mj.warp.sheaths_of(env.sim.wp_data)
print("friction", sheaths.parameters["friction"].numpy().ravel().round(3))
print("more bend", sheaths.parameters["extra_bend"].numpy().ravel().round(2))
print("of 10 N arrive", observations["actor"].numpy().ravel().round(2))
