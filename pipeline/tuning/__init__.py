"""Hyperparameter search with Optuna: studies that stop, resume and end with all trials."""
