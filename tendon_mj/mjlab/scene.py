"""Friction in the scene of a task of mjlab."""

from __future__ import annotations

from functools import partial
from typing import Any

import mjlab.sim.sim
import mujoco
from mjlab.envs import ManagerBasedRlEnvCfg

import tendon_mj
from tendon_mj.warp import take_sheaths


def add_friction(
    cfg: ManagerBasedRlEnvCfg, tendon: str | list[str], **options: Any
) -> ManagerBasedRlEnvCfg:
    """Let tendons of a task run in sheaths, after all that mjlab adds to its scene.

    From the first such scene on, mjlab puts models on MuJoCo Warp by `tendon_mj.warp`.

    Args:
        cfg: changed in its ``scene.spec_fn`` and returned.
        tendon: name, names or pattern as in the scene, as ``robot/*``.
        options: of `tendon_mj.add_friction`, which acts when the environment is made.
    """
    cfg.scene.spec_fn = partial(_edit, cfg.scene.spec_fn, tendon, options)
    return cfg


def _edit(before: Any, tendon: str | list[str], options: Any, spec: mujoco.MjSpec) -> None:
    if before is not None:
        before(spec)
    take_sheaths(mjlab.sim.sim)
    tendon_mj.add_friction(spec, tendon, **options)
