"""Play behind the tendon: a load that goes from one flank to the other of the pulley it hangs on.

    |q − p| ≤ b/2,   q of the joint, p of the pulley that its sheaths turn

The pulley is a coordinate of its own: the joint ``<joint>_pulley`` of a body that has no more
inertia than the time step needs. The fixed tendon ``<joint>_play`` is q − p, and its limits are the
flanks: b is the parameter ``<joint>_play.range_width``. In the reference pose, where angles are
zeroed, a load that gravity and springs put on the joint rests on its flank at q = p; without one
the joint is in the middle.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final, Protocol
from xml.etree.ElementTree import SubElement

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.attach import Mjcf, number_text, numbers
from tendon_mj.errors import TendonError
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay.parameters import RANGE_WIDTH, Parameter, stiff_friction
from tendon_mj.lab.units import JOINT, ROUNDING
from tendon_mj.models import load_model, load_spec, model_path
from tendon_mj.plugin import sheath_arrays, sheaths

PLAY: Final = f"_play.{RANGE_WIDTH}"  # after the name of the joint
# The pulley between cables whose guides hold is an oscillator, to which friction may be no damper:
# in the model's steps, and none are longer, it turns by √2 rad of the 2 that are stable.
_STEPS, _INERTIA = 0.5, 0.1  # inertia over stiffness × step², and at most of the joint's
_SLIDE = mujoco.mjtJoint.mjJNT_SLIDE.value
_MASS, _OWN_INERTIA = "1e-6", "1e-9 1e-9 1e-9"  # a body needs some


class MakeModel(Protocol):
    """Loads a model by its name or file, as `load_model` does."""

    def __call__(self, name: str, *, beside: Path | None = None) -> mujoco.MjModel: ...  # noqa: D102


def joints_with_pulleys(model: mujoco.MjModel) -> dict[str, dict[str, NDArray[np.void]]]:
    """Joint that sheaths turn at their output → their states; joints with a play are left out."""
    joints: dict[str, dict[str, NDArray[np.void]]] = {}
    data = mujoco.MjData(model)
    for name, sheath in sheaths(model).items():
        state = sheath_arrays(model, data.plugin_state, name, sheath.state).state
        if (joint := int(state["output_joint"])) >= 0:
            joints.setdefault(model.joint(joint).name, {})[name] = state
    taken = {model.tendon(k).name for k in range(model.ntendon)}
    return {
        joint: states
        for joint, states in joints.items()
        if taken.isdisjoint((f"{joint}_play", f"{joint.removesuffix('_pulley')}_play"))
    }


def plays(model: mujoco.MjModel) -> dict[str, Parameter]:
    """Parameters of plays that a model may be given, all 0."""
    joints = {joint: int(model.joint(joint).type[0]) for joint in joints_with_pulleys(model)}
    units = {joint: JOINT["springref"][kind == _SLIDE] for joint, kind in joints.items()}
    return {f"{joint}{PLAY}": Parameter(0.0, unit, "tendon", 0.0) for joint, unit in units.items()}


def add_plays(text: Mjcf, model: mujoco.MjModel, parameters: Iterable[str]) -> None:
    """Write the plays that a model lacks of those parameters into its text."""
    for parameter in sorted(plays(model).keys() & {*parameters}):
        _add_play(text, model, parameter.removesuffix(PLAY))


def _add_play(text: Mjcf, model: mujoco.MjModel, joint: str) -> None:
    """Write a pulley for a joint, on which its sheaths wind in its place."""
    written, element = text.element("joint", joint), model.joint(joint)
    body = SubElement(text.section("worldbody", ""), "body")
    SubElement(body, "inertial", pos="0 0 0", mass=_MASS, diaginertia=_OWN_INERTIA)
    pulley = SubElement(body, "joint", name=f"{joint}_pulley", limited="false")
    pulley.set("type", "slide" if element.type[0] == _SLIDE else "hinge")
    pulley.set("ref", written.get("ref", "0"))
    for attribute in ("stiffness", "damping", "frictionloss"):  # which a class may give
        pulley.set(attribute, "0")
    states = joints_with_pulleys(model)[joint]
    stiffness = sum(map(partial(_stiffness, model), states.values()))
    inertia = _STEPS * stiffness * model.opt.timestep**2
    largest = _INERTIA * float(model.dof_M0[element.dofadr[0]])
    pulley.set("armature", number_text(min(inertia, largest) if stiffness else largest))
    solref, solimp = stiff_friction(model)
    low = {-1: 0.0, 0: -0.5, 1: -1.0}[_side(model, joint)]
    flanks = {
        "name": f"{joint}_play",
        "limited": "true",
        "range": numbers((low, low + 1.0)),  # until its width is set
        "solreflimit": numbers(solref),
        "solimplimit": numbers(solimp),
    }
    play = SubElement(text.section("tendon", ""), "fixed", flanks)
    for name, coefficient in ((joint, "1"), (f"{joint}_pulley", "-1")):
        SubElement(play, "joint", joint=name, coef=coefficient)
    for sheath in states:
        for config in text.plugin(sheath).iterfind("config"):
            if config.get("key") == "output_joint":
                config.set("value", f"{joint}_pulley")


def _stiffness(model: mujoco.MjModel, state: NDArray[np.void]) -> float:
    """Stiffness of the tendon between its last guide and a pulley [N m/rad or N/m]."""
    length = model.tendon_length0[int(state["tendon"])]
    segments = float(state["guides"]) + 1.0
    per_length = float(state["law"]["axial_stiffness"]) / float(length)
    return per_length * segments * float(state["output_radius"]) ** 2


def _side(model: mujoco.MjModel, joint: str) -> int:
    """Sense in which gravity and springs load a joint in the reference pose, or 0."""
    data = mujoco.MjData(model)
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_rne(model, data, 0, bias := np.zeros(model.nv))
    k = model.joint(joint).id
    place = model.jnt_qposadr[k]
    stretched = float(model.qpos_spring[place] - model.qpos0[place])
    stiffness = float(
        model.jnt_stiffness.reshape(model.njnt, -1)[k, 0]
    )  # of MuJoCo 4, a polynomial
    load = stiffness * stretched - float(bias[model.jnt_dofadr[k]])
    return int(np.sign(load)) if abs(load) > ROUNDING else 0


def load_with_plays(
    name: str,
    parameters: Iterable[str],
    beside: Path | None = None,
    make: MakeModel = load_model,
) -> mujoco.MjModel:
    """A model, as ``make`` loads it, with the plays that it lacks of those parameters.

    Raises:
        TendonError: a joint or a sheath on it is not in the model's text.
    """
    model, source = load_model(name, beside=beside), model_path(name, beside=beside)
    missing = [name for name in plays(model) if name in {*parameters}]
    if not missing:
        return model if make is load_model else make(name, beside=beside)
    text = Mjcf(source)
    add_plays(text, model, missing)
    with TemporaryDirectory() as folder:
        text.move_to(Path(folder), load_spec(str(source)))
        made = Path(folder) / source.with_suffix(".xml").name
        text.write(made)
        try:
            return make(str(made))
        except TendonError as error:
            raise TendonError(str(error).replace(str(made), f"{source} with play")) from error


def load_recorded(
    recording: Recording, parameters: Iterable[str] = (), make: MakeModel = load_model
) -> mujoco.MjModel:
    """The model of a recording, with the plays that its description or the parameters name."""
    named = {*recording.known, *recording.uncertain, *recording.session, *parameters}
    return load_with_plays(recording.model, named, recording.beside, make)
