"""Physical grasping in simulation: scenes, hands, the grasping primitive, trials and films."""
