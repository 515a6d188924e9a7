"""Overrides that make a run small: one robot and few poses."""

TOY = [
    "robot=nico",
    "profile=smoke",
    "dataset.train=600",
    "dataset.validation=60",
    "dataset.test=60",
]
