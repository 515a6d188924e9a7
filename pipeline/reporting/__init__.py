"""Tables, figures and the report: pure functions of raw rows and cards on disk."""
