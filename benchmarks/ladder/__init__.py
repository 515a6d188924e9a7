"""The ladder of oracles: who is to blame for the trials that are lost."""
