"""Hard pose sets by name: what is in each, who generates it, and how answers to it are judged."""
