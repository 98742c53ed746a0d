"""
Every controller that a model file may name, with its parameters.
"""
from __future__ import annotations
from cogging._core import AdaptiveRobustParameters
from cogging._core import Arc
from cogging._core import Cascade
from cogging._core import CascadeParameters
from cogging._core import Dcarc
from cogging._core import ObserverBased
from cogging._core import ObserverBasedParameters
from cogging._core import OutputFeedbackArc
from cogging._core import OutputFeedbackArcParameters
from cogging._core import Pid
from cogging._core import PidParameters
from cogging._core import Speed
from cogging._core import SpeedParameters
__all__: list = ['Pid', 'PidParameters', 'Cascade', 'CascadeParameters', 'Speed', 'SpeedParameters', 'Arc', 'AdaptiveRobustParameters', 'Dcarc', 'OutputFeedbackArc', 'OutputFeedbackArcParameters', 'ObserverBased', 'ObserverBasedParameters']
