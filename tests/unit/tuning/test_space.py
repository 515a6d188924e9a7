"""Search spaces: types, lists of layers, starting points, and what cannot be."""

from __future__ import annotations

import optuna
import pytest

from pipeline.config import compose, group_choices
from pipeline.errors import PipelineError
from pipeline.tuning.objective import check_search
from pipeline.tuning.sampling import make_pruner, make_sampler
from pipeline.tuning.space import draw, starting_points
from robots import available_robots

SMOKE = ("profile=smoke", "robot=nico")


def test_draws_lie_in_the_space_and_keep_their_types() -> None:
    config = compose([*SMOKE, "+tune.space.loss={kind:choice,choices:[smooth,matrix]}"])
    study = optuna.create_study(sampler=make_sampler(config.tune, 0))
    losses, lengths = set(), set()
    for _ in range(40):
        trial = study.ask()
        train, model = draw(trial, config)
        assert train.batch_size in (50, 100, 150, 200)
        assert isinstance(train.batch_size, int)
        assert 1e-3 <= train.learning_rate <= 3e-2
        assert all(isinstance(width, int) and width % 32 == 0 for width in model.hidden)
        assert train.epochs == config.tune.epochs
        # Only the widths of layers that are there are drawn.
        widths = [name for name in trial.params if name.startswith("hidden_")]
        assert len(widths) == 1 + len(model.hidden)
        losses.add(train.loss)
        lengths.add(len(model.hidden))
        study.tell(trial, train.learning_rate)
    assert losses == {"smooth", "matrix"}
    assert lengths == {1, 2, 3}


@pytest.mark.parametrize("robot", available_robots())
def test_table_one_is_in_the_space_of_the_paper_and_comes_first(robot: str) -> None:
    config = compose(["tune=paper", "profile=paper", f"robot={robot}"])
    ((point, problem),) = starting_points(config)
    assert problem == ""
    assert config.tune.trials == 200
    assert config.tune.epochs == 10
    study = optuna.create_study()
    study.enqueue_trial(point)
    train, model = draw(study.ask(), config)
    assert model.hidden == config.robot.table_one.hidden
    assert train.learning_rate == config.robot.table_one.learning_rate
    assert train.position_weight == config.robot.table_one.position_weight


@pytest.mark.parametrize("name", group_choices("tune"))
def test_every_search_of_conf_can_start(name: str) -> None:
    config = compose([f"tune={name}", "robot=nico"])
    check_search(config)
    assert all(problem == "" for _, problem in starting_points(config))


def test_the_run_itself_is_the_start_unless_the_space_has_no_such_point() -> None:
    ((point, problem),) = starting_points(compose([*SMOKE]))
    assert problem == ""
    assert point["hidden_layers"] == 2
    assert (point["hidden_0"], point["hidden_1"]) == (64, 64)
    ((_, problem),) = starting_points(compose([*SMOKE, "model.hidden=[65]"]))
    assert problem == "hidden_0 = 65 is not in tune.space"
    with pytest.raises(PipelineError, match=r"tune\.start has weight_decay"):
        list(starting_points(compose([*SMOKE, "tune.start=[{weight_decay:0.1}]"])))


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("+tune.space.loss={kind:choice,choices:[smooth,l2]}", "may become l2: train.loss"),
        (
            "+tune.space.mean_head_weight={kind:float,low:0,high:2}",
            "may become 2.0: train.mean_head_weight",
        ),
        ("model=flow", "set tune.objective=errors for model.kind=flow"),
    ],
)
def test_a_search_that_no_trial_could_end_is_refused_before_it_starts(
    override: str, words: str
) -> None:
    with pytest.raises(PipelineError, match=words):
        check_search(compose([*SMOKE, override]))


def test_the_samplers_are_what_they_are_called() -> None:
    def spaces(sampler: str) -> set[str]:
        config = compose([*SMOKE, f"tune.sampler={sampler}", "tune.startup=2"])
        study = optuna.create_study(sampler=make_sampler(config.tune, 0))
        for _ in range(6):
            trial = study.ask()
            draw(trial, config)
            study.tell(trial, trial.params["learning_rate"])
        return set(study.ask().relative_params)

    # Grouped: widths that only some trials have are modelled together with the rest of them.
    assert {"learning_rate", "batch_size", "hidden_0"} <= spaces("tpe")
    assert spaces("tpe_independent") == set()
    assert spaces("random") == set()


def test_the_pruner_keeps_what_falls_behind_early_and_cuts_what_never_catches_up() -> None:
    """Annealed trials cross: a high rate looks bad until the last stretch, and ends best."""
    config = compose([*SMOKE, "tune.pruner.startup=10"])
    pruner = make_pruner(config.tune.pruner)
    study = optuna.create_study(pruner=pruner)

    def cut_at(curve) -> int | None:
        trial = study.ask()
        for share in range(10, 101, 10):
            trial.report(curve(share / 100), share)
            if share < 100 and trial.should_prune():
                study.tell(trial, state=optuna.trial.TrialState.PRUNED)
                return share
        study.tell(trial, curve(1.0))
        return None

    # Losses of a rate r: noise r (1 - t) that annealing takes away, over a floor that r lowers.
    rates = [0.1 * (1 + index % 9) for index in range(12)]
    for rate in rates:
        assert cut_at(lambda t, rate=rate: rate * (1 - t) + 0.2 / (1 + 9 * rate * t)) is None
    assert cut_at(lambda t: (1 - t) + 0.2 / (1 + 9 * t)) is None  # last half-way, first in the end
    assert cut_at(lambda t: 5.0) == 20  # never moves
    ranking = compose([*SMOKE, "tune.pruner.kind=percentile", "tune.pruner.after=0.5"])
    study.pruner = make_pruner(ranking.tune.pruner)
    assert cut_at(lambda t: (1 - t) + 0.2 / (1 + 9 * t)) == 50  # what ranking half-way would do
