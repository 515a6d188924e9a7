"""Physical grasping in simulation: scenes, hands, primitives, trials and films."""
