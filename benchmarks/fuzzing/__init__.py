"""The project under attack: odd input, kills, damaged files."""
