"""The published experiments: what each paper prints, what is calibrated, what is predicted."""
