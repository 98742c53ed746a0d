"""From a fitted model to controllers: bounds, gains, and the error to be expected."""
