"""Reachability maps: of a grid of places, the share of orientations that a robot reaches there."""
