"""
Every motion that a reference file may name, with its parameters.
"""
from __future__ import annotations
from cogging._core import FilteredSine
from cogging._core import FilteredSineParameters
from cogging._core import PointToPoint
from cogging._core import PointToPointParameters
from cogging._core import Sampled
from cogging._core import Sine
from cogging._core import SineParameters
__all__: list = ['PointToPoint', 'PointToPointParameters', 'Sine', 'SineParameters', 'FilteredSine', 'FilteredSineParameters', 'Sampled']
