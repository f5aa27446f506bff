"""Models with broken or absurd parts, and garbage in their state: refused by name, or simulated."""

from __future__ import annotations

import contextlib
import random
import re
import tempfile
import warnings
from collections.abc import Callable, Iterator

import mujoco
import numpy as np

from experiments.soak.batches import report_batch
from tendon_mj.models import load_spec

_STEPS = 12
_NUMBER = re.compile(r'"[^"<]*?-?\d[^"<]*?"')
_NUMBERS = re.compile(r'(?<==")-?[\d.]+(?: -?[\d.]+)*(?=")')
_CONFIG = re.compile(r'<config key="tendon"[^>]*>')
_VALUE = re.compile(r'(key="\w+" value=")([^"]*)(")')
_ABSURD = (
    *("0", "-1", "1e308", "-1e308", "1e-308", "nan", "inf", "-inf", "", " ", "0x10", "1_0", "1,5"),
    *(
        "true",
        "none",
        "1 2",
        "1e400",
        "--1",
        "é",
        "\u200b1",
        "9" * 400,
        "%s%n",
        "../x",
        "4294967297",
    ),
)
_KEYS = (
    *("tendon", "friction", "axial_stiffness", "pretension", "guides", "arc_guides", "reel_joint"),
    *("inner_guides", "input_end", "static_friction", "creep", "creep_time", "backlash", "sensor"),
    *("reel_radius", "output_joint", "output_radius", "instance", "tendon_mass", "extra_bend", "x"),
)


def base_models() -> list[str]:
    """MJCF of the package's models, and of one on which an actuator drives a wrapped tendon."""
    texts = [load_spec(name).to_xml() for name in ("bench", "joint", "finger")]
    return [*texts, DRIVEN]


DRIVEN = """<mujoco><extension><plugin plugin="tendon_mj.sheath"><instance name="s">
  <config key="tendon" value="t"/><config key="friction" value="0.2"/></instance></plugin>
  </extension>
  <worldbody><site name="a" pos="-.2 0 .05"/><body><joint name="j" axis="0 1 0" damping=".02"/>
    <geom type="capsule" fromto="0 0 0 .2 0 0" size=".01" mass=".2"/>
    <geom name="g" type="cylinder" size=".015 .02" euler="90 0 0"/><site name="b" pos=".1 0 .02"/>
  </body></worldbody>
  <tendon><spatial name="t"><site site="a"/><geom geom="g"/><site site="b"/></spatial></tendon>
  <actuator><muscle tendon="t" lengthrange=".1 .5"/></actuator>
  <sensor><plugin plugin="tendon_mj.sheath" instance="s"/></sensor></mujoco>"""


def mutated(text: str, draw: random.Random) -> str:
    """An MJCF text with a few of its parts replaced, removed, doubled or added."""
    for _ in range(draw.randint(0, 5)):  # most by a factor, so that many models remain models
        text = _one(_NUMBERS, text, draw, lambda match: _scaled(match, draw))
    for _ in range(draw.choice([0, 0, 1, 1, 2])):
        kind = draw.randrange(5)
        if kind == 0:  # a value of the plugin's
            text = _one(_VALUE, text, draw, lambda m: m[1] + draw.choice(_ABSURD) + m[3])
        elif kind == 1:  # any number of the model's
            text = _one(_NUMBER, text, draw, lambda _: f'"{draw.choice(_ABSURD)}"')
        elif kind == 2:  # one more attribute of the plugin's
            text = _one(_CONFIG, text, draw, lambda m: m[0] + _more(draw))
        elif kind == 3:  # a line less
            lines = text.split("\n")
            del lines[draw.randrange(len(lines))]
            text = "\n".join(lines)
        else:  # a line twice
            lines = text.split("\n")
            at = draw.randrange(len(lines))
            text = "\n".join([*lines[:at], lines[at], *lines[at:]])
    return text


def _scaled(match: re.Match[str], draw: random.Random) -> str:
    factor = draw.choice([-1.0, 0.0, 0.5, 2.0, 10.0 ** draw.uniform(-4, 4)])
    return " ".join(f"{float(number) * factor:.9g}" for number in match[0].split())


def _more(draw: random.Random) -> str:
    return f'<config key="{draw.choice(_KEYS)}" value="{draw.choice(_ABSURD)}"/>'


def _one(
    pattern: re.Pattern[str], text: str, draw: random.Random, new: Callable[[re.Match[str]], str]
) -> str:
    result = list(pattern.finditer(text))
    if not result:
        return text
    match = draw.choice(result)
    return text[: match.start()] + new(match) + text[match.end() :]


def trials(seed: int, count: int) -> Iterator[tuple[str, str]]:
    """Compile, step, and step again from a garbage state."""
    warnings.simplefilter("ignore")
    mujoco.set_mju_user_warning(lambda _: None)
    draw, numbers = random.Random(seed), np.random.default_rng(seed)
    bases = base_models()
    for _ in range(count):
        text = mutated(draw.choice(bases), draw)
        try:
            model = mujoco.MjModel.from_xml_string(text)
        except ValueError as error:
            yield _refused(str(error))
            continue
        except Exception as error:
            yield "broken", f"{type(error).__name__}: {error}"
            continue
        if model.nv > 5000 or model.npluginstate > 10**6:
            yield "large", ""
            continue
        data = mujoco.MjData(model)
        data.ctrl[:] = numbers.normal(scale=10.0 ** draw.randint(-3, 3), size=model.nu)
        try:
            mujoco.mj_step(model, data, _STEPS)
            _garbage(data.plugin_state, draw, numbers)
            mujoco.mj_step(model, data, _STEPS)
            _garbage(data.qpos, draw, numbers)
            mujoco.mj_step(model, data, _STEPS)
            mujoco.mj_resetData(model, data)
            mujoco.mj_step(model, data)
            yield "simulated", ""
        except mujoco.FatalError:
            yield "MuJoCo's own error", ""


def _refused(message: str) -> tuple[str, str]:
    """Who refused a model, and whether the plugin's refusal lacks the instance."""
    if "engine error" not in message or "tendon_mj" not in message:  # its messages come by this
        return "refused by MuJoCo", ""
    named = "instance '" in message
    return "refused by the plugin", "" if named else f"it names no instance: {message}"


def _garbage(values: object, draw: random.Random, numbers: np.random.Generator) -> None:
    array = np.asarray(values)
    if not array.size:
        return
    kind = draw.randrange(5)
    if kind == 0:
        array[:] = 0.0
    elif kind == 1:
        array[:] = numbers.normal(scale=10.0 ** draw.randint(-8, 12), size=array.size)
    elif kind == 2:
        array[numbers.integers(array.size)] = draw.choice([np.nan, np.inf, -np.inf, 1e308, -1.0])
    elif kind == 3:
        array[:] = numbers.permutation(array)
    else:
        array.view(np.uint8)[:] = numbers.integers(0, 256, array.nbytes, dtype=np.uint8)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        report_batch(trials)  # MuJoCo writes its log where it runs
