"""Tests of `bindings`."""
