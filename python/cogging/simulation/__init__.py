"""Closed-loop runs of a model, and the motions that they are asked for."""
