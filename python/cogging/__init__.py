"""Cogging of permanent-magnet linear motors: simulate, control and identify the axis."""

from cogging_command import take_signals_of_module

take_signals_of_module("cogging")  # before what takes long to import

import importlib.metadata

from cogging import effects
from cogging._core import (
    EFFECTS,
    AdaptiveRobustParameters,
    Arc,
    AxisParameters,
    BSpline,
    Cascade,
    CascadeParameters,
    CoggingModel,
    Dcarc,
    DivergedError,
    EncoderParameters,
    FilteredSine,
    FilteredSineParameters,
    NoiseParameters,
    ObserverBased,
    ObserverBasedParameters,
    OutputFeedbackArc,
    OutputFeedbackArcParameters,
    Performance,
    Pid,
    PidParameters,
    Plant,
    PointToPoint,
    PointToPointParameters,
    Reference,
    Sampled,
    Sine,
    SineParameters,
    Speed,
    SpeedParameters,
    SplineHarmonics,
    cogging_slope_max,
    desired_compensation_condition,
    desired_compensation_matrix,
    friction_slope_max,
    performance,
    project,
    replay_controller,
)
from cogging.core_values import as_values
from cogging.log_check.audit import Audit, audit, check_against_model
from cogging.design.bounds import Bounds
from cogging.log_check.controller import ControllerCheck, check_controller
from cogging.log_check.recovery import RecoveredController, recover_controller
from cogging.diagnosis.result import Diagnosis
from cogging.diagnosis.location import Location
from cogging.diagnosis.diagnose import diagnose
from cogging.diagnosis.location import locate_gap
from cogging.design.error_prediction import ErrorPrediction, predict_error
from cogging.cpp_library import get_cmake_dir, get_include
from cogging.files import InputError
from cogging.friction.curve import FrictionCurve, FrictionModel, fit_friction_curve
from cogging.friction.law import FrictionParameter
from cogging.design.pid import pid_gains, pid_poles
from cogging.identification.result import Identification
from cogging.identification.identify import identify
from cogging.logs.log import Log, read_log
from cogging.mapping.fit import fit_map
from cogging.mapping.result import MapFit
from cogging.model.model import Model
from cogging.design.observer import ObserverDesign, ObserverProblem, design_observer
from cogging.papers.reproduction import compare
from cogging.papers.reproduction import reproduce
from cogging.model.parameters import parameters_of
from cogging.simulation.batch import Batch, closed_loop_batch
from cogging.simulation.closed_loop import closed_loop
from cogging.simulation.reference import read_reference
from cogging.file_schema import schema
from cogging.simulation.run import repeat, simulate
from cogging.mapping.error_spectrum import TrackingSpectrum, tracking_spectrum

as_values()
__version__ = importlib.metadata.version("cogging")

__all__ = [
    "EFFECTS",
    "AdaptiveRobustParameters",
    "Arc",
    "Audit",
    "AxisParameters",
    "BSpline",
    "Batch",
    "Bounds",
    "Cascade",
    "CascadeParameters",
    "CoggingModel",
    "ControllerCheck",
    "Dcarc",
    "Diagnosis",
    "DivergedError",
    "EncoderParameters",
    "ErrorPrediction",
    "FilteredSine",
    "FilteredSineParameters",
    "FrictionCurve",
    "FrictionModel",
    "FrictionParameter",
    "Identification",
    "InputError",
    "Location",
    "Log",
    "MapFit",
    "Model",
    "NoiseParameters",
    "ObserverBased",
    "ObserverBasedParameters",
    "ObserverDesign",
    "ObserverProblem",
    "OutputFeedbackArc",
    "OutputFeedbackArcParameters",
    "Performance",
    "Pid",
    "PidParameters",
    "Plant",
    "PointToPoint",
    "PointToPointParameters",
    "RecoveredController",
    "Reference",
    "Sampled",
    "Sine",
    "SineParameters",
    "Speed",
    "SpeedParameters",
    "SplineHarmonics",
    "TrackingSpectrum",
    "audit",
    "check_against_model",
    "check_controller",
    "closed_loop",
    "closed_loop_batch",
    "cogging_slope_max",
    "compare",
    "design_observer",
    "desired_compensation_condition",
    "desired_compensation_matrix",
    "diagnose",
    "effects",
    "fit_friction_curve",
    "fit_map",
    "friction_slope_max",
    "get_cmake_dir",
    "get_include",
    "identify",
    "locate_gap",
    "parameters_of",
    "performance",
    "pid_gains",
    "pid_poles",
    "predict_error",
    "project",
    "read_log",
    "read_reference",
    "recover_controller",
    "repeat",
    "replay_controller",
    "reproduce",
    "schema",
    "simulate",
    "tracking_spectrum",
]


def __dir__() -> list[str]:
    """The public names: what else stands here is the machinery of importing."""
    return sorted(__all__)
