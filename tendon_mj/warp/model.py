"""Models with sheaths on MuJoCo Warp: transfer to the device, and the hooks that solve sheaths.

MuJoCo Warp runs no plugins. A copy of the model goes there in which a reel is an actuator without
force and a sheath's sensor one of the user's. The sheaths are solved by kernels of ours, which its
callbacks launch: wound tendons where passive forces are computed, and driven ones where actuators
are, both before accelerations are. Nothing of it waits for the device.
"""

from __future__ import annotations

import copy
import ctypes
import inspect
from collections.abc import Iterable
from typing import Any

import mujoco
import mujoco_warp as mjw
import numpy as np
import warp as wp

from tendon_mj.errors import InvalidValueError
from tendon_mj.plugin import offset, sheaths, unused_parameters
from tendon_mj.warp import evaluate, inextensible, reactions, support
from tendon_mj.warp.cells import bodies_behind, moved_dofs, read_groups_back
from tendon_mj.warp.constraints import Constraints, keep_constraints
from tendon_mj.warp.motion import Dynamics
from tendon_mj.warp.path import Scene
from tendon_mj.warp.response import accelerate, set_response
from tendon_mj.warp.sensors import force_sensors, sensors_of_sheaths, shown_numbers
from tendon_mj.warp.sheaths import Sheaths
from tendon_mj.warp.tendons import ELASTIC, INEXTENSIBLE, WOUND
from tendon_mj.warp.transfer import read_back
from tendon_mj.warp.yields import let_guides_yield, respond_to_spans

_SPRING_OFF = mujoco.mjtDisableBit.mjDSBL_SPRING.value
_DAMPER_OFF = mujoco.mjtDisableBit.mjDSBL_DAMPER.value
_SENSORS_OFF = mujoco.mjtDisableBit.mjDSBL_SENSOR.value
_put_model = inspect.unwrap(mjw.put_model)  # without our refusal of plugins
_CLAMPCTRL_OFF = mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL.value
_ACTUATION_OFF = mujoco.mjtDisableBit.mjDSBL_ACTUATION.value
_EULERDAMP_OFF = mujoco.mjtDisableBit.mjDSBL_EULERDAMP.value
_EULER = mujoco.mjtIntegrator.mjINT_EULER.value
_SIZES = {  # array of the data → size in the model
    "qpos": "nq",
    "qvel": "nv",
    "act": "na",
    "ctrl": "nu",
    "xpos": "nbody",
    "sensordata": "nsensordata",
    "plugin_state": "npluginstate",
}
_OF_SPRING = "is that of the tendon's own spring: write tendon_lengthspring of the device's model"
_LAST = mujoco.mjtStage.mjSTAGE_ACC.value


def sheaths_of(data: Any) -> Sheaths:
    """Sheaths of the worlds in data that `put_data` or `make_data` made.

    Raises:
        InvalidValueError: data made otherwise, which have none.
    """
    batch = getattr(data, "tendon_mj", None)
    if not isinstance(batch, Sheaths):
        raise InvalidValueError(
            "these data have no sheaths: make them by tendon_mj.warp.make_data or put_data, of a "
            "model that has some"
        )
    return batch


def sheaths_laid_out(data: Any, layout: support.SheathLayouts) -> Sheaths:
    """Sheaths of the worlds in data of the model that has this layout.

    Raises:
        InvalidValueError: data of another model, or without sheaths.
    """
    batch = sheaths_of(data)
    if batch.layout != layout:
        raise InvalidValueError(
            f"these data have the sheaths of another model, {', '.join(batch.names)}: make them by "
            "tendon_mj.warp.make_data or put_data of the model that put_model was given"
        )
    return batch


def _dynamics(m: Any, d: Any) -> Any:
    motion = _filled(Dynamics, m.opt, m, d)
    motion.spring = 0.0 if m.opt.disableflags & _SPRING_OFF else 1.0
    motion.damper = 0.0 if m.opt.disableflags & _DAMPER_OFF else 1.0
    motion.actuates = not m.opt.disableflags & _ACTUATION_OFF
    motion.clamps = not m.opt.disableflags & _CLAMPCTRL_OFF
    motion.implicit = int(m.opt.integrator) != _EULER
    joints_off = _DAMPER_OFF if motion.implicit else _DAMPER_OFF | _EULERDAMP_OFF
    motion.joints_damp = not m.opt.disableflags & joints_off
    return motion


_LONG = {
    evaluate.trace,
    evaluate.solve,
    inextensible.set_up,
    set_response,
    inextensible.solve_groups,
}  # kernels


def _launch(d: Any, launches: Iterable[tuple[Any, tuple[int, ...], list[Any]]]) -> None:
    """Launch kernels with a number of rows, to which that of worlds is added, and their inputs."""
    for kernel, rows, inputs in launches:
        # blocks of 32: few long threads, which so are spread over all of the GPU
        block = 32 if kernel in _LONG else 256
        dim = (*rows, d.nworld)
        wp.launch(kernel, dim=dim, inputs=inputs, device=d.qpos.device, block_dim=block)


def _evaluate(m: Any, d: Any, layout: support.SheathLayouts, moved: Any, kind: int) -> None:
    """Solve the sheaths of elastic tendons of a kind, and add their forces.

    ``moved`` is as of `apply`.
    """
    batch = sheaths_laid_out(d, layout)
    t, y, motion = batch.tendons, batch.groups, _dynamics(m, d)
    segments, sheaths = (t.stored.shape[0],), (len(batch.names),)
    yielding = y.span_segment.shape if kind == ELASTIC else (0,)
    _launch(
        d,
        (
            (evaluate.commit, segments, [d.time, m.opt.timestep, t, kind]),
            (evaluate.trace, sheaths, [_filled(Scene, m, d), motion, t, kind]),
            (respond_to_spans, yielding, [motion, t, y]),
            (let_guides_yield, yielding, [motion, t, y]),
            (evaluate.prepare, segments, [t, kind]),
            (evaluate.solve, sheaths, [motion, t, kind]),
            (evaluate.apply, (m.nv,), [motion, t, moved, kind, d.qfrc_passive]),
        ),
    )


def _evaluate_driven(
    m: Any, d: Any, layout: support.SheathLayouts, moved: Any, kinds: set[int], actuates: bool
) -> None:
    """Solve the sheaths of driven tendons, and add their forces.

    Forces of actuators are among those at hand with ``actuates``.
    """
    batch = sheaths_laid_out(d, layout)
    t, y, motion = batch.tendons, batch.groups, _dynamics(m, d)
    motion.has_forces = actuates
    members, cells, together = y.sheath.shape, y.member.shape, INEXTENSIBLE in kinds
    if together:
        _launch(
            d,
            (
                _keeps_unknown(d, t, y),
                (inextensible.set_up, members, [_filled(Scene, m, d), motion, t, y]),
                (inextensible.fill_rows, y.dof.shape, [motion, t, y]),
            ),
        )
    constraints = _constraints(m, d)
    _launch(d, [(set_response, (), [motion, constraints, t, y, False])])
    if ELASTIC in kinds:
        _evaluate(m, d, layout, moved, ELASTIC)
    if together:
        solution = (
            (accelerate, (), [motion, t, y]),
            (inextensible.answer, cells, [motion, t, y]),
            (inextensible.solve_groups, (), [motion, t, y]),
        )
        _launch(
            d,
            (
                *solution,
                (set_response, (), [motion, constraints, t, y, True]),
                *solution,
                (inextensible.publish, members, [motion, t, y]),
                (inextensible.add_friction, (m.nv,), [t, y, d.qfrc_passive]),
            ),
        )


def _keeps_unknown(d: Any, t: Any, y: Any) -> tuple[Any, tuple[int, ...], list[Any]]:
    inputs = [d.time, d.qfrc_smooth, d.qfrc_constraint, d.qacc, t, y]
    dofs = y.unknown.shape[:1] if y.sheath.shape[0] else (0,)
    return inextensible.keep_unknown, dofs, inputs


def _constraints(m: Any, d: Any) -> Any:
    """Constraints that friction knows; none without sensors, in whose stage they are read."""
    made = _filled(Constraints, m, d, d.efc)
    if m.opt.disableflags & _SENSORS_OFF:
        made.type = d.efc.type[:, :0]
    return made


def note(m: Any, d: Any, layout: support.SheathLayouts) -> None:
    """Note the forces of constraints along tendons, once these are solved."""
    batch = sheaths_laid_out(d, layout)
    inputs = [_filled(reactions.Solved, m, d, d.efc), batch.tendons]
    _launch(d, [(reactions.note_constraints, (len(batch.names),), inputs)])


def react(m: Any, d: Any, layout: support.SheathLayouts, behind: Any, cells: Any) -> None:
    """Add the spans' reactions to `cfrc_ext` and `cfrc_int`; fill force and torque sensors.

    Args:
        m, d, layout: model and data on the device, and the layout of their sheaths.
        behind: (bodies,), of `add_reactions`.
        cells: numbers of the sensors of force and torque.
    """
    batch = sheaths_laid_out(d, layout)
    inputs = [batch.tendons, behind, m.body_rootid, d.subtree_com, *batch.written]
    inputs += [d.cfrc_ext, d.cfrc_int]
    filled = [cells, _filled(reactions.Cells, m, d), d.sensordata]
    _launch(
        d,
        [
            (reactions.add_reactions, behind.shape, inputs),
            (reactions.fill_sensors, cells.shape, filled),
        ],
    )


def _show(d: Any, layout: support.SheathLayouts, shown: Any) -> None:
    """Write the sensors of sheaths; ``shown`` as of `shown_numbers`."""
    batch = sheaths_laid_out(d, layout)
    inputs = [batch.tendons, batch.groups, shown, d.sensordata]
    _launch(d, [(reactions.measure, shown.shape[:1], inputs)])


_FORMER_NAMES = {"nactuator": "nu"}  # of MuJoCo Warp while an actuator had one input


def _filled(struct: Any, *sources: Any) -> Any:
    """A struct with each field from the first of the sources that has it."""
    made = struct()
    for field in struct.vars:
        for name in (field, _FORMER_NAMES.get(field, field)):
            source = next((source for source in sources if hasattr(source, name)), None)
            if source is not None:
                setattr(made, field, getattr(source, name))
                break
    return made


def put_model(model: mujoco.MjModel, **options: Any) -> Any:
    """Put a model with sheaths on the device, as `mujoco_warp.put_model` does one without.

    Args:
        model: any that MuJoCo Warp takes but for its sheaths.
        options: of `mujoco_warp.put_model`.

    Returns:
        `mujoco_warp.Model`, with hooks in ``callback``; its data are made by `put_data` or
        `make_data` of this package.

    Raises:
        NoPluginsError: a feature that is not supported, by name and with a remedy.
    """
    simulated = support.simulated_sheaths(_of_mujoco(model), mujoco.MjData(model))
    if not simulated:
        return _put_model(model, **options)
    support.check_supported(model, simulated)
    put = _put_model(_without_plugins(model, simulated), **options)
    _solve_sheaths(put, model, simulated)
    return put


def put_sheaths(model: mujoco.MjModel, put: Any, data: Any) -> None:
    """Put sheaths on a model and data that are on the device without, of a package that made them.

    They begin as after a reset. Options are those on the device. Sensors of sheaths are left out;
    `sheaths_of` has what they show. A CUDA graph that was captured before goes on without sheaths.

    Args:
        model: the same with sheaths, by `add_friction` on its spec.
        put: `mujoco_warp.Model`, as put without sheaths.
        data: `mujoco_warp.Data` of it.

    Raises:
        NoPluginsError: a feature that is not supported.
        InvalidValueError: what is on the device is another model, has callbacks of its own where
            sheaths need them, or sensors that come behind those of sheaths.
    """
    simulated = support.simulated_sheaths(_of_mujoco(model), mujoco.MjData(model))
    support.check_supported(model, simulated)
    _check_same(model, put, data, len(simulated))
    with wp.ScopedDevice(data.qpos.device):
        _solve_sheaths(put, model, simulated)
    _with_sheaths(data, model, simulated)


def _check_same(model: mujoco.MjModel, put: Any, data: Any, sheaths: int) -> None:
    """Refuse a model on the device that differs by more than the sensors of sheaths."""
    where = "tendon_mj.warp.put_sheaths"
    if not sheaths:
        raise InvalidValueError(f"{where}: the model has no sheaths; add_friction gives it some")
    for size in ("nq", "nv", "nu", "nbody", "njnt", "ngeom", "nsite", "ntendon"):
        if getattr(put, size) != getattr(model, size):
            raise InvalidValueError(
                f"{where}: {size} is {getattr(put, size)} on the device and"
                f" {getattr(model, size)} with sheaths; add no elements to the spec that was put,"
                " a reel or its sites neither, or call tendon_mj.warp.take_sheaths before it is put"
            )
    if put.wrap_objid.numpy().tolist() != model.wrap_objid.ravel().tolist():
        raise InvalidValueError(f"{where}: tendons on the device have other paths than the model's")
    if data.qpos.shape[1] != model.nq or data.sensordata.shape[1] != put.nsensordata:
        raise InvalidValueError(f"{where}: the data are not of the model on the device")
    shown = list(sensors_of_sheaths(model))
    own = model.nsensordata - int(model.sensor_dim[shown].sum())
    if put.nsensordata != own or int(model.sensor_adr[shown].min(initial=own)) < own:
        raise InvalidValueError(
            f"{where}: there are {put.nsensordata} numbers of sensors on the device; the model with"
            f" sheaths has {own} without theirs, which have to be the last of the spec"
        )
    taken = [name for name in ("passive", "act_bias", "sensor") if getattr(put.callback, name)]
    if taken:
        raise InvalidValueError(
            f"{where}: the model on the device has callbacks already, {', '.join(taken)}; set yours"
            " afterwards, and call from them those that are there then"
        )


def _solve_sheaths(
    put: Any, model: mujoco.MjModel, simulated: dict[str, support.Simulated]
) -> None:
    """Let the callbacks of a model on the device solve its sheaths."""
    put.tendon_mj = layout = support.layout_of(simulated)
    kinds = {_kind(sheath) for sheath in simulated.values()}
    actuation_off = put.opt.disableflags & _ACTUATION_OFF
    # whether they need the forces of actuators
    late = model.nactuator > 0 and not actuation_off and kinds != {WOUND}

    constrained = any(sheath.state["constrained"] for sheath in simulated.values())
    moved = wp.array([moved_dofs(model, sheath) for sheath in simulated.values()], dtype=wp.bool)

    def drive(m: Any, d: Any) -> None:
        _evaluate_driven(m, d, layout, moved, kinds, late)

    def act_bias(m: Any, d: Any) -> None:
        support.check_options(m.opt, constrained)  # here too, as passive forces may all be off
        if not late or (batch := sheaths_laid_out(d, layout)).asks:
            return
        unclamped, batch.asks = wp.clone(d.actuator_force), True
        try:
            mjw.fwd_actuation(m, d)  # limits and parts that come behind this callback
        finally:
            batch.asks = False
        drive(m, d)
        wp.copy(d.actuator_force, unclamped)

    def passive(m: Any, d: Any) -> None:
        support.check_options(m.opt, constrained)
        if m.opt.disableflags & _ACTUATION_OFF != actuation_off:
            raise InvalidValueError(
                "the flag actuation was changed on the device; change it in the mujoco.MjModel, and"
                " put that"
            )
        if WOUND in kinds:
            _evaluate(m, d, layout, moved, WOUND)
        if not late and kinds != {WOUND}:
            if INEXTENSIBLE in kinds:
                mjw.rne(m, d)  # which MuJoCo Warp does after this
            drive(m, d)

    put.callback.passive, put.callback.act_bias = passive, act_bias
    shown = shown_numbers(model, simulated)
    behind = wp.array(bodies_behind(model), dtype=wp.int32)
    cells = force_sensors(model)
    show = shown.shape[0] > 0 and put.nsensordata == model.nsensordata

    def sensor(m: Any, d: Any, stage: int) -> None:
        if stage != _LAST:
            return
        if INEXTENSIBLE in kinds:
            inputs = [_constraints(m, d), sheaths_laid_out(d, layout).groups]
            _launch(d, [(keep_constraints, (), inputs)])
        if constrained:
            note(m, d, layout)
        if m.sensor_rne_postconstraint or getattr(m.opt, "run_rne_postconstraint", False):
            react(m, d, layout, behind, cells)
        if show:
            _show(d, layout, shown)

    put.callback.sensor = sensor


def put_data(model: mujoco.MjModel, data: mujoco.MjData, nworld: int = 1, **sizes: Any) -> Any:
    """Put a simulation with its sheaths on the device, as they are, once for each world.

    Args:
        model: as given to `put_model`.
        data: gives every world its initial state and live parameters.
        nworld: number of worlds.
        sizes: of `mujoco_warp.put_data`.

    Returns:
        `mujoco_warp.Data`; `sheaths_of` gives its sheaths.

    Raises:
        NoPluginsError: a live parameter that is not supported.
        InvalidValueError: data of another model.
    """
    _check_data(_of_mujoco(model), data)
    simulated = support.simulated_sheaths(model, data)
    support.check_sheaths(model, simulated)
    return _with_sheaths(mjw.put_data(model, data, nworld, **sizes), model, simulated)


def make_data(model: mujoco.MjModel, nworld: int = 1, **sizes: Any) -> Any:
    """Make data on the device as after a reset; arguments as of `put_data`."""
    _of_mujoco(model)
    simulated = support.simulated_sheaths(model, mujoco.MjData(model))
    return _with_sheaths(mjw.make_data(model, nworld, **sizes), model, simulated)


def get_data_into(
    result: mujoco.MjData, model: mujoco.MjModel, data: Any, world_id: int = 0
) -> None:
    """Get a world with its sheaths from the device, as `mujoco_warp.get_data_into` does without.

    Args:
        result: its state and live parameters are set; evaluate it for tensions and forces.
        model: as given to `put_model`.
        data: on the device.
        world_id: number of the world.

    Raises:
        InvalidValueError: data of another model, or a world that is not there.
    """
    _check_data(_of_mujoco(model), result)
    if data.qpos.shape[1] != model.nq or data.qvel.shape[1] != model.nv:
        raise InvalidValueError("the data on the device are of another model than is given")
    if not isinstance(world_id, int | np.integer) or not 0 <= world_id < data.nworld:
        raise InvalidValueError(
            f"world_id = {world_id!r} must be a whole number from 0 to {data.nworld - 1}"
        )
    mujoco.mj_forward(model, result)  # an uninitialised tendon has no state to be set
    mjw.get_data_into(result, model, data, world_id)
    simulated = support.simulated_sheaths(model, result)
    if not simulated:
        return
    sheaths = sheaths_laid_out(data, support.layout_of(simulated))
    t, y, rows = sheaths.tendons, sheaths.groups, (sheaths.tendons.stored.shape[0],)
    step = wp.array([model.opt.timestep], dtype=wp.float32, device=data.qpos.device)
    _launch(
        data,
        (
            *((evaluate.commit, rows, [data.time, step, t, kind]) for kind in (WOUND, ELASTIC)),
            (evaluate.finish, (len(sheaths.names),), [data.time, t]),
            _keeps_unknown(data, t, y),
            (inextensible.commit_groups, y.sheath.shape, [data.time, step, data.qvel, t, y]),
        ),
    )
    read_back(simulated, t, world_id, result.time - model.opt.timestep)
    read_groups_back(model, simulated, y, world_id)


def reset_data(model: Any, data: Any, reset: Any = None) -> None:
    """Reset worlds with their sheaths, as `mujoco_warp.reset_data` does without; parameters stay.

    Args:
        model: on the device.
        data: on the device.
        reset: (worlds,) Warp array of bool, which ones; all without.

    Raises:
        InvalidValueError: ``reset`` is not such an array; nothing is reset.
    """
    shape, kind = getattr(reset, "shape", None), getattr(reset, "dtype", type(reset).__name__)
    if reset is not None and (shape != (data.nworld,) or kind != wp.bool):
        raise InvalidValueError(
            f"reset must be a Warp array of {data.nworld} bool, one for each world; got"
            f" {getattr(kind, '__name__', kind)} of shape {shape}"
        )
    mjw.reset_data(model, data, reset)
    layout = getattr(model, "tendon_mj", ())
    if not (layout or hasattr(data, "tendon_mj")):
        return
    sheaths, device = sheaths_laid_out(data, layout), data.qpos.device
    if reset is None:
        reset = wp.full(data.nworld, True, dtype=wp.bool, device=device)
    _launch(data, [(evaluate.reset_worlds, (len(sheaths.names),), [sheaths.tendons, reset])])


def _kind(sheath: support.Simulated) -> int:
    if sheath.state["inextensible"]:
        return INEXTENSIBLE
    return ELASTIC if sheath.state["driven"] else WOUND


def _of_mujoco(model: Any) -> mujoco.MjModel:
    if not isinstance(model, mujoco.MjModel):
        raise InvalidValueError(
            f"a {type(model).__module__}.{type(model).__name__} is given as model; give the "
            "mujoco.MjModel that is to be put, or was put, on the device"
        )
    return model


def _check_data(model: mujoco.MjModel, data: Any) -> None:
    """Refuse data of another model, where MuJoCo would write past the arrays."""
    if not isinstance(data, mujoco.MjData):
        raise InvalidValueError(f"{data!r} is given as data; give a mujoco.MjData of the model")
    for array, size in _SIZES.items():
        rows, expected = len(getattr(data, array)), getattr(model, size)
        if rows != expected:
            raise InvalidValueError(
                f"the data belong to another model: their {array} has {rows} rows, and {size} of"
                f" the model is {expected}"
            )


def _with_sheaths(put: Any, model: mujoco.MjModel, simulated: dict[str, support.Simulated]) -> Any:
    if simulated:
        unused = {
            name: unused_parameters(model, instance.instance)
            for name, instance in sheaths(model).items()
        }
        for name, sheath in simulated.items():
            if sheath.state["own_spring"]:
                unused[name] |= dict.fromkeys(("pretension", "slack"), _OF_SPRING)
        with wp.ScopedDevice(put.qpos.device):
            put.tendon_mj = Sheaths(model, simulated, unused, put.nworld)
    return put


def _without_plugins(
    model: mujoco.MjModel, simulated: dict[str, support.Simulated]
) -> mujoco.MjModel:
    """A copy in which no actuator and no sensor is a sheath's, and nothing a plugin's."""
    plain = copy.copy(model)
    reels = [k for sheath in simulated.values() if (k := int(sheath.state["reel_actuator"])) >= 0]
    plain.actuator_gaintype[reels] = mujoco.mjtGain.mjGAIN_FIXED
    plain.actuator_biastype[reels] = mujoco.mjtBias.mjBIAS_NONE
    plain.actuator_gainprm[reels] = 0.0
    plain.actuator_plugin[reels] = -1
    if "actuator_damping" not in mjw.Model.__annotations__:  # which MuJoCo Warp 3.11 leaves out
        on = np.flatnonzero(plain.actuator_trntype == mujoco.mjtTrn.mjTRN_TENDON)
        damping = plain.actuator_damping[on] * plain.actuator_gear[on, 0] ** 2
        np.add.at(plain.tendon_damping, plain.actuator_trnid[on, 0], damping)
        plain.actuator_damping[on] = 0.0
    shown = list(sensors_of_sheaths(model))
    plain.sensor_type[shown] = mujoco.mjtSensor.mjSENS_USER
    plain.sensor_datatype[shown] = mujoco.mjtDataType.mjDATATYPE_REAL
    plain.sensor_needstage[shown] = mujoco.mjtStage.mjSTAGE_ACC
    plain.sensor_plugin[shown] = -1
    # MuJoCo Warp keeps the plugins of geoms alone, and expects as many as there are of all
    ctypes.c_int64.from_address(plain._address + offset("m_nplugin")).value = 0
    return plain
