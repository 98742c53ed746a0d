"""Tests of `estimation`."""
