"""From a search space to configurations: what a trial draws, and what it starts from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from optuna import Trial
from optuna.distributions import (
    BaseDistribution,
    CategoricalDistribution,
    FloatDistribution,
    IntDistribution,
)

from pipeline.containers import to_dict
from pipeline.errors import PipelineError
from pipeline.learning.config import ModelConfig, TrainConfig
from pipeline.tuning.config import CHOICE, INT, LAYERS, Axis

if TYPE_CHECKING:
    from pipeline.settings import Config

Point = dict[str, Any]


def draw(trial: Trial, config: Config) -> tuple[TrainConfig, ModelConfig]:
    """Draw training and architecture of one trial.

    A list of layers is drawn as its length, ``hidden_layers``, and then a width for each,
    ``hidden_0`` and on: widths that no layer has are not drawn.

    Raises:
        ValueError: The drawn values exclude each other.
    """
    values: Point = {}
    for name, axis in config.tune.space.items():
        if axis.kind == LAYERS:
            count = _suggest(trial, f"{name}_layers", _count(axis))
            values[name] = [_suggest(trial, f"{name}_{i}", _width(axis)) for i in range(int(count))]
        else:
            values[name] = _suggest(trial, name, _distribution(axis))
    return configured(config, values)


def configured(config: Config, values: Point) -> tuple[TrainConfig, ModelConfig]:
    """Return training and architecture with some values in place of the run's own.

    Args:
        config: The run; ``tune`` says how long a trial trains.
        values: By key of train or model.
    """
    tune = config.tune
    train, model = ({k: v for k, v in values.items() if k in vars(g)} for g in groups(config))
    timed = replace(config.train, epochs=tune.epochs, validations=tune.pruner.reports)
    return replace(timed, **train), replace(config.model, **model)


def groups(config: Config) -> tuple[TrainConfig, ModelConfig]:
    """Return the two groups whose keys a search varies."""
    return config.train, config.model


def starting_points(config: Config) -> Iterator[tuple[Point, str]]:
    """Yield the drawn values that each entry of ``tune.start`` stands for.

    A key that an entry leaves out has the run's own value.

    Yields:
        What a trial would have drawn, and why the search space has no such point; empty where it
        has.

    Raises:
        PipelineError: An entry has a key that is not searched.
    """
    own = {**to_dict(config.train), **to_dict(config.model)}
    for entry in config.tune.start:
        for key in entry:
            if key not in config.tune.space:
                axes = ", ".join(config.tune.space)
                raise PipelineError(
                    f"tune.start has {key}, which tune.space does not search. Searched: {axes}"
                )
        point: Point = {}
        problem = ""
        for name, axis in config.tune.space.items():
            for drawn, value, distribution in _parts(name, axis, entry.get(name, own[name])):
                point[drawn] = value
                if not _contains(distribution, value):
                    problem = problem or f"{drawn} = {value} is not in tune.space"
        yield point, problem


def check(config: Config) -> None:
    """Try the ends of every axis, so that a space that cannot be is refused before it is searched.

    Raises:
        PipelineError: A value that train or model refuses.
    """
    known = {name for group in groups(config) for name in vars(group)}
    for name, axis in config.tune.space.items():
        if name not in known:
            raise PipelineError(
                f"tune.space.{name}: a network of model.kind={config.model.kind} has no such key"
            )
        for value in _ends(axis):
            try:
                configured(config, {name: value})
            except ValueError as error:
                # The length of a list may demand less of another axis: only trials show.
                if axis.kind != LAYERS and name != "tanh_layers":
                    raise PipelineError(f"tune.space.{name} may become {value}: {error}") from error


def _ends(axis: Axis) -> list[Any]:
    if axis.kind == CHOICE:
        return list(axis.choices or [])
    if axis.kind == LAYERS:
        assert axis.neurons is not None
        ends = (axis.neurons.low, axis.neurons.high)
        return [[int(width)] * int(_low(axis)) for width in ends]
    return [int(v) if axis.kind == INT else v for v in (_low(axis), _high(axis))]


def _parts(name: str, axis: Axis, value: Any) -> list[tuple[str, Any, BaseDistribution]]:
    """What would be drawn for one value of an axis: name, value and distribution of each draw."""
    if axis.kind != LAYERS:
        return [(name, value, _distribution(axis))]
    widths = list(value)
    parts: list[tuple[str, Any, BaseDistribution]] = [(f"{name}_layers", len(widths), _count(axis))]
    return parts + [(f"{name}_{i}", width, _width(axis)) for i, width in enumerate(widths)]


def _suggest(trial: Trial, name: str, distribution: BaseDistribution) -> Any:
    match distribution:
        case IntDistribution(low=low, high=high, step=step, log=log):
            return trial.suggest_int(name, low, high, step=step, log=log)
        case FloatDistribution(low=low, high=high, step=step, log=log):
            return trial.suggest_float(name, low, high, step=step, log=log)
        case CategoricalDistribution(choices=choices):
            return trial.suggest_categorical(name, choices)
    raise TypeError(f"no draw from {distribution}")


def _distribution(axis: Axis) -> BaseDistribution:
    if axis.kind == CHOICE:
        return CategoricalDistribution(tuple(axis.choices or ()))
    if axis.kind == INT:
        return IntDistribution(
            int(_low(axis)), int(_high(axis)), log=axis.log, step=int(axis.step or 1)
        )
    return FloatDistribution(_low(axis), _high(axis), log=axis.log, step=axis.step)


def _count(axis: Axis) -> IntDistribution:
    return IntDistribution(int(_low(axis)), int(_high(axis)), step=int(axis.step or 1))


def _width(axis: Axis) -> IntDistribution:
    assert axis.neurons is not None
    neurons = axis.neurons
    return IntDistribution(int(neurons.low), int(neurons.high), step=int(neurons.step))


def _contains(distribution: BaseDistribution, value: Any) -> bool:
    if isinstance(distribution, CategoricalDistribution):
        return value in distribution.choices
    try:
        internal = distribution.to_internal_repr(value)
    except (TypeError, ValueError):
        return False
    return bool(distribution._contains(internal))


def _low(axis: Axis) -> float:
    assert axis.low is not None
    return axis.low


def _high(axis: Axis) -> float:
    assert axis.high is not None
    return axis.high
