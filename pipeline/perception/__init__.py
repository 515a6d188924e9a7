"""Perception of a robot: its camera, detectors, and the places of objects on the table."""
