"""Where tasks run: processes of this machine, SLURM through submitit, or Ray."""
