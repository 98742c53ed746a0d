"""Logs: columns over time, from files of any format that is read, and what is wrong with their rows."""
