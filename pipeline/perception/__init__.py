"""What a robot sees: eye cameras, detectors, and the places of things on the table."""
