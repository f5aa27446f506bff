"""Laws of a policy that drives a sweep: it sees the readings, sets the controls, and no more."""

import mujoco
import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.lab.sweep import Sweep, motion_recording, read_policy, run_sweep
from tendon_mj.lab.workers import Workers
from tendon_mj.models import load_model
from tests.refusals import refusing
from tests.rigs import lever

POLICIES = '''
from dataclasses import dataclass

import numpy as np


def nothing(model, data):
    """Leave the controls as the motion has them."""


def pull(model, data):
    data.ctrl[:] = 3.0 * np.minimum(1.0, data.time / 0.02)


@dataclass
class Hold:
    """Integrate the error of an angle, from 0 in every rollout."""

    model: object
    sum: float = 0.0

    def __call__(self, model, data):
        assert model is self.model
        self.sum += 0.4 - data.sensor("angle").data[0]
        data.ctrl[0] = 0.05 * self.sum


def divide(model, data):
    data.ctrl[0] = 1.0 / 0 if data.time > 0.01 else 0.0


class Broken:
    def __init__(self, model):
        raise OSError("no weights.npz")


class Heavy:
    """Make the model heavier once it is made, and stiffer at each step."""

    def __init__(self, model):
        model.opt.gravity[2] *= 2.0

    def __call__(self, model, data):
        model.jnt_stiffness[:] += 0.1
        data.ctrl[0] = 1.0


word = "pull"
'''

ARM = lever(
    '<motor name="pull" joint="elbow"/>',
    '<jointpos name="angle" joint="elbow"/><actuatorfrc name="force" actuator="pull"/>',
    joint='name="elbow" stiffness="1" damping="1"',
    geom='size=".1" pos=".2 0 0"',
)


@pytest.fixture
def policy(tmp_path):
    (tmp_path / "acts.py").write_text(POLICIES)
    return lambda name: read_policy(f"{tmp_path / 'acts.py'}:{name}")


@pytest.fixture(scope="module")
def arm():
    return mujoco.MjModel.from_xml_string(ARM)


def arm_sweep(arm, policy, *varied, **options):
    recording = motion_recording("arm", arm, None, 0.1, still=True)
    return Sweep(arm, recording, varied or ["elbow.damping=1,2,1"], policy=policy, **options)


def table(sweep):
    return sweep.rollouts.of(sweep.batch(0, sweep.design.rollouts))


@pytest.mark.parametrize("settle", [0.0, 0.02])
def test_a_policy_that_does_nothing_leaves_the_motion_to_the_bit(policy, settle):
    model = load_model("finger")
    recording = motion_recording("finger", model, "tap", 0.05)
    varied = ["flexor.friction=0.05:0.3:3"]
    plain = table(Sweep(model, recording, varied, settle=settle))
    acted = table(Sweep(model, recording, varied, settle=settle, policy=policy("nothing")))
    assert plain.keys() == acted.keys()
    assert all((plain[name] == acted[name]).all() for name in plain)


def test_a_policy_is_what_mujoco_does_with_it(policy, arm):
    rows = table(arm_sweep(arm, policy("pull"), settle=0.0))
    data, force, angle = mujoco.MjData(arm), [], []
    for _ in range(51):
        data.ctrl[0] = 3.0 * min(1.0, data.time / 0.02)
        mujoco.mj_step(arm, data)
        angle.append(data.sensordata[0])
        force.append(data.sensordata[1])
    assert rows["force.mean"][0] == np.mean(force)
    assert rows["angle.final"][0] == angle[-1]


def test_each_rollout_has_an_instance_of_its_own(policy, arm):
    first, _, again = table(arm_sweep(arm, policy("Hold")))["angle.final"]
    assert first == again > 0.0


def test_what_a_policy_changes_of_the_model_holds_in_that_rollout_alone(policy, arm):
    sweep = arm_sweep(arm, policy("Heavy"))
    whole = table(sweep)["angle.final"]
    assert whole[0] == whole[2] != whole[1]
    parts = [sweep.rollouts.of(sweep.batch(k, 1))["angle.final"][0] for k in (2, 1, 0)]
    assert parts == whole[::-1].tolist()
    assert whole.tolist() == table(arm_sweep(arm, policy("Heavy")))["angle.final"].tolist()


def test_workers_need_no_file(policy, arm, tmp_path):
    pytest.importorskip("pyarrow", reason="the extra tendon-mj[parquet] is not installed")
    sweep = arm_sweep(arm, policy("Hold"))
    (tmp_path / "acts.py").unlink()
    rows = run_sweep(sweep, tmp_path / "out", on=Workers(processes=2)).table.read()
    assert (rows["angle.final"] == table(sweep)["angle.final"]).all()


def test_another_policy_is_another_sweep(policy, arm, tmp_path):
    pytest.importorskip("pyarrow", reason="the extra tendon-mj[parquet] is not installed")
    run_sweep(arm_sweep(arm, policy("pull")), tmp_path / "out", on=Workers(processes=1))
    (tmp_path / "acts.py").write_text(POLICIES.replace("3.0", "4.0"))
    with refusing(InvalidValueError, str(tmp_path / "out"), "policy is"):
        run_sweep(arm_sweep(arm, policy("pull")), tmp_path / "out", on=Workers(processes=1))


@pytest.mark.parametrize(
    ("name", "kind", "facts"),
    [
        ("pul", UnknownNameError, ["did you mean 'pull'"]),
        ("Broken", InvalidValueError, ["OSError", "no weights.npz", "Broken(model)"]),
        ("word", InvalidValueError, ["word"]),
    ],
)
def test_a_policy_that_cannot_be_made_is_refused_by_name(name, kind, facts, policy, arm):
    with refusing(kind, "acts.py", *facts):
        arm_sweep(arm, policy(name))


@pytest.mark.parametrize(
    ("text", "facts"), [("def pull(:", ["SyntaxError"]), ("raise SystemExit(3)", ["SystemExit: 3"])]
)
def test_a_file_that_cannot_be_imported_is_refused(text, facts, arm, tmp_path):
    (tmp_path / "bad.py").write_text(text)
    with refusing(InvalidValueError, "bad.py", *facts):
        arm_sweep(arm, read_policy(f"{tmp_path / 'bad.py'}:pull"))


def test_a_policy_that_fails_is_refused_with_its_rollout_and_time(policy, arm):
    with refusing(InvalidValueError, "rollout 0", "ZeroDivisionError", "time 0.01"):
        table(arm_sweep(arm, policy("divide")))
    with refusing(InvalidValueError, "pull.command_scale", "acts.py"):
        arm_sweep(arm, policy("pull"), "pull.command_scale=0.9:1.1")


@pytest.mark.parametrize(
    "body",
    ["global n; n += 1; data.ctrl[:] = n", "data.ctrl[:] = np.random.default_rng().random()"],
)
def test_a_policy_that_does_not_repeat_itself_is_refused(body, tmp_path, arm):
    file = tmp_path / "acts.py"
    file.write_text(f"import numpy as np\nn = 0\ndef act(model, data):\n    {body}\n")
    sweep = arm_sweep(arm, read_policy(f"{file}:act"))
    with pytest.raises(InvalidValueError, match="the same rollout simulated twice differs"):
        sweep.seconds()
