"""Tables, figures and report.html: a pure function of what the stages left on disk."""
