"""Tests of `identification`."""
