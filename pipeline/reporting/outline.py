"""The chapters of the report: what is shown where, in which order."""

from __future__ import annotations

# Anchor, title, lead, tables, figures, stages whose pictures belong there.
OUTLINE: tuple[tuple[str, str, str, tuple[str, ...], tuple[str, ...], tuple[str, ...]], ...] = (
    (
        "paper",
        "Against the paper",
        "The paper's tables with this run beside them, in the paper's own metric.",
        ("table2_numerical_comparison", "table3_neural_comparison"),
        ("against_the_paper",),
        (),
    ),
    (
        "solvers",
        "Who is precise, who is fast",
        "The same poses for every solver; errors recomputed from the joints by Pinocchio.",
        ("precision", "time", "neural_seeds", "paired_comparison"),
        (
            "success_against_tolerance",
            "error_against_time",
            "error_distributions",
            "win_matrix",
            "workspace_map",
        ),
        (),
    ),
    (
        "training",
        "Data, training and search",
        "What the networks learned from, how they learned, and with which settings.",
        (
            "table1_hyperparameters",
            "studies",
            "tuned_against_table_one",
            "datasets",
            "training",
        ),
        ("training_curves",),
        ("tune", "train"),
    ),
    (
        "experiments",
        "Experiments",
        "Runs on demand: losses at equal steps, secondary goals, many solutions of one pose.",
        ("losses", "constraints", "many_solutions"),
        ("losses",),
        ("sample",),
    ),
    (
        "planning",
        "Motion planning",
        "Bezier curves in position, spherical interpolation in rotation, one batched query.",
        ("planner", "planner_routes"),
        ("planner_flips", "planner_times"),
        ("plan",),
    ),
    (
        "grasping",
        "Grasping",
        "Pick, lift and drop in a physics simulation; held by contact and friction alone.",
        ("figure5_grasping", "grasp_success_by", "grasp_studies"),
        ("grasp_outcomes", "grasp_places", "grasp_studies"),
        ("grasp", "grasp_study"),
    ),
    (
        "human_in_the_loop",
        "Human in the loop",
        "The robot sees its table, is told a sentence and acts: camera, detector, agent, body.",
        (
            "figure5_human_in_the_loop",
            "human_in_the_loop_sight",
            "human_in_the_loop_failures",
            "detector",
        ),
        ("human_in_the_loop_outcomes",),
        ("grasp_agent", "detector"),
    ),
)
