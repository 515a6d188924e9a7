"""Run an evaluation twice, one key overridden, and let the project say what changed."""

from pipeline import run_command

RUN = [
    "robot=panda",
    "profile=smoke",
    "dataset.train=200",
    "dataset.validation=50",
    "evaluate.solvers=[lm]",
    "evaluate.batch_sizes=[1]",
]
SETTINGS = {
    "results/example/patient": ["solver.lm.patience=8"],
    "results/example/hasty": ["solver.lm.patience=2"],
}

for folder, overrides in SETTINGS.items():
    run_command("evaluate", [*RUN, *overrides, f"results_dir={folder}"])
run_command("compare", list(SETTINGS))
