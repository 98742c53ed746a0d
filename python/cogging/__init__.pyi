# What the package offers, for type checkers and for __init__.py, which imports each name when it is first asked for.
from cogging import effects, export, plot
from cogging._core import controllers as _controllers
from cogging._core import references as _references
from cogging._core.controllers import *
from cogging._core.references import *
from cogging._core import (
    CONTROLLERS,
    EFFECTS,
    REFERENCES,
    AxisParameters,
    BSpline,
    CoggingModel,
    CompiledController,
    ControllerError,
    DivergedError,
    EncoderParameters,
    NoiseParameters,
    Performance,
    Plant,
    Reference,
    SplineHarmonics,
    cogging_slope_max,
    desired_compensation_condition,
    desired_compensation_matrix,
    friction_slope_max,
    project,
    replay_controller,
)
from cogging.log_check.log_audit import Audit, audit
from cogging.log_check.log_audit import check_against_model
from cogging.design.bounds import Bounds
from cogging.log_check.controller_check import ControllerCheck, check_controller
from cogging.log_check.controller_recovery import RecoveredController, recover_controller
from cogging.diagnosis.diagnosis_result import Diagnosis
from cogging.diagnosis.location import Location
from cogging.diagnosis.diagnosis import diagnose
from cogging.design.experiment_plan import ExperimentPlan
from cogging.design.motion_limits import MotionLimits
from cogging.design.experiment_plan import plan_experiment
from cogging.diagnosis.locate import locate_gap
from cogging.cpp_library import get_cmake_dir, get_include
from cogging.design.error_prediction import ErrorPrediction
from cogging.design.error_prediction import predict_error
from cogging.files import InputError
from cogging.first_model.model_draft import draft_model
from cogging.first_model.model_draft import ModelDraft
from cogging.friction.friction_curve import FrictionCurve, FrictionModel, fit_friction_curve
from cogging.friction.friction_curve import FrictionParameter
from cogging.design.pid import pid_gains, pid_poles
from cogging.identification.identification_result import Identification
from cogging.identification.identification import identify
from cogging.logs.log import Log, performance, read_log
from cogging.mapping.fit_map import MapFit, fit_map
from cogging.model.controller import Controller, ReferencePoint
from cogging.model.model import Model
from cogging.model.units import Units
from cogging.design.tuning import Tuning, tune
from cogging.design.observer import ObserverDesign, ObserverProblem, design_observer
from cogging.papers.reproduction import compare, reproduce
from cogging.model.parameters import parameters_of
from cogging.simulation.batch import Batch, closed_loop_batch
from cogging.simulation.run import closed_loop
from cogging.simulation.reference import read_reference
from cogging.simulation.parameter_sweep import SweepRuns, sweep
from cogging.file_schema import schema
from cogging.simulation.run import repeat, simulate
from cogging.mapping.error_spectrum import TrackingSpectrum, tracking_spectrum

__version__: str

__all__ = [
    "CONTROLLERS",
    "EFFECTS",
    "REFERENCES",
    "Audit",
    "AxisParameters",
    "BSpline",
    "Batch",
    "Bounds",
    "CoggingModel",
    "CompiledController",
    "Controller",
    "ControllerCheck",
    "ControllerError",
    "Diagnosis",
    "DivergedError",
    "EncoderParameters",
    "ErrorPrediction",
    "ExperimentPlan",
    "FrictionCurve",
    "FrictionModel",
    "FrictionParameter",
    "Identification",
    "InputError",
    "Location",
    "Log",
    "MapFit",
    "Model",
    "ModelDraft",
    "MotionLimits",
    "NoiseParameters",
    "ObserverDesign",
    "ObserverProblem",
    "Performance",
    "Plant",
    "RecoveredController",
    "Reference",
    "ReferencePoint",
    "SplineHarmonics",
    "SweepRuns",
    "TrackingSpectrum",
    "Tuning",
    "Units",
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
    "draft_model",
    "effects",
    "export",
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
    "plan_experiment",
    "plot",
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
    "sweep",
    "tracking_spectrum",
    "tune",
]
__all__ += _controllers.__all__
__all__ += _references.__all__
