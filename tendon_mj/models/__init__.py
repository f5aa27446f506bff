"""Models built from parameters (`models/` holds those with the defaults), and loading by name."""

from tendon_mj.models.bench import Bench as Bench
from tendon_mj.models.bench import build_bench as build_bench
from tendon_mj.models.finger import JOINTS as JOINTS
from tendon_mj.models.finger import TENDON_COLOUR as TENDON_COLOUR
from tendon_mj.models.finger import TENDONS as TENDONS
from tendon_mj.models.finger import Finger as Finger
from tendon_mj.models.finger import build_finger as build_finger
from tendon_mj.models.finger import sheath_points as sheath_points
from tendon_mj.models.finger import spool_angles as spool_angles
from tendon_mj.models.joint import Joint as Joint
from tendon_mj.models.joint import build_joint as build_joint
from tendon_mj.models.load import example_recording as example_recording
from tendon_mj.models.load import example_rig as example_rig
from tendon_mj.models.load import load_model as load_model
from tendon_mj.models.load import load_spec as load_spec
from tendon_mj.models.load import model_digest as model_digest
from tendon_mj.models.load import model_names as model_names
from tendon_mj.models.load import model_path as model_path
