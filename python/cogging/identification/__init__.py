"""From measured logs to a fitted model, with honest intervals."""
