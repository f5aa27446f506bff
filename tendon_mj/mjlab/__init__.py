"""Tendons with friction in mjlab: in any task, by `add_friction`, and in tasks of this package.

mjlab imports this package where it is installed, by the entry point in the group `mjlab.tasks`,
which registers `TendonMj-Finger-Follow`, and where MyoSuite is installed `TendonMj-MyoHand-Pose`.
mjlab puts its models as ever until a scene with friction is made. Terms of events and observations
are in `tendon_mj.warp`.
"""

from tendon_mj.errors import MissingPackageError

try:
    from mjlab.tasks.registry import list_tasks, register_mjlab_task
except ModuleNotFoundError as error:
    package = str(error.name).partition(".")[0]
    if package != "mjlab":
        raise
    raise MissingPackageError(
        "tendon_mj.mjlab needs mjlab, which is not installed: pip install 'tendon-mj[mjlab]'",
        name=package,
    ) from None

from contextlib import suppress
from importlib import import_module

from mjlab.rl import RslRlOnPolicyRunnerCfg

from tendon_mj.mjlab.finger import follow_cfg
from tendon_mj.mjlab.myohand import HAND, hand_cfgs
from tendon_mj.mjlab.scene import add_friction as add_friction

_PPO = RslRlOnPolicyRunnerCfg(experiment_name="tendon_mj_finger", logger="tensorboard")
register_mjlab_task("TendonMj-Finger-Follow", follow_cfg(), follow_cfg(play=True), _PPO)
with suppress(ModuleNotFoundError):
    import_module("myosuite.envs.myo.backends.mjlab")  # which registers its tasks
if HAND in list_tasks():
    register_mjlab_task("TendonMj-MyoHand-Pose", *hand_cfgs())
