"""Calibration of what Xu and Yao 2001 do not report, and what their printed numbers explain."""
