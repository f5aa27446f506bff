"""Tendon-sheath friction for MuJoCo.

Importing this package registers the engine plugins `tendon_mj.sheath` and `tendon_mj.servo`, so
that models which use them can be loaded. The names below are the public interface; those of the
laboratory (extra `lab`) are loaded when they are first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

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
from tendon_mj.errors import MissingPackageError
from tendon_mj.errors import TendonError as TendonError
from tendon_mj.errors import TendonWarning as TendonWarning
from tendon_mj.plugin import export_library as export_library
from tendon_mj.plugin import register as _register

if TYPE_CHECKING:
    __version__: str

    from tendon_mj.attach import largest_stiffness as largest_stiffness
    from tendon_mj.lab.diagnosis import CATALOGUE as CATALOGUE
    from tendon_mj.lab.diagnosis import Diagnosis as Diagnosis
    from tendon_mj.lab.diagnosis import Effect as Effect
    from tendon_mj.lab.diagnosis import ParameterSpecification as ParameterSpecification
    from tendon_mj.lab.diagnosis import diagnose as diagnose
    from tendon_mj.lab.diagnosis import fit_with_sysid as fit_with_sysid
    from tendon_mj.lab.diagnosis import on_inputs as on_inputs
    from tendon_mj.lab.diagnosis import on_joints as on_joints
    from tendon_mj.lab.diagnosis import on_sensors as on_sensors
    from tendon_mj.lab.diagnosis import on_sheaths as on_sheaths
    from tendon_mj.lab.experiment_design import DriveBounds as DriveBounds
    from tendon_mj.lab.experiment_design import ExperimentBounds as ExperimentBounds
    from tendon_mj.lab.experiment_design import Suggestion as Suggestion
    from tendon_mj.lab.experiment_design import read_bounds as read_bounds
    from tendon_mj.lab.experiment_design import suggest_experiment as suggest_experiment
    from tendon_mj.lab.recordings import Measured as Measured
    from tendon_mj.lab.recordings import Recording as Recording
    from tendon_mj.lab.recordings import Session as Session
    from tendon_mj.lab.recordings import Uncertain as Uncertain
    from tendon_mj.lab.recordings import read_recording as read_recording
    from tendon_mj.lab.recordings import write_recording as write_recording
    from tendon_mj.lab.replay import Parameter as Parameter
    from tendon_mj.lab.replay import Simulates as Simulates
    from tendon_mj.lab.replay import Simulator as Simulator
    from tendon_mj.lab.replay import patch_model as patch_model
    from tendon_mj.lab.replay import read_intervals as read_intervals
    from tendon_mj.lab.replay import replay_error as replay_error
    from tendon_mj.lab.replay import replay_recording as replay_recording
    from tendon_mj.models import example_rig as example_rig
    from tendon_mj.models import load_model as load_model
    from tendon_mj.models import load_spec as load_spec
    from tendon_mj.show import check as check
    from tendon_mj.show import fleet as fleet
    from tendon_mj.show import init as init
    from tendon_mj.show import plot_fit as plot_fit
    from tendon_mj.show import plot_misfit as plot_misfit
    from tendon_mj.show import plot_recording as plot_recording
    from tendon_mj.show import plot_sheath as plot_sheath
    from tendon_mj.show import render_clip as render_clip
    from tendon_mj.show import show_clip as show_clip
    from tendon_mj.show import simulate as simulate
    from tendon_mj.show import sweep as sweep
    from tendon_mj.show import view as view
    from tendon_mj.show import write_report as write_report

# package → names that are loaded from it when they are first used
_LAZY = {
    name: package
    for package, names in {
        "attach": "largest_stiffness",
        "lab.diagnosis": "CATALOGUE diagnose Diagnosis Effect fit_with_sysid on_inputs on_joints "
        "on_sensors on_sheaths ParameterSpecification",
        "lab.experiment_design": "DriveBounds ExperimentBounds read_bounds suggest_experiment "
        "Suggestion",
        "lab.recordings": "Measured read_recording Recording Session Uncertain write_recording",
        "lab.replay": "Parameter patch_model read_intervals replay_error replay_recording "
        "Simulates Simulator",
        "models": "example_rig load_model load_spec",
        "show": "check fleet init plot_fit plot_misfit plot_recording plot_sheath render_clip "
        "show_clip simulate sweep view write_report",
    }.items()
    for name in names.split()
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
    "check",
    "diagnose",
    "example_rig",
    "export_library",
    "fit_with_sysid",
    "fleet",
    "init",
    "largest_stiffness",
    "load_model",
    "load_spec",
    "on_inputs",
    "on_joints",
    "on_sensors",
    "on_sheaths",
    "patch_model",
    "plot_fit",
    "plot_misfit",
    "plot_recording",
    "plot_sheath",
    "read_bounds",
    "read_intervals",
    "read_recording",
    "remove_friction",
    "render_clip",
    "replay_error",
    "replay_recording",
    "show_clip",
    "show_tension",
    "simulate",
    "suggest_experiment",
    "sweep",
    "view",
    "view_sheath",
    "write_recording",
    "write_report",
]


if not TYPE_CHECKING:  # a type checker reads the imports above, and sees misspelt names

    def __getattr__(name: str) -> Any:
        """Load a name of the public interface when it is first used.

        Raises:
            MissingPackageError: it needs the extra `lab`, which is not installed.
        """
        if name == "__version__":
            value: Any = _version()
        elif name in _LAZY:
            try:
                value = getattr(import_module(f"tendon_mj.{_LAZY[name]}"), name)
            except ModuleNotFoundError as error:
                raise MissingPackageError.of_lab(f"tendon_mj.{name}", error) from None
        else:
            raise AttributeError(f"module 'tendon_mj' has no attribute {name!r}")
        globals()[name] = value
        return value


def _version() -> str:
    """Version of the installed package, "unknown" where its sources are used without installing."""
    metadata = import_module("importlib.metadata")  # takes time to load
    try:
        return str(metadata.version("tendon-mj"))
    except metadata.PackageNotFoundError:
        return "unknown"


def __dir__() -> list[str]:
    return __all__


_register()
