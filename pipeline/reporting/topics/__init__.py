"""What a report is about: one file a topic, with its tables and its figures."""
