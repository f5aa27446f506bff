"""The models of `models/` built from numbers, and the loading of any model."""

from tendon_mj.builders.bench import Bench as Bench
from tendon_mj.builders.bench import build_bench as build_bench
from tendon_mj.builders.finger import Finger as Finger
from tendon_mj.builders.finger_spec import build_finger as build_finger
from tendon_mj.builders.joint import Joint as Joint
from tendon_mj.builders.joint import build_joint as build_joint
from tendon_mj.builders.library import load_model as load_model
from tendon_mj.builders.library import load_spec as load_spec
from tendon_mj.builders.library import model_path as model_path
