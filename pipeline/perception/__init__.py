"""What a robot sees: eye cameras, detectors, and the places of objects on the table."""
