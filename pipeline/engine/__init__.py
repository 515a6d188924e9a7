"""Where tasks run: processes of this machine, joblib, SLURM through submitit, or Ray."""
