"""What errors of a real robot would explain the published grasps."""
