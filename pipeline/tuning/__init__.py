"""Hyperparameter search with Optuna: studies that stop, go on, and end with the asked trials."""
