"""A measured motor that cogs (LAAS): its axis, its speed loop and its speed ripple, from the logs."""
