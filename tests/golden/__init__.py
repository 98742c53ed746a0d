"""What must not change while the house is rebuilt: a few logs, tables and verdicts as they were."""
