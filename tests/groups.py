"""Groups of conf/ of which none hangs on another."""

PLAIN = (
    "evaluate",
    "sample",
    "suite",
    "reach",
    "protocol",
    "plan",
    "grasp",
    "agent",
    "speech",
    "perception",
    "detector",
)
