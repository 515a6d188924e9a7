"""Networks that answer inverse kinematics, trained through differentiable forward kinematics."""
