"""Play between a joint and the pulley or drum that its cables wind on.

    |q − p| ≤ b/2,   q of the joint, p of the pulley or drum

What pulls on it picks the flank: at an output the load, at a motor the cables against each other.
The pulley is a coordinate of its own: the joint ``<joint>_pulley`` of a body that has no more
inertia than the time step needs. The fixed tendon ``<joint>_play`` is q − p, and its limits are the
flanks: b is the parameter ``<joint>_play.range_width``. Of a motor they are called
``<joint>_drum`` and ``<joint>_drum_play``. In the reference pose, where angles are zeroed, a load
that gravity and springs put on the joint rests on its flank at q = p; without one the joint is in
the middle.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final, NamedTuple, Protocol
from xml.etree.ElementTree import SubElement

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.attach import Mjcf, number_text, numbers
from tendon_mj.errors import TendonError
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay.parameters import DRUM, RANGE_WIDTH, Parameter, stiff_friction
from tendon_mj.lab.units import JOINT, ROUNDING
from tendon_mj.models import load_model, load_spec, model_path
from tendon_mj.plugin import sheath_arrays, sheaths

# A pulley between cables whose guides hold is an oscillator, to which friction may be no damper:
# in the model's steps, and none are longer, it turns by √2 rad of the 2 that are stable.
_STEPS, _INERTIA = 0.5, 0.1  # inertia over stiffness × step², and at most of the joint's
_GIVEN = "stiffness", "damping", "frictionloss"  # what a class may give a joint or a tendon
_SLIDE = mujoco.mjtJoint.mjJNT_SLIDE.value
_MASS, _OWN_INERTIA = "1e-6", "1e-9 1e-9 1e-9"  # a body needs some


class MakeModel(Protocol):
    """Loads a model by its name or file, as `load_model` does."""

    def __call__(self, name: str, *, beside: Path | None = None) -> mujoco.MjModel: ...  # noqa: D102


class _End(NamedTuple):
    """Where cables wind: keys of a sheath for a joint and a radius, and names after the joint."""

    joint: str
    radius: str
    turned: str
    play: str


_OUTPUT: Final = _End("output_joint", "output_radius", "_pulley", "_play")
_DRUM: Final = _End("reel_joint", "reel_radius", DRUM, f"{DRUM}_play")


class _Place(NamedTuple):
    joint: str
    end: _End
    sheaths: dict[str, NDArray[np.void]]  # that wind on it → their states


def _places(model: mujoco.MjModel) -> dict[str, _Place]:
    """Parameter of a play → its place, if the model lacks it and no other has its name.

    A drum on which no cables pull against each other rests on one flank.
    """
    found: dict[tuple[str, _End], dict[str, NDArray[np.void]]] = {}
    data = mujoco.MjData(model)
    for name, sheath in sheaths(model).items():
        state = sheath_arrays(model, data.plugin_state, name, sheath.state).state
        for end in (_OUTPUT, _DRUM):
            if (k := int(state[end.joint])) >= 0:
                found.setdefault((model.joint(k).name, end), {})[name] = state
    taken = {model.tendon(k).name for k in range(model.ntendon)}
    places: dict[str, _Place] = {}
    for (joint, end), states in found.items():
        has_play = f"{joint.removesuffix(end.turned)}{end.play}" in taken
        both_ways = {state["reel_radius"] > 0.0 for state in states.values()} == {True, False}
        name = f"{joint}{end.play}"
        if joint and not has_play and name not in taken and (end is _OUTPUT or both_ways):
            places.setdefault(f"{name}.{RANGE_WIDTH}", _Place(joint, end, states))
    return places


def plays(model: mujoco.MjModel) -> dict[str, Parameter]:
    """Parameters of plays that a model may be given, all 0."""
    kinds = {name: int(model.joint(place.joint).type[0]) for name, place in _places(model).items()}
    units = {name: JOINT["springref"][kind == _SLIDE] for name, kind in kinds.items()}
    return {name: Parameter(0.0, unit, "tendon", 0.0) for name, unit in units.items()}


def add_plays(
    text: Mjcf, spec: mujoco.MjSpec, model: mujoco.MjModel, parameters: Iterable[str]
) -> None:
    """Write the plays that a model lacks of those parameters into its text.

    ``spec`` is of the text, and ``model`` compiled of it.
    """
    places = _places(model)
    for parameter in sorted(places.keys() & {*parameters}):
        _add_play(text, model, places[parameter], in_degrees=bool(spec.compiler.degree))


def _add_play(text: Mjcf, model: mujoco.MjModel, place: _Place, *, in_degrees: bool) -> None:
    """Write a pulley or drum for a joint, on which its sheaths wind in its place."""
    joint, end, states = place
    turned = joint + end.turned
    text.element("joint", joint)  # or it is of a model that this one attaches
    element = model.joint(joint)
    slides = element.type[0] == _SLIDE
    reference = float(element.qpos0[0])
    body = SubElement(text.section("worldbody", ""), "body")
    SubElement(body, "inertial", pos="0 0 0", mass=_MASS, diaginertia=_OWN_INERTIA)
    pulley = SubElement(body, "joint", name=turned, limited="false")
    pulley.set("type", "slide" if slides else "hinge")
    pulley.set(
        "ref", number_text(np.degrees(reference) if in_degrees and not slides else reference)
    )
    pulley.attrib |= dict.fromkeys((*_GIVEN, "springref"), "0") | {"springdamper": "0 0"}
    stiffness = sum(_stiffness(model, state, end.radius) for state in states.values())
    inertia = _STEPS * stiffness * model.opt.timestep**2
    largest = _INERTIA * float(model.dof_M0[element.dofadr[0]])
    pulley.set("armature", number_text(min(inertia, largest) if stiffness else largest))
    solref, solimp = stiff_friction(model)
    low = {-1: 0.0, 0: -0.5, 1: -1.0}[_side(model, joint)]
    flanks = {
        "name": joint + end.play,
        "limited": "true",
        "range": numbers((low, low + 1.0)),  # until its width is set
        "solreflimit": numbers(solref),
        "solimplimit": numbers(solimp),
        **dict.fromkeys((*_GIVEN, "armature"), "0"),
    }
    play = SubElement(text.section("tendon", ""), "fixed", flanks)
    for name, coefficient in ((joint, "1"), (turned, "-1")):
        SubElement(play, "joint", joint=name, coef=coefficient)
    for sheath in states:
        for config in text.plugin(sheath).iterfind("config"):
            if config.get("key") == end.joint:
                config.set("value", turned)


def _stiffness(model: mujoco.MjModel, state: NDArray[np.void], radius: str) -> float:
    """Stiffness of a tendon between a pulley or drum and the next guide [N m/rad or N/m].

    A damper takes c/h off what is stable in a step h: twice, as it acts on the change of a step.
    """
    law, segments = state["law"], float(state["guides"]) + 1.0
    of_segment = float(law["axial_stiffness"]) + 2.0 * float(law["axial_damping"]) / float(
        model.opt.timestep
    )
    length = float(model.tendon_length0[int(state["tendon"])])
    return of_segment * segments / length * float(state[radius]) ** 2


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
    text, spec = Mjcf(source), load_spec(str(source))
    add_plays(text, spec, model, missing)
    with TemporaryDirectory() as folder:
        text.move_to(Path(folder), spec)
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
