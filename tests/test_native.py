"""The library of compiled functions, from Python without Numba and from C without Python."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tendon_mj import load_spec
from tendon_mj.native import ARRAYS, library, load
from tendon_mj.native.marks import ENTRIES
from tendon_mj.plugin import export_library
from tendon_mj.plugin.sheath_plugin.attributes import ATTRIBUTES
from tests.plugin import test_refusals, test_sensor_objects, test_servo_refusals
from tests.rigs import config

ROOT = Path(__file__).parents[1]
C_LIBRARY = {
    *("malloc", "free", "memcpy", "memset", "strlen", "strstr", "strtod", "localeconv"),
    *("exp", "exp2", "expm1", "log", "pow", "sin", "cos", "sincos", "atan2", "gcvt"),
    *("dlopen", "dlsym", "dl_iterate_phdr"),
}
COMPILER = shutil.which("cc") or shutil.which("gcc")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="there is no C compiler")


def run(code, **options):
    command = [sys.executable, "-W", "error", "-c", code]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


@pytest.mark.skipif(shutil.which("nm") is None, reason="there is no nm")
def test_it_needs_the_c_library_alone():
    """MuJoCo's functions are found in the process, wherever that has loaded them."""
    command = ["nm", "-D", "--undefined-only", str(load().path)]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    needed = {line.split()[1].split("@")[0] for line in listed.splitlines() if " U " in line}
    assert needed <= C_LIBRARY


def test_a_process_with_mujoco_alone_can_load_it(tmp_path):
    """MuJoCo's symbols are not visible there, as in a host that loads MuJoCo as a plugin."""
    file = written(tmp_path)
    code = f"""
import mujoco
mujoco.mj_loadPluginLibrary({str(export_library(tmp_path))!r})
model = mujoco.MjModel.from_xml_path({file!r})
data = mujoco.MjData(model)
mujoco.mj_step(model, data)
print(data.plugin_state.any())
"""
    done = run(code)
    assert (done.returncode, done.stdout) == (0, "True\n"), done.stderr
    done = run(code + "import tendon_mj")
    assert done.returncode == 1
    assert "another copy of the library" in done.stderr.splitlines()[-1]


def test_another_source_is_another_library(monkeypatch, tmp_path):
    package = tmp_path / "tendon_mj"
    for name in library._SOURCES:
        shutil.copytree(ROOT / "tendon_mj" / name, package / name)
    monkeypatch.setattr(library, "_PACKAGE", package)
    before = library.digest.__wrapped__()
    assert before == library.digest()
    file = package / "sheath" / "segment_law.py"
    file.write_text(file.read_text("utf-8") + "\n", "utf-8")
    assert library.digest.__wrapped__() != before


def test_without_a_library_and_without_numba_a_sentence_says_what_to_install(tmp_path):
    shutil.copytree(
        ROOT / "tendon_mj",
        tmp_path / "tendon_mj",
        ignore=shutil.ignore_patterns("libraries", "__pycache__"),
    )
    block = "import sys\nsys.modules['numba'] = sys.modules['llvmlite'] = None\n"
    options = {"cwd": tmp_path, "env": {"XDG_CACHE_HOME": str(tmp_path), "PATH": ""}}
    done = run(block + "import tendon_mj", **options)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].endswith("is not installed: pip install numba")


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="Windows has other permissions")
def test_a_library_that_others_may_write_is_not_loaded(tmp_path):
    file = tmp_path / "library.so"
    file.write_bytes(b"")
    file.chmod(0o755)
    assert library._is_trusted(file)
    file.chmod(0o777)  # as a package's own may be, whose other files are run too
    assert not library._is_trusted(file)
    assert not library._is_trusted(tmp_path / "none")


PROGRAM = r"""
#include <mujoco/mujoco.h>
#include <stdio.h>
#include <string.h>
int main(int argc, char** argv) {
  char error[1000] = "";
  mj_loadPluginLibrary(argv[1]);
  int is_binary = strstr(argv[2], ".mjb") != NULL;
  mjModel* m = is_binary ? mj_loadModel(argv[2], NULL)
                         : mj_loadXML(argv[2], NULL, error, sizeof error);
  if (!m) {
    fprintf(stderr, "%s\n", error);
    return 1;
  }
  mjData* d = mj_makeData(m);
  for (int k = 0; k < 10000; k++) {
    for (int i = 0; i < m->nu; i++) d->ctrl[i] = 1e-3 * (k % 200);
    mj_step(m, d);
  }
  fwrite(d->qpos, sizeof(mjtNum), m->nq, stdout);
  fwrite(d->sensordata, sizeof(mjtNum), m->nsensordata, stdout);
  fwrite(d->plugin_state, sizeof(mjtNum), m->npluginstate, stdout);
  mj_deleteData(d);
  mj_deleteModel(m);
  return 0;
}
"""


def compiled_program(folder, code):
    """Command of a C program, with the library; a model comes after it."""
    (folder / "program.c").write_text(code)
    package = Path(mujoco.__file__).parent
    engine = next(package.glob("libmujoco*"))
    command = [COMPILER, "-o", "program", "program.c", f"-I{package / 'include'}", str(engine)]
    subprocess.run([*command, f"-Wl,-rpath,{package}", "-lm"], cwd=folder, check=True)
    return [str(folder / "program"), str(export_library(folder))]


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """Command that simulates a model."""
    return compiled_program(tmp_path_factory.mktemp("c"), PROGRAM)


def model_file(name, folder):
    """Path of a model of the package, or of the rig."""
    if name == "rig":
        return written(folder)
    spec = load_spec(name)
    spec.compile()
    file = folder / "model.xml"
    file.write_text(spec.to_xml(), "utf-8")
    return str(file)


@needs_compiler
@pytest.mark.parametrize("name", ["bench", "joint", "finger", "rig"])
def test_a_program_in_c_simulates_the_same_to_the_bit(name, program, tmp_path):
    file = model_file(name, tmp_path)
    model = mujoco.MjModel.from_xml_path(file)
    data = mujoco.MjData(model)
    for k in range(10000):
        data.ctrl[:] = 1e-3 * (k % 200)
        mujoco.mj_step(model, data)
    binary = str(tmp_path / "model.mjb")
    mujoco.mj_saveModel(model, binary, None)
    expected = np.concatenate([data.qpos, data.sensordata, data.plugin_state])
    for saved in (file, binary):
        done = subprocess.run([*program, saved], capture_output=True, check=True)
        np.testing.assert_array_equal(np.frombuffer(done.stdout), expected)


@needs_compiler
def test_the_program_of_the_page_prints_a_tension(tmp_path):
    (code,) = re.findall(r"```c\n(.*?)```", (ROOT / "docs" / "c.md").read_text("utf-8"), re.S)
    file = tmp_path / "bench.xml"
    file.write_text(load_spec("bench").to_xml(), "utf-8")
    command = [*compiled_program(tmp_path, code), str(file)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert re.fullmatch(r"output tension: \d+\.\d\d N\n", done.stdout)


RIG = """
<mujoco>
  <extension>
    <plugin plugin="tendon_mj.sheath"><instance name="sheath">{sheath}</instance></plugin>
    <plugin plugin="tendon_mj.servo"><instance name="servo">{servo}</instance></plugin>
  </extension>
  <worldbody>
    <body><joint name="motor" axis="0 0 1" armature="1e-3"/><geom size=".01"/></body>
    <body><joint name="ball" type="ball"/><geom size=".01"/><site name="b" pos="1 0 0"/></body>
    <site name="a"/>
  </worldbody>
  <tendon>
    <spatial name="t"><site site="a"/><site site="b"/></spatial>
    <fixed name="fixed"><joint joint="motor" coef="1"/></fixed>
  </tendon>
  <actuator><plugin plugin="tendon_mj.servo" instance="servo" joint="motor"/></actuator>
</mujoco>
"""
SERVO = {"tendon": "t", "tension_gain": "2", "velocity_gain": "0.01"}
SHEATH = {"tendon": "t", "friction": "0.1", "axial_stiffness": "1e3", "pretension": "1"}
SHEATH |= {"reel_joint": "motor", "reel_radius": "0.01"}


def written(folder, **changed):
    """Path of the rig with changed attributes of its sheath and its servo."""
    given = {
        kind: {key: value or None for key, value in {**law, **changed.get(kind, {})}.items()}
        for kind, law in (("sheath", SHEATH), ("servo", SERVO))
    }
    file = folder / "rig.xml"
    file.write_text(RIG.format(**{kind: config(**law) for kind, law in given.items()}), "utf-8")
    return str(file)


READER = r"""
#include <mujoco/mujoco.h>
#include <stdio.h>
int main(int argc, char** argv) {
  mj_loadPluginLibrary(argv[1]);
  for (int k = 2; k < argc; k++) {
    char error[2000] = "";
    mjModel* m = mj_loadXML(argv[k], NULL, error, sizeof error);
    printf("%s%c", m ? "" : error, 0);
    if (m) mj_deleteModel(m);
  }
  return 0;
}
"""


@needs_compiler
def test_c_and_python_refuse_the_same_in_the_same_words(tmp_path):
    """But for the names that may be meant, which Python lists behind them."""
    texts = [
        *(test_refusals.hand(sheaths, **more) for sheaths, more, _ in test_refusals.REFUSED),
        *(test_servo_refusals.mjcf(**values) for values, *_ in test_servo_refusals.CASES),
        *(test_sensor_objects.mjcf(sensor) for sensor, _ in test_sensor_objects.REFUSED),
    ]
    files = [tmp_path / f"{k}.xml" for k in range(len(texts))]
    for file, text in zip(files, texts, strict=True):
        file.write_text(text, "utf-8")
    command = [*compiled_program(tmp_path, READER), *map(str, files)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path)
    for file, in_c in zip(files, done.stdout.split("\0"), strict=False):
        with pytest.raises(ValueError, match="plugin tendon_mj") as refused:
            mujoco.MjModel.from_xml_path(str(file))
        in_python = str(refused.value).splitlines()[0]
        said, _, listed = in_python.partition(in_c.splitlines()[0])
        assert said == "", in_python
        assert listed.startswith(("; did you mean", " (there")) == ("unknown" in in_c), in_python


@needs_compiler
def test_a_wrong_attribute_of_a_binary_model_is_refused_in_c(program, tmp_path):
    file = tmp_path / "model.mjb"
    mujoco.mj_saveModel(mujoco.MjModel.from_xml_path(written(tmp_path)), str(file), None)
    file.write_bytes(file.read_bytes().replace(b"\x001e3\x00", b"\x00-13\x00"))
    done = subprocess.run([*program, str(file)], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 1, done
    assert "instance 'sheath': axial_stiffness = -13 [N]" in done.stderr


@needs_compiler
@pytest.mark.parametrize(
    ("name", "slots", "where"),
    [
        ("rig", (0, 1), "reserved.0 instance 'sheath'"),
        ("rig", (17, 16), "servo instance 'sheath'"),
        ("bench", 15, "reserved.15 instance 'input_tension'"),  # a sensor, of which it asks first
    ],
)
def test_a_binary_model_with_its_plugins_in_other_slots_is_refused(
    name, slots, where, program, tmp_path
):
    model = mujoco.MjModel.from_xml_path(model_file(name, tmp_path))
    model.plugin[:] = slots
    file = str(tmp_path / "model.mjb")
    mujoco.mj_saveModel(model, file, None)
    options = {"capture_output": True, "text": True, "check": False, "cwd": tmp_path}
    done = subprocess.run([*program, file], **options)
    assert done.returncode == 1, done
    assert f"tendon_mj.{where}: " in done.stderr


LOCALE = """
import locale, sys, mujoco, tendon_mj
model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
try:
    locale.setlocale(locale.LC_ALL, sys.argv[2])
except locale.Error:
    print("none")
    sys.exit()
kept = data.plugin_state.copy()
mujoco.mj_resetData(model, data)
print((kept == data.plugin_state).all() and (mujoco.MjData(model).plugin_state == kept).all())
"""


def test_numbers_are_read_alike_under_every_locale(tmp_path):
    command = [sys.executable, "-c", LOCALE, written(tmp_path)]
    for name in ("de_DE.UTF-8", "fr_FR.UTF-8", "C.UTF-8"):
        done = subprocess.run([*command, name], capture_output=True, text=True, check=True)
        assert done.stdout in ("True\n", "none\n")


def test_the_exported_header_names_every_attribute(tmp_path):
    path = export_library(tmp_path)
    before = path.stat().st_ino
    assert export_library(tmp_path) == path
    assert path.stat().st_ino != before  # one in use is replaced and not overwritten
    header = (tmp_path / "tendon_mj.h").read_text("utf-8")
    for name in (*ATTRIBUTES, "tension_gain", "backdrive"):
        assert f'"{name}"' in header


@pytest.mark.long
def test_an_object_without_a_c_compiler_is_linked_in_the_process_and_does_the_same(tmp_path):
    from tendon_mj.native.compiler import compile_object

    path = tmp_path / "library.o"
    path.write_bytes(compile_object(ENTRIES))
    loaded = library.Library(path)
    assert all(loaded.address(symbol) for symbol in (*ENTRIES, *ARRAYS))


@pytest.mark.long
def test_it_can_be_emitted_for_other_processors(tmp_path):
    from tendon_mj.native.compiler import compile_object

    machine_code = compile_object(ENTRIES, "aarch64-unknown-linux-gnu")
    assert machine_code[:4] == b"\x7fELF"
    assert machine_code[18] == 183  # EM_AARCH64
    assert all(symbol.encode() in machine_code for symbol in ENTRIES)
