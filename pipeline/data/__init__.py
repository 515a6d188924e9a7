"""Tables with provenance, and the pose datasets that everything else reads."""
