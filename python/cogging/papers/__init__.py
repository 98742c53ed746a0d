"""The published experiments: setup, numbers and what is calibrated or predicted of each paper."""
