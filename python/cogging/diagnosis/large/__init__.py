"""Effects that make much of the command: seeded by inverse dynamics, largest first, each judged by a refit."""
