"""Motions of the tip as Bezier curves, solved in one batch and scaled in time."""

from pipeline.planning.bezier import bezier_curve, bezier_derivative, path_parameter
from pipeline.planning.control import control_points
from pipeline.planning.motion import Motion, plan_motion, tip_path
from pipeline.planning.rotation import slerp, spherical_bezier
from pipeline.planning.timing import Trajectory, time_scale

__all__ = [
    "Motion",
    "Trajectory",
    "bezier_curve",
    "bezier_derivative",
    "control_points",
    "path_parameter",
    "plan_motion",
    "slerp",
    "spherical_bezier",
    "time_scale",
    "tip_path",
]
