"""Scene of the tasks to look at: floor, light and view around the finger, its target in it."""

from __future__ import annotations

import mujoco
import numpy as np

from tendon_mj.attach import show_tension
from tendon_mj.models import JOINTS, Finger, build_finger
from tendon_mj.typing import FloatArray

_HIGHEST_TENSION = 30.0  # of the colours [N]
_CENTRE, _EXTENT = [0.05, 0.0, -0.03], 0.1  # that the free camera looks at [m]
_AZIMUTH, _ELEVATION = 90.0, -9.0  # of that camera [deg]
_RADIUS = 0.0009  # of a tendon as drawn [m]
_FLOOR = -0.137  # its height [m]
_WHITE = [1.0, 1.0, 1.0]
_ARROW = 0.015  # length over force [m/N]
_BESIDE = 0.02  # of the arrows, from the middle of the object along its face [m]
_ACTUAL, _TARGET = (0.59, 0.08, 0.16, 1.0), (0.0, 0.45, 0.7, 0.35)
_PHALANGES = 3  # group of their capsules, which views do not show


def build_scene(finger: Finger) -> mujoco.MjModel:
    """The finger with floor, light and view, its tendons in the colours of their tension.

    It moves as without them.
    """
    spec = show_tension(build_finger(finger), 0.0, _HIGHEST_TENSION)
    head, view, picture = spec.visual.headlight, spec.visual.map, getattr(spec.visual, "global")
    head.ambient, head.diffuse, head.specular = [0.5] * 3, [0.25] * 3, [0.0] * 3
    view.znear, view.shadowclip = 0.02, 1.0
    picture.offwidth, picture.offheight = 1920, 1080
    picture.azimuth, picture.elevation = _AZIMUTH, _ELEVATION
    spec.stat.center, spec.stat.extent = _CENTRE, _EXTENT
    for tendon in spec.tendons:
        tendon.width = _RADIUS
    for site in spec.sites:
        site.rgba[3] = 0.0
    kind, flat = mujoco.mjtTexture.mjTEXTURE_SKYBOX, mujoco.mjtBuiltin.mjBUILTIN_FLAT
    spec.add_texture(
        name="sky", type=kind, builtin=flat, rgb1=_WHITE, rgb2=_WHITE, width=8, height=8
    )
    spec.add_material(name="floor", rgba=[0.9, 0.9, 0.9, 1.0], emission=0.3, specular=0.0)
    world = spec.worldbody
    world.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        material="floor",
        pos=[0.0, 0.0, _FLOOR],
        size=[0.0, 0.0, 0.05],
        contype=0,
        conaffinity=0,
    )
    world.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=[-0.22, -0.5, 0.42],
        dir=[0.2, 0.85, -0.8],
        diffuse=[0.33] * 3,
    )
    return spec.compile()


def draw_forces(scene: mujoco.MjvScene, data: mujoco.MjData, force: float, target: float) -> None:
    """Add a force on the object, red, and its target [N], blue, to a scene, and both numbers."""
    body, kind = data.body("object"), mujoco.mjtGeom.mjGEOM_ARROW
    along_face, _, normal = body.xmat.reshape(3, 3).T
    start = body.xpos + _BESIDE * along_face
    text = f"{force:.1f} of {target:.1f} N"
    for newtons, rgba, width, label in (
        (target, _TARGET, 0.004, text),
        (force, _ACTUAL, 0.002, ""),
    ):
        if newtons > 0.0 and scene.ngeom < scene.maxgeom:
            scene.ngeom += 1  # dm_control's scene has geoms up to here only
            geom = scene.geoms[scene.ngeom - 1]
            mujoco.mjv_initGeom(geom, kind, np.zeros(3), start, np.eye(3).ravel(), rgba)
            mujoco.mjv_connector(geom, kind, width, start, start - _ARROW * newtons * normal)
            geom.label = label


def draw_pose(scene: mujoco.MjvScene, model: mujoco.MjModel, angles: FloatArray) -> None:
    """Add the translucent phalanges of a pose to a scene, (3,) angles of MCP, PIP, DIP [rad]."""
    posed = mujoco.MjData(model)
    for joint, angle in zip(JOINTS, angles, strict=True):
        posed.joint(joint).qpos = angle
    mujoco.mj_kinematics(model, posed)
    option, first = mujoco.MjvOption(), scene.ngeom
    option.geomgroup[:] = option.sitegroup[:] = 0
    option.geomgroup[_PHALANGES] = 1
    dynamic, pert = mujoco.mjtCatBit.mjCAT_DYNAMIC.value, mujoco.MjvPerturb()
    mujoco.mjv_addGeoms(model, posed, option, pert, dynamic, scene)
    for geom in scene.geoms[first : scene.ngeom]:
        geom.rgba[:], geom.category = _TARGET, mujoco.mjtCatBit.mjCAT_DECOR.value
