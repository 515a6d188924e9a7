"""Motions of the tip as Bezier curves, solved in one batch and scaled in time."""

import baselines  # noqa: F401 - sets the folder of its own compiled functions, so it comes first
from robots.compiled_cache import use_own_folder

# Before the imports below declare compiled functions.
use_own_folder("pipeline/planning", "baselines", "robots")

from pipeline.planning.bezier import bezier_curve, bezier_derivative, path_parameter  # noqa: E402
from pipeline.planning.motion import Motion, plan_motion  # noqa: E402
from pipeline.planning.path import control_points, tip_path  # noqa: E402
from pipeline.planning.rotation import slerp, spherical_bezier  # noqa: E402
from pipeline.planning.timing import Trajectory, time_scale  # noqa: E402

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
