"""Friction against steady speed."""
