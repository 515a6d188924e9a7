"""A bump chart: who is where in several rankings of the same solvers, and where they cross."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Sized
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from pipeline.presentation.naming import robot_title, solver_title
from pipeline.presentation.style import INK, SOFT, Look, looks, panels

WIDTH, HEIGHT, MARGIN = 1.3, 0.52, 1.9  # inch: of a ranking, of a solver, of labels and headings
TIE_HALF_WIDTH, TIE_PAD = 0.26, 0.33  # of the frame around those that are tied, in rankings, slots
NUMBERS = ("one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
TIE_COLOUR = "#e9edf1"
LABEL_GAP = 0.32  # from a marker to the name beside it, in rankings


@dataclass(frozen=True)
class Place:
    """Where a solver is in a ranking.

    Attributes:
        solver: Its name.
        rank: 1 the best; equal ones are tied.
        value: What it is ranked by, as it is written below its marker.
    """

    solver: str
    rank: int
    value: str


@dataclass(frozen=True)
class Stop:
    """One ranking.

    Attributes:
        title: Above it.
        by: What it ranks by; several lines below the title.
        places: Of its solvers, in any order.
    """

    title: str
    by: str
    places: Sequence[Place]


def slots(stops: Sequence[Stop]) -> list[dict[str, int]]:
    """Give each solver a slot of its own in each ranking, 0 the uppermost.

    Those that are tied stand together, in the order of the ranking before; in the first one in the
    order of the next that tells them apart.
    """
    found: list[dict[str, int]] = []
    for number, stop in enumerate(stops):
        before = found[-1] if found else _next_order(stops, number)
        behind = len(before)
        placed = sorted(
            stop.places,
            key=lambda each: (each.rank, before.get(each.solver, behind)),
        )
        found.append({place.solver: slot for slot, place in enumerate(placed)})
    return found


def bump_chart(rankings: Mapping[tuple[str, str], Sequence[Stop]]) -> Figure:
    """Draw rankings side by side, one line a solver, named at both ends.

    Args:
        rankings: By robot and machine, a panel each.
    """
    most = max(len(stops) for stops in rankings.values())
    rows = max(len(stop.places) for stops in rankings.values() for stop in stops)
    size = (WIDTH * most + 2 * MARGIN, HEIGHT * rows + MARGIN)
    figure, axes = panels(len(rankings), *size, columns=1)
    solvers = {p.solver for stops in rankings.values() for stop in stops for p in stop.places}
    several = len({machine for _, machine in rankings}) > 1
    for ((robot, machine), stops), axis in zip(rankings.items(), axes, strict=True):
        title = f"{_headline(stops)}: {robot_title(robot)}"
        title += f", machine {machine}" if several else ""
        _panel(axis, title, stops, looks(solvers))
    return figure


def _headline(stops: Sequence[Stop]) -> str:
    """How many rankings there are, and how many of them differ."""
    different = {frozenset((each.solver, each.rank) for each in stop.places) for stop in stops}
    many, few = (_counted(n) for n in (len(stops), len(different)))
    return f"The same solvers, {many} protocol{_s(stops)}, {few} ranking{_s(different)}"


def _counted(number: int) -> str:
    return NUMBERS[number - 1] if number <= len(NUMBERS) else str(number)


def _s(counted: Sized) -> str:
    return "" if len(counted) == 1 else "s"


def _panel(axis: Axes, title: str, stops: Sequence[Stop], look: Mapping[str, Look]) -> None:
    at = slots(stops)
    rows = max(len(each) for each in at)
    for number, stop in enumerate(stops):
        _frames_of_ties(axis, number, stop, at[number])
        axis.text(number, -1.5, stop.title, ha="center", va="bottom", weight="bold")
        axis.text(number, -1.4, stop.by, ha="center", va="top", fontsize=6.5, color=SOFT)
    for solver in dict.fromkeys(place.solver for stop in stops for place in stop.places):
        _line(axis, solver, stops, at, look[solver])
    axis.set_xlim(-1.35, len(stops) + 0.35)
    axis.set_ylim(rows - 0.35, -1.95)
    axis.set_title(title, pad=4)
    axis.set_axis_off()


def _frames_of_ties(axis: Axes, number: int, stop: Stop, at: Mapping[str, int]) -> None:
    """A frame around each group of solvers that share a rank."""
    for rank in sorted({place.rank for place in stop.places}):
        tied = [at[place.solver] for place in stop.places if place.rank == rank]
        if len(tied) > 1:
            axis.add_patch(
                FancyBboxPatch(
                    (number - TIE_HALF_WIDTH, min(tied) - TIE_PAD),
                    2 * TIE_HALF_WIDTH,
                    max(tied) - min(tied) + 2 * TIE_PAD + 0.1,
                    boxstyle="round,pad=0,rounding_size=0.15",
                    facecolor=TIE_COLOUR,
                    edgecolor=SOFT,
                    linewidth=0.7,
                    zorder=1,
                )
            )


def _line(
    axis: Axes, solver: str, stops: Sequence[Stop], at: Sequence[Mapping[str, int]], look: Look
) -> None:
    """The line of a solver, its ranks in the markers, its values below, its name at both ends."""
    places = {
        number: next(place for place in stop.places if place.solver == solver)
        for number, stop in enumerate(stops)
        if solver in at[number]
    }
    x, y = list(places), [at[number][solver] for number in places]
    axis.plot(x, y, color=look.colour, linewidth=2.2, zorder=2, solid_capstyle="round")
    axis.scatter(x, y, s=150, color=look.colour, edgecolors="white", linewidths=1.2, zorder=3)
    for number, place in places.items():
        slot = at[number][solver]
        tied = [each.rank for each in stops[number].places].count(place.rank) > 1
        ground = TIE_COLOUR if tied else "white"
        axis.text(
            number,
            slot + 0.02,
            str(place.rank),
            ha="center",
            va="center_baseline",
            color="white",
            fontsize=7.5,
            weight="bold",
            zorder=4,
        )
        axis.text(
            number,
            slot + 0.27,
            place.value,
            ha="center",
            va="top",
            fontsize=6,
            color=INK,
            zorder=4,
            bbox={"facecolor": ground, "edgecolor": "none", "pad": 0.6},
        )
    for end, side, align in ((x[0], -LABEL_GAP, "right"), (x[-1], LABEL_GAP, "left")):
        axis.text(
            end + side,
            at[end][solver],
            solver_title(solver),
            ha=align,
            va="center",
            color=look.colour,
            weight="bold",
            zorder=4,
        )


def _next_order(stops: Sequence[Stop], number: int) -> dict[str, int]:
    """Solvers in the order of the rankings that follow, the nearest first."""
    names = [place.solver for place in stops[number].places]
    later = [{p.solver: p.rank for p in stop.places} for stop in stops[number + 1 :]]
    ordered = sorted(names, key=lambda name: [each.get(name, len(names)) for each in later])
    return {name: slot for slot, name in enumerate(ordered)}
