"""Cogging of permanent-magnet linear motors: simulate, control and identify the axis."""

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
    SplineHarmonics,
    closed_loop,
    closed_loop_batch,
    cogging_slope_max,
    desired_compensation_condition,
    desired_compensation_matrix,
    friction_slope_max,
    performance,
    project,
)
from cogging.bounds import Bounds
from cogging.error_prediction import ErrorPrediction, predict_error
from cogging.files import InputError
from cogging.gains import pid_gains, pid_poles
from cogging.logs import Log, read_log
from cogging.map import MapFit, fit_map
from cogging.model import Model
from cogging.observer_design import ObserverDesign, ObserverProblem, design_observer
from cogging.papers import compare, reproduce
from cogging.reference import read_reference
from cogging.simulation import simulate
from cogging.tracking_spectrum import TrackingSpectrum, tracking_spectrum

__version__ = importlib.metadata.version("cogging")

__all__ = [
    "EFFECTS",
    "AdaptiveRobustParameters",
    "Arc",
    "AxisParameters",
    "BSpline",
    "Bounds",
    "Cascade",
    "CascadeParameters",
    "CoggingModel",
    "Dcarc",
    "DivergedError",
    "EncoderParameters",
    "ErrorPrediction",
    "FilteredSine",
    "FilteredSineParameters",
    "InputError",
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
    "Reference",
    "Sampled",
    "Sine",
    "SineParameters",
    "SplineHarmonics",
    "TrackingSpectrum",
    "closed_loop",
    "closed_loop_batch",
    "cogging_slope_max",
    "compare",
    "design_observer",
    "desired_compensation_condition",
    "desired_compensation_matrix",
    "effects",
    "fit_map",
    "friction_slope_max",
    "performance",
    "pid_gains",
    "pid_poles",
    "predict_error",
    "project",
    "read_log",
    "read_reference",
    "reproduce",
    "simulate",
    "tracking_spectrum",
]
