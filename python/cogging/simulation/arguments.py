"""Types of the arguments of public functions, with hints for what users often pass instead."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from cogging._core import Plant, Reference
from cogging.calls import PATH, Kind
from cogging.logs.log import Log
from cogging.model.model import Model

_TO_MODEL = {
    "dict": "Model.from_dict makes a model of it",
    "Plant": "closed_loop(plant, controller, reference) runs one",
    "AxisParameters": "Model(axis=...) makes a model of it",
    "Log": "the log comes before the model",
}
_TO_LOG = {
    "dict": "Log.of makes a log of columns by name",
    "ndarray": "Log(time=..., position=..., command=...) makes a log of columns",
    "DataFrame": "Log.of makes a log of columns by name",
    "Model": "the log comes before the model",
}
_TO_REFERENCE = {
    "PointToPointParameters": "PointToPoint(parameters) is the motion",
    "SineParameters": "Sine(parameters) is the motion",
    "FilteredSineParameters": "FilteredSine(parameters) is the motion",
    "ndarray": "Sampled(time, position) makes a motion of it",
    "Model": "the model comes before the reference",
}

MODEL = Kind((Model, *PATH), "a Model or the path of a model file", hints=_TO_MODEL)
MODEL_ALONE = Kind((Model,), "a Model", hints=_TO_MODEL | {"str": "Model.read reads a model file"})
MODEL_OR_NONE = Kind((Model, type(None)), "a Model", hints=MODEL_ALONE.hints)
LOG = Kind((Log,), "a Log", hints=_TO_LOG | {"str": "read_log reads a file"})
LOGS = Kind((Log, *PATH), "a Log or the path of a log file, or a list of them", several=True, hints=_TO_LOG)
MOTION = Kind((Reference,), "a Reference", hints=_TO_REFERENCE)
REFERENCE = Kind(
    (Reference, Mapping, *PATH), "a Reference, the fields of a reference file or the path of one", hints=_TO_REFERENCE
)
PLANT = Kind((Plant,), "a Plant", hints={"Model": "simulate(model, reference) runs one, model.plant() makes its plant"})
LIST = Kind((Sequence, np.ndarray), "a list")
PLANTS = Kind((Sequence, np.ndarray), "a list, each a Plant")
NUMBER = Kind((int, float, np.number), "a number")
