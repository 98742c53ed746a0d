"""Tests of the package, one file for each room; `blind` is the blind test bed of `diagnose`."""

from cogging_command import take_signals_of_module

take_signals_of_module("tests")  # the studies that are run as modules are left as the command is
