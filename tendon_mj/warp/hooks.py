"""What MuJoCo Warp calls within a step: it launches kernels and waits for nothing."""

from __future__ import annotations

from typing import Any

import mujoco
import warp as wp

from tendon_mj.errors import InvalidValueError
from tendon_mj.warp.evaluate import apply, solve
from tendon_mj.warp.measure import measure
from tendon_mj.warp.motion import Motion
from tendon_mj.warp.path import Scene
from tendon_mj.warp.reactions import Cells, Solved, add_reactions, fill_sensors, note_constraints
from tendon_mj.warp.sheaths import Sheaths
from tendon_mj.warp.simulated import Layout

_SPRING_OFF = mujoco.mjtDisableBit.mjDSBL_SPRING.value
_DAMPER_OFF = mujoco.mjtDisableBit.mjDSBL_DAMPER.value
_TENDONS = ("tendon_adr", "tendon_num", "wrap_type", "wrap_objid")
_GEOMETRY = ("site_bodyid", "site_pos", "geom_bodyid", "geom_pos", "geom_size")
_POSES = ("xpos", "xmat", "geom_xmat", "ten_wrapadr", "ten_wrapnum", "wrap_obj", "wrap_xpos")
_BODIES = ("body_rootid", "body_isdofancestor", "dof_invweight0", "jnt_qposadr", "jnt_dofadr")
_REST = ("qpos0", "tendon_length0", "tendon_stiffness", "tendon_damping", "tendon_lengthspring")
_CONTROLS = ("actuator_ctrllimited", "actuator_ctrlrange")
_ACTUATORS = ("nactuator", "actuator_trntype", "actuator_trnid", "actuator_gear")
_MOTION = ("time", "qpos", "ctrl", "ten_length", "ten_velocity", "actuator_force")
_FRAMES = ("subtree_com", "cdof", "wrap_xpos")
_EQUALITIES = ("eq_type", "eq_obj1id", "eq_obj2id", "eq_data", "tendon_range", "tendon_length0")
_COUNTS = ("ten_length", "ne", "nf", "nl")
_SENSORS = ("sensor_type", "sensor_datatype", "sensor_objid", "sensor_adr", "sensor_cutoff")
_SITES = ("site_bodyid", "body_rootid")
_CELLS = ("site_xpos", "site_xmat", "subtree_com", "cfrc_int")


def sheaths_of(data: Any) -> Sheaths:
    """Sheaths of the worlds in data that `put_data` or `make_data` made.

    Raises:
        InvalidValueError: data made otherwise, which have none.
    """
    found = getattr(data, "tendon_mj", None)
    if not isinstance(found, Sheaths):
        raise InvalidValueError(
            "these data have no sheaths: make them by tendon_mj.warp.make_data or put_data, of a "
            "model that has some"
        )
    return found


def sheaths_laid_out(data: Any, layout: Layout) -> Sheaths:
    """Sheaths of the worlds in data of the model that has this layout.

    Raises:
        InvalidValueError: data of another model, or without sheaths.
    """
    found = sheaths_of(data)
    if found.layout != layout:
        raise InvalidValueError(
            f"these data have the sheaths of another model, {', '.join(found.names)}: make them by "
            "tendon_mj.warp.make_data or put_data of the model that put_model was given"
        )
    return found


def evaluate(m: Any, d: Any, layout: Layout, driven: bool) -> None:
    """Solve the sheaths that are driven, or the others, and add their forces."""
    found = sheaths_laid_out(d, layout)
    scene = _with(Scene(), (m, _TENDONS), (m, _GEOMETRY), (d, _POSES))
    motion = _with(Motion(), (m, _BODIES), (m, _REST), (m, _CONTROLS), (m, _ACTUATORS))
    _with(motion, (d, _MOTION), (d, _FRAMES))
    motion.timestep, motion.nv = m.opt.timestep, m.nv
    motion.spring = 0.0 if m.opt.disableflags & _SPRING_OFF else 1.0
    motion.damper = 0.0 if m.opt.disableflags & _DAMPER_OFF else 1.0
    device = d.qpos.device
    inputs = [scene, motion, found.tendons, driven]
    wp.launch(solve, dim=(len(found.names), d.nworld), inputs=inputs, device=device)
    inputs = [motion, found.tendons, driven, d.qfrc_passive]
    wp.launch(apply, dim=(m.nv, d.nworld), inputs=inputs, device=device)


def note(m: Any, d: Any, layout: Layout) -> None:
    """Note the forces of constraints along tendons, once these are solved."""
    found = sheaths_laid_out(d, layout)
    solved = _with(Solved(), (m, _EQUALITIES), (d, _COUNTS), (d.efc, ("type", "id", "force")))
    inputs = [solved, found.tendons]
    wp.launch(
        note_constraints, dim=(len(found.names), d.nworld), inputs=inputs, device=d.qpos.device
    )


def react(m: Any, d: Any, layout: Layout, behind: Any, cells: Any) -> None:
    """Add the reactions of the spans to `cfrc_ext` and `cfrc_int`, and fill what shows them.

    Args:
        m, d, layout: model and data on the device, and what sheaths they have.
        behind: (bodies,), of `add_reactions`.
        cells: numbers of the sensors of force and torque.
    """
    found, device = sheaths_laid_out(d, layout), d.qpos.device
    inputs = [found.tendons, behind, m.body_rootid, d.subtree_com, d.wrap_xpos, *found.written]
    inputs += [d.cfrc_ext, d.cfrc_int]
    wp.launch(add_reactions, dim=d.cfrc_int.shape[::-1], inputs=inputs, device=device)
    shown = _with(Cells(), (m, _SENSORS), (m, _SITES), (d, _CELLS))
    inputs = [cells, shown, d.sensordata]
    wp.launch(fill_sensors, dim=(cells.shape[0], d.nworld), inputs=inputs, device=device)


def show(d: Any, layout: Layout, shown: Any) -> None:
    """Write what sensors of sheaths show; ``shown`` as of `shown_numbers`."""
    inputs = [sheaths_laid_out(d, layout).tendons, shown, d.sensordata]
    wp.launch(measure, dim=(shown.shape[0], d.nworld), inputs=inputs, device=d.qpos.device)


def _with(struct: Any, *parts: tuple[Any, tuple[str, ...]]) -> Any:
    """Struct with the named fields of a model or of data."""
    for source, names in parts:
        for name in names:
            setattr(struct, name, getattr(source, name))
    return struct
