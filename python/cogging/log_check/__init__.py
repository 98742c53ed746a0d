"""Whether a log is what it says it is: time base, columns, controller."""
