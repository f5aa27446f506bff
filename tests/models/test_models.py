"""Conventions of the models folder, and that each file is what its builder makes."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import os
import re
import tomllib
from pathlib import Path

import mujoco
import numpy as np
import pytest

from experiments.make_finger_shapes import conduit_shape, palm_shapes, phalanx_shapes
from tendon_mj.attach import Parameters, add_sensor
from tendon_mj.models import (
    JOINTS,
    TENDONS,
    Bench,
    Finger,
    Joint,
    build_bench,
    build_finger,
    build_joint,
    load_model,
    load_spec,
    model_names,
)
from tendon_mj.models.load import models_folder
from tendon_mj.plugin import sheaths
from tests.rigs import simulated

BUILDERS = {
    "bench": (Bench(), build_bench),
    "finger": (Finger(), build_finger),
    "joint": (Joint(), build_joint),
}
# in a model's folder, with its numbers
VARIANTS = {"finger_spring": (Finger(), functools.partial(build_finger, spring_return=True))}
ALL = {**BUILDERS, **VARIANTS}
FIELDS = {  # what of an element must be the same in a file and from its builder
    "body": ("body_pos", "body_mass", "body_inertia", "body_ipos"),
    "joint": ("jnt_type", "jnt_pos", "jnt_axis", "jnt_stiffness"),
    "site": ("site_pos",),
    "tendon": ("tendon_length0", "tendon_stiffness"),
    "actuator": ("actuator_trntype", "actuator_gainprm", "actuator_biasprm", "actuator_gear"),
    "sensor": ("sensor_type", "sensor_dim"),
}
PER_DOF = ("damping", "armature", "frictionloss", "solref", "solimp")
PER_JOINT = ("qpos_spring", *(f"dof_{field}" for field in PER_DOF))  # one each here
SIZES = {kind: f"n{kind}" for kind in FIELDS} | {"joint": "njnt", "actuator": "nu"}


def parameters(name):
    """Every entry of a model's parameters.toml by its dotted name."""
    entries = {}

    def walk(table, path):
        if "value" in table:
            entries[".".join(path)] = table
        else:
            for key, entry in table.items():
                walk(entry, [*path, key])

    walk(tomllib.loads((models_folder() / name / "parameters.toml").read_text("utf-8")), [])
    return entries


def flat(numbers):
    """Numbers of parts beside those of the whole, `part_number`."""
    entries = {}
    for key, value in numbers.items():
        parts = value if isinstance(value, dict) else {"": value}
        entries |= {f"{key}_{part}".rstrip("_"): number for part, number in parts.items()}
    return entries


def elements(model, kind):
    """Index of every element of a kind by name."""
    return {getattr(model, kind)(k).name: k for k in range(getattr(model, SIZES[kind]))}


def path_of(model, tendon):
    k = model.tendon(tendon).id
    sites = model.wrap_objid[model.tendon_adr[k] :][: model.tendon_num[k]]
    return [model.site(site).name for site in sites]


def test_every_model_is_held_to_the_conventions_here():
    assert set(model_names()) == set(BUILDERS)


@pytest.mark.parametrize("name", BUILDERS)
def test_a_folder_has_its_five_files(name):
    folder = models_folder() / name
    for file in (f"{name}.xml", "scene.xml", "parameters.toml", "README.md", f"{name}.png"):
        assert (folder / file).is_file(), file
    readme = (folder / "README.md").read_text("utf-8")
    assert f"({name}.png)" in readme
    assert "(parameters.toml)" in readme
    assert f"[{name}]({name}/README.md)" in (models_folder() / "README.md").read_text("utf-8")


@pytest.mark.parametrize("name", BUILDERS)
def test_every_number_has_a_value_a_unit_and_a_source(name):
    entries = parameters(name)
    for key, entry in entries.items():
        assert set(entry) == {"value", "unit", "source"}, key
        assert isinstance(entry["value"], int | float), key
        assert entry["unit"].strip(), key
        assert len(entry["source"]) > 10, key


@pytest.mark.parametrize("name", BUILDERS)
def test_the_builders_defaults_are_the_parameters(name):
    defaults = flat(dataclasses.asdict(BUILDERS[name][0]))
    covered = set()
    for key, entry in parameters(name).items():
        element, _, parameter = key.rpartition(".")
        field = next(f for f in (f"{element}_{parameter}", parameter) if f in defaults)
        assert entry["value"] == pytest.approx(defaults[field], rel=1e-12), key
        covered.add(field)
    assert covered | {"timestep"} == set(defaults)


@pytest.mark.parametrize("name", ALL)
def test_the_file_is_what_the_builder_makes(name):
    file, built = load_model(name), ALL[name][1](ALL[name][0]).compile()
    for kind, fields in FIELDS.items():
        ours, theirs = elements(file, kind), elements(built, kind)
        assert set(ours) == set(theirs), kind
        for element, k in ours.items():
            for field in (*fields, *(PER_JOINT if kind == "joint" else ())):
                a, b = getattr(file, field)[k], getattr(built, field)[theirs[element]]
                near = 1e-6 if field.endswith(("_pos", "_axis", "_length0")) else 1e-12
                np.testing.assert_allclose(a, b, rtol=1e-6, atol=near, err_msg=f"{element} {field}")
    for tendon in (sheath.tendon for sheath in sheaths(file).values()):
        assert path_of(file, tendon) == path_of(built, tendon)
    assert set(sheaths(file)) == set(sheaths(built))
    both = [dict(Parameters(m, mujoco.MjData(m))) for m in (file, built)]
    assert both[0] == pytest.approx(both[1], rel=1e-6)
    assert file.opt.timestep == built.opt.timestep
    assert file.opt.integrator == built.opt.integrator
    np.testing.assert_array_equal(file.opt.gravity, built.opt.gravity)


@pytest.mark.parametrize("name", ALL)
def test_the_file_moves_as_the_builder_does(name):
    answers = []
    for model in (load_model(name), ALL[name][1](ALL[name][0]).compile()):
        data = mujoco.MjData(model)
        size = {"bench": 0.002, "joint": 0.6}.get(name, 3.0)
        for _ in range(500):
            data.ctrl[0] = size * np.sin(3.0 * data.time)
            mujoco.mj_step(model, data)
        answers.append({s: data.sensor(s).data.copy() for s in elements(model, "sensor")})
    assert set(answers[0]) == set(answers[1])
    for sensor, value in answers[0].items():
        np.testing.assert_allclose(value, answers[1][sensor], rtol=1e-5, atol=1e-7, err_msg=sensor)


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("scene", [False, True])
def test_a_second_of_rest_is_rest_without_warnings(name, scene):
    model = load_model(name, scene=scene)
    data = simulated(model)
    before = data.sensordata.copy()
    while data.time < 1.0:
        mujoco.mj_step(model, data)
    assert not any(w.number for w in data.warning)
    np.testing.assert_allclose(data.sensordata, before, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("name", ALL)
def test_a_scene_adds_only_what_is_seen_and_changes_no_motion(name):
    """To the last bit: what it adds neither moves nor touches."""
    bare, scene = load_model(name), load_model(name, scene=True)
    for size in ("nq", "nv", "nu", "nsensor", "ntendon", "nplugin", "nbody"):
        assert getattr(bare, size) == getattr(scene, size), size
    assert "view" in [scene.camera(k).name for k in range(scene.ncam)]
    runs = []
    for model in (bare, scene):
        data = mujoco.MjData(model)
        for _ in range(200):
            data.ctrl[:] = 1e-3 * np.sin(20.0 * data.time)
            mujoco.mj_step(model, data)
        runs.append((data.qpos.copy(), data.qvel.copy(), data.sensordata.copy()))
    for one, other in zip(*runs, strict=True):
        assert np.array_equal(one, other)


def test_the_joints_scene_shows_the_sheath_where_the_guides_are():
    model = load_model("joint", scene=True)
    data = simulated(model)
    centre = [
        0.5 * (data.site(f"guide_1_{k}").xpos + data.site(f"guide_2_{k}").xpos)
        for k in range(1, 17)
    ]
    shown = [
        data.geom_xpos[k]
        for k in range(model.ngeom)
        if model.geom_bodyid[k] == 0 and model.geom_type[k] == mujoco.mjtGeom.mjGEOM_BOX
    ]
    walls, floors = shown[::2], shown[1::2]
    assert len(walls) == len(floors) == len(centre) + 1
    for k, (a, b) in enumerate(itertools.pairwise(centre)):
        middle, way = 0.5 * (a + b), (b - a) / np.linalg.norm(b - a)
        inward = np.array([-way[1], way[0], 0.0])
        np.testing.assert_allclose(walls[k + 1] - middle, 0.0037 * inward, atol=1e-6)
        np.testing.assert_allclose(floors[k + 1] - middle, [0.0, 0.0, -0.0069], atol=1e-6)


def snippets(readme):
    """Python blocks of a page, in order."""
    return re.findall(r"```python\n(.*?)```", readme.read_text("utf-8"), re.S)


@pytest.mark.parametrize(("page", "low", "high"), [(".", 0.3, 0.5), ("finger", 0.5, 10.0)])
def test_a_pages_snippet_runs(page, low, high, capsys):
    (code,) = snippets(models_folder() / page / "README.md")
    exec(code, {})
    assert low < float(capsys.readouterr().out.split("]")[0].strip("[")) < high


def test_the_joints_snippets_run(monkeypatch, tmp_path, capsys):
    build, replay = snippets(models_folder() / "joint" / "README.md")
    names = {}
    exec(build, names)
    assert names["model"].nu == 3
    data = os.environ.get("TENDON_MJ_DATA")
    if not data or not (Path(data) / "tendon_sheath_joint").is_dir():
        pytest.skip("TENDON_MJ_DATA names no folder with tendon_sheath_joint (see docs/data.md)")
    (tmp_path / "data").symlink_to(data)
    (tmp_path / "models").symlink_to(models_folder().resolve())
    monkeypatch.chdir(tmp_path)
    exec(replay, names)
    assert 0.0 < float(capsys.readouterr().out) < 1.0


@pytest.mark.parametrize("name", model_names())
def test_a_model_that_python_added_to_can_be_written_and_read(name):
    spec = load_spec(name)
    sheath = next(p.name for p in spec.plugins if "friction" in p.config)
    add_sensor(spec, sheath, "slip", name="added")
    model = spec.compile()
    again = mujoco.MjModel.from_xml_string(spec.to_xml())
    assert again.nplugin == model.nplugin
    assert again.nsensordata == model.nsensordata


@pytest.mark.parametrize("name", ["finger", "finger_spring"])
def test_the_fingers_shapes_leave_its_dynamics_alone_to_the_bit(name):
    spec = load_spec(name)
    for mesh in list(spec.meshes):
        spec.delete(mesh)
    for geom in list(spec.geoms):
        if geom.type == mujoco.mjtGeom.mjGEOM_MESH or (geom.group == 1 and geom.mass == 0.0):
            spec.delete(geom)
    bare, drawn = spec.compile(), load_model(name)
    assert drawn.nmesh > 0
    assert bare.nmesh == 0
    assert drawn.ngeom > bare.ngeom
    ends = []
    for model in (bare, drawn):
        data = mujoco.MjData(model)
        rows = []
        for _ in range(1500):
            data.ctrl[::2] = np.array([2.2, -1.6])[: model.nu // 2] * np.sin(3.0 * data.time)
            mujoco.mj_step(model, data)
            rows.append(np.concatenate([data.qpos, data.qvel, data.sensordata]))
        ends.append(np.array(rows))
    assert ends[0][:, bare.sensor("tip_force").adr[0] - bare.nsensordata].max() > 0.5  # it presses
    np.testing.assert_array_equal(*ends)


@pytest.mark.parametrize("scene", [False, True])
def test_what_the_finger_is_drawn_with_touches_nothing_and_weighs_nothing(scene):
    model = load_model("finger", scene=scene)
    meshes = model.geom_type == mujoco.mjtGeom.mjGEOM_MESH
    assert not (model.geom_contype | model.geom_conaffinity)[meshes].any()
    assert (model.geom_group[meshes] == 1).all()
    touching = {model.geom(k).name for k in np.flatnonzero(model.geom_contype)}
    assert touching == set(JOINTS)
    assert all(model.geom(name).group[0] == 3 for name in JOINTS)  # viewers do not show these


def test_the_fingers_files_hold_the_shapes_that_the_functions_make():
    made = {**phalanx_shapes(Finger()), **palm_shapes(Finger())}
    made |= {f"{tendon}_conduit": conduit_shape(Finger(), tendon) for tendon in TENDONS}
    spec = load_spec("finger", scene=True)
    assert {mesh.name for mesh in spec.meshes} == set(made)
    for mesh in spec.meshes:
        vertices = np.reshape(mesh.uservert, (-1, 3))
        np.testing.assert_allclose(vertices, made[mesh.name].vertices, atol=1.1e-5)
        assert list(mesh.userface) == list(made[mesh.name].faces.ravel())
