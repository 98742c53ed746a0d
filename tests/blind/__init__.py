"""Blind test bed of `cogging diagnose`: machines with a hidden effect, by code that shares nothing with the core."""

import os

# Before numpy is imported, and for the worker processes: each case runs on a core of its own.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
