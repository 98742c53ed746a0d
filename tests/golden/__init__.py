"""What must not change unnoticed: a few logs and verdicts as they were."""
