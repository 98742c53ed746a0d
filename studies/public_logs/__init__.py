"""Public logs of machines that nothing here was tuned on."""
