"""Tendon-sheath friction for MuJoCo.

Importing this package registers the engine plugins `tendon_mj.sheath` and `tendon_mj.servo`, so
that models which use them can be loaded. The names below are the public interface; those that need
SciPy or matplotlib are loaded when they are first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numba

from tendon_mj.attach import Parameters as Parameters
from tendon_mj.attach import Spool as Spool
from tendon_mj.attach import add_friction as add_friction
from tendon_mj.attach import add_sensor as add_sensor
from tendon_mj.attach import add_servo as add_servo
from tendon_mj.attach import add_sites as add_sites
from tendon_mj.attach import add_tendon as add_tendon
from tendon_mj.attach import arc_points as arc_points
from tendon_mj.attach import bent_points as bent_points
from tendon_mj.attach import remove_friction as remove_friction
from tendon_mj.attach import show_tension as show_tension
from tendon_mj.attach import view_sheath as view_sheath
from tendon_mj.engine import register as _register
from tendon_mj.errors import TendonError as TendonError
from tendon_mj.errors import TendonWarning as TendonWarning

if TYPE_CHECKING:
    __version__: str

    from tendon_mj.builders import example_rig as example_rig
    from tendon_mj.builders import load_model as load_model
    from tendon_mj.builders import load_spec as load_spec
    from tendon_mj.diagnosis import CATALOGUE as CATALOGUE
    from tendon_mj.diagnosis import Diagnosis as Diagnosis
    from tendon_mj.diagnosis import Effect as Effect
    from tendon_mj.diagnosis import ParameterSpecification as ParameterSpecification
    from tendon_mj.diagnosis import diagnose as diagnose
    from tendon_mj.diagnosis import fit_with_sysid as fit_with_sysid
    from tendon_mj.diagnosis import on_inputs as on_inputs
    from tendon_mj.diagnosis import on_joints as on_joints
    from tendon_mj.diagnosis import on_sensors as on_sensors
    from tendon_mj.diagnosis import on_sheaths as on_sheaths
    from tendon_mj.next_experiment import DriveBounds as DriveBounds
    from tendon_mj.next_experiment import ExperimentBounds as ExperimentBounds
    from tendon_mj.next_experiment import Suggestion as Suggestion
    from tendon_mj.next_experiment import read_bounds as read_bounds
    from tendon_mj.next_experiment import suggest_experiment as suggest_experiment
    from tendon_mj.recordings import Measured as Measured
    from tendon_mj.recordings import Recording as Recording
    from tendon_mj.recordings import Session as Session
    from tendon_mj.recordings import Uncertain as Uncertain
    from tendon_mj.recordings import read_recording as read_recording
    from tendon_mj.recordings import write_recording as write_recording
    from tendon_mj.replay import Parameter as Parameter
    from tendon_mj.replay import Simulates as Simulates
    from tendon_mj.replay import Simulator as Simulator
    from tendon_mj.replay import patch_model as patch_model
    from tendon_mj.replay import read_intervals as read_intervals
    from tendon_mj.replay import replay_error as replay_error
    from tendon_mj.replay import replay_recording as replay_recording
    from tendon_mj.verification import largest_stiffness as largest_stiffness
    from tendon_mj.view import render_clip as render_clip
    from tendon_mj.view import write_report as write_report

# name -> package that it is loaded from when it is first used
_LAZY = {
    "example_rig": "builders",
    "load_model": "builders",
    "load_spec": "builders",
    "CATALOGUE": "diagnosis",
    "Diagnosis": "diagnosis",
    "Effect": "diagnosis",
    "diagnose": "diagnosis",
    "ParameterSpecification": "diagnosis",
    "fit_with_sysid": "diagnosis",
    "on_inputs": "diagnosis",
    "on_joints": "diagnosis",
    "on_sensors": "diagnosis",
    "on_sheaths": "diagnosis",
    "DriveBounds": "next_experiment",
    "ExperimentBounds": "next_experiment",
    "Suggestion": "next_experiment",
    "read_bounds": "next_experiment",
    "suggest_experiment": "next_experiment",
    "read_intervals": "replay",
    "Measured": "recordings",
    "Recording": "recordings",
    "Session": "recordings",
    "Uncertain": "recordings",
    "read_recording": "recordings",
    "write_recording": "recordings",
    "Parameter": "replay",
    "Simulates": "replay",
    "Simulator": "replay",
    "patch_model": "replay",
    "replay_error": "replay",
    "replay_recording": "replay",
    "largest_stiffness": "verification",
    "render_clip": "view",
    "write_report": "view",
}

__all__ = [
    "CATALOGUE",
    "Diagnosis",
    "DriveBounds",
    "Effect",
    "ExperimentBounds",
    "Measured",
    "Parameter",
    "ParameterSpecification",
    "Parameters",
    "Recording",
    "Session",
    "Simulates",
    "Simulator",
    "Spool",
    "Suggestion",
    "TendonError",
    "TendonWarning",
    "Uncertain",
    "__version__",
    "add_friction",
    "add_sensor",
    "add_servo",
    "add_sites",
    "add_tendon",
    "arc_points",
    "bent_points",
    "diagnose",
    "example_rig",
    "fit_with_sysid",
    "largest_stiffness",
    "load_model",
    "load_spec",
    "on_inputs",
    "on_joints",
    "on_sensors",
    "on_sheaths",
    "patch_model",
    "read_bounds",
    "read_intervals",
    "read_recording",
    "remove_friction",
    "render_clip",
    "replay_error",
    "replay_recording",
    "show_tension",
    "suggest_experiment",
    "view_sheath",
    "write_recording",
    "write_report",
]


if not TYPE_CHECKING:  # a type checker reads the imports above, and sees what is misspelt

    def __getattr__(name: str) -> Any:
        """Load a name of the public interface when it is first used."""
        if name == "__version__":
            value: Any = _version()
        elif name in _LAZY:
            value = getattr(import_module(f"tendon_mj.{_LAZY[name]}"), name)
        else:
            raise AttributeError(f"module 'tendon_mj' has no attribute {name!r}")
        globals()[name] = value
        return value


def _version() -> str:
    """Version of the installed package, "unknown" where its sources are used without installing."""
    metadata = import_module("importlib.metadata")  # not before it is asked for
    try:
        return str(metadata.version("tendon-mj"))
    except metadata.PackageNotFoundError:
        return "unknown"


def __dir__() -> list[str]:
    return __all__


if not numba.config.DISABLE_JIT:  # C calls a plugin's functions, which Python's can't be
    _register()
