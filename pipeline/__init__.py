"""Stages, experiments and reports: everything that is learned, measured or shown."""
