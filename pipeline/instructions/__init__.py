"""A suite of instructions with the actions that fulfil them, and how agents do on it."""
