"""Calibration of the gains and conditions of Malaize and Levine 2009, and what robustness costs there."""
