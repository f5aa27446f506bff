"""Environments on the finger for dm_control and gymnasium, with another friction in every episode.

Importing this package registers `tendon_mj/HoldForce-v0` and `tendon_mj/FollowTrajectory-v0` where
gymnasium is installed. The names below are loaded when they are first used; one whose package is
not installed raises `MissingPackageError`.
"""

from __future__ import annotations

import warnings
from contextlib import suppress
from importlib import import_module
from typing import TYPE_CHECKING, Any

from glfw import GLFWError

from tendon_mj.errors import MissingPackageError

try:
    from tendon_mj.envs.tasks import Ranges as Ranges
except ModuleNotFoundError as error:
    raise MissingPackageError.of_lab("tendon_mj.envs", error) from None

if TYPE_CHECKING:
    from tendon_mj.envs.finger import follow_trajectory as follow_trajectory
    from tendon_mj.envs.finger import hold_force as hold_force
    from tendon_mj.envs.gymnasium_finger import FollowTrajectoryEnv as FollowTrajectoryEnv
    from tendon_mj.envs.gymnasium_finger import HoldForceEnv as HoldForceEnv

# name -> module that it is loaded from when it is first used
_LAZY = dict.fromkeys(("follow_trajectory", "hold_force"), "finger")
_LAZY |= dict.fromkeys(("FollowTrajectoryEnv", "HoldForceEnv"), "gymnasium_finger")
_DM_CONTROL = (
    "pip install 'tendon-mj[environments]', and from Python 3.13 on also "
    "pip install --no-deps dm-control"
)
_INSTALL = {
    "dm_control": _DM_CONTROL,
    "dm_env": _DM_CONTROL,
    "gymnasium": "pip install 'tendon-mj[gymnasium]'",
}


def _let_dm_control_draw_without_a_screen() -> None:
    """Import dm_control's renderer so that it takes EGL where GLFW would only warn."""
    with warnings.catch_warnings(), suppress(Exception):  # without EGL its own choice stands
        warnings.simplefilter("error", GLFWError)
        import_module("dm_control._render")


if not TYPE_CHECKING:  # a type checker reads the imports above

    def __getattr__(name: str) -> Any:
        """Load a name when it is first used."""
        if name not in _LAZY:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        if _LAZY[name] == "finger":
            _let_dm_control_draw_without_a_screen()
        try:
            value = getattr(import_module(f"{__name__}.{_LAZY[name]}"), name)
        except ModuleNotFoundError as error:
            package = str(error.name).partition(".")[0]
            if package not in _INSTALL:
                raise
            raise MissingPackageError(
                f"{__name__}.{name} needs {package}, which is not installed: {_INSTALL[package]}",
                name=package,
            ) from None
        globals()[name] = value
        return value


try:
    import gymnasium as _gymnasium
except ModuleNotFoundError:
    pass
else:
    for _name, _steps in (("HoldForce", 400), ("FollowTrajectory", 600)):  # 4 s and 6 s
        _gymnasium.register(
            f"tendon_mj/{_name}-v0",
            f"tendon_mj.envs.gymnasium_finger:{_name}Env",
            max_episode_steps=_steps,
        )
