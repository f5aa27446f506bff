"""Bench and finger with MuJoCo's own spatial tendons in place of sheaths, to compare with.

MuJoCo's tendon has stiffness EA/S and spring length S, its length without tension, and no friction.
"""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

from tendon_mj.models import TENDONS, Bench, Finger, build_bench, build_finger


def mujoco_tendon_bench(bench: Bench) -> mujoco.MjSpec:
    """The bench without the plugin; its reel and its tension sensors go."""
    spec = build_bench(bench)
    _replace_sheaths(spec, {"tendon": bench.length}, bench.axial_stiffness, bench.pretension)
    return spec


def mujoco_tendon_finger(finger: Finger) -> mujoco.MjSpec:
    """The finger without the plugin; its tension sensors go.

    A tendon of MuJoCo knows no spool, so its first site rides on a slide with the spool's inertia,
    damping and servo, all carried over by its radius: ξ = r θ.
    """
    spec = build_finger(finger)
    lengths = dict(zip(TENDONS, spec.compile().tendon_length0, strict=True))
    _replace_sheaths(spec, lengths, finger.axial_stiffness, finger.pretension)
    r = finger.spool_radius
    for name in TENDONS:
        body, joint = spec.body(f"{name}_motor"), spec.joint(f"{name}_motor")
        body.mass = 1e-9  # a spool's does not move
        body.inertia = np.full(3, 1e-12)
        joint.type, joint.axis = mujoco.mjtJoint.mjJNT_SLIDE, [-1.0, 0.0, 0.0]
        joint.armature, joint.damping[0] = joint.armature / r**2, joint.damping[0] / r**2
        site = spec.site(f"{name}_sheath_0")
        place = np.array(site.pos) - np.array(body.pos)
        spec.delete(site)
        body.add_site(name=f"{name}_sheath_0", pos=place)
        servo = spec.actuator(f"{name}_angle")
        servo.gainprm[0] /= r
        servo.biasprm[:3] = np.array(servo.biasprm[:3]) / [r, r**2, r**2]
        servo.forcerange = np.array(servo.forcerange) / r
        spec.actuator(f"{name}_torque").gear[0] = finger.gear / r
    return spec


def without_tension_sensors(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """A model with sheaths, less the sensors that one with MuJoCo's own tendons cannot have.

    A sensor that is the sheath's own instance stays: MuJoCo would delete the sheath with it.
    """
    views = {plugin.name for plugin in spec.plugins if "sensor" in plugin.config}
    for sensor in [s for s in spec.sensors if s.plugin.name in views]:
        spec.delete(sensor)
    # a deleted sensor may take its instance along, so the list is read again
    for view in [p for p in spec.plugins if "sensor" in p.config]:
        spec.delete(view)
    return spec


def _replace_sheaths(
    spec: mujoco.MjSpec, lengths: Mapping[str, float], axial_stiffness: float, pretension: float
) -> None:
    """Take the plugin out of a model, and give each tendon the stiffness that its sheath gave it.

    ``lengths`` are of the tendons at the pretension [m].
    """
    for element in [e for e in (*spec.actuators, *spec.sensors) if e.plugin.active]:
        spec.delete(element)
    for plugin in list(spec.plugins):
        spec.delete(plugin)
    for name, length in lengths.items():
        unstretched = length / (1.0 + pretension / axial_stiffness)
        tendon = spec.tendon(name)
        tendon.stiffness[0] = axial_stiffness / unstretched
        tendon.springlength = [0.0, unstretched]
