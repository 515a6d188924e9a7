"""Owners of lost trials: the first oracle that makes the same initial state succeed.

An oracle takes the place of one part alone. Where none of them helps but all together do, several
parts share the loss; where even they lose it, grasp and physics own it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import pandas as pd

from benchmarks.ladder.cells import AGENTS, PERCEPTIONS, SOLVERS, Cell
from pipeline.evaluation.statistics import Comparison, holm, mcnemar
from pipeline.grasping.outcome import SUCCESS

CALIBRATION, PERCEPTION, AGENT, SOLVER = "calibration", "perception", "agent", "solver"
SEVERAL, PHYSICS, UNDECIDED = "several", "physics", "undecided"
OWNERS = (CALIBRATION, PERCEPTION, AGENT, SOLVER, SEVERAL, PHYSICS, UNDECIDED)
Key = tuple[Cell, int]  # a cell and the number of a trial


def oracles(cell: Cell) -> dict[str, Cell]:
    """The cells with one part of a cell replaced by its oracle, by who owns what that mends."""
    found = {}
    if cell.perception == PERCEPTIONS[0]:
        found[CALIBRATION] = replace(cell, perception=PERCEPTIONS[1])
    if cell.perception != PERCEPTIONS[-1]:
        found[PERCEPTION] = replace(cell, perception=PERCEPTIONS[-1])
    if cell.agent != AGENTS[-1]:
        found[AGENT] = replace(cell, agent=AGENTS[-1])
    if cell.solver != SOLVERS[-1]:
        found[SOLVER] = replace(cell, solver=SOLVERS[-1])
    return found


def with_owners(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows with a column `owner`, empty where a trial succeeded.

    Args:
        rows: Raw rows of cells; one that has not run makes what hangs on it undecided.
    """
    keys = [(cell_of(row), int(row["trial"])) for row in rows.to_dict("records")]
    success = dict(zip(keys, rows["class"] == SUCCESS, strict=True))
    return rows.assign(owner=[_owner(key, success) for key in keys])


def _owner(key: Key, success: dict[Key, bool]) -> str:
    cell, number = key
    if success[key]:
        return ""
    everything = Cell(cell.robot, PERCEPTIONS[-1], AGENTS[-1], SOLVERS[-1])
    for owner, other in {**oracles(cell), SEVERAL: everything}.items():
        mended = success.get((other, number))
        if mended is None:
            return UNDECIDED
        if mended:
            return owner
    return PHYSICS


def cell_of(row: dict[Any, Any]) -> Cell:
    """The cell of a raw row."""
    return Cell(*(str(row[name]) for name in ("robot", "perception", "agent", "solver")))


@dataclass(frozen=True)
class Gain:
    """What an oracle gains: a cell and the one beside it, on the trials that both have.

    Attributes:
        cell: Without the oracle.
        owner: Whose oracle it is.
        trials: That both have.
        won: Lost without it, successful with it.
        lost: The other way round.
        test: McNemar's, of success with the oracle minus success without.
        adjusted: Its p-value, adjusted by Holm for all gains of the robot.
    """

    cell: Cell
    owner: str
    trials: int
    won: int
    lost: int
    test: Comparison
    adjusted: float


def gains(rows: pd.DataFrame) -> list[Gain]:
    """Compare every cell with the cells beside it, one oracle further."""
    by_cell = {
        Cell(*map(str, key)): part.set_index("trial")["class"] == SUCCESS
        for key, part in rows.groupby(["robot", "perception", "agent", "solver"], sort=False)
    }
    found: list[Gain] = []
    for cell, without in by_cell.items():
        for owner, other in oracles(cell).items():
            if other not in by_cell:
                continue
            both = pd.concat([without, by_cell[other]], axis=1, join="inner").to_numpy(dtype=bool)
            if len(both):
                before, after = both.T
                won, lost = int((after & ~before).sum()), int((before & ~after).sum())
                test = mcnemar(after, before)
                found.append(Gain(cell, owner, len(both), won, lost, test, test.p_value))
    adjusted: dict[str, float] = {}
    for robot in {gain.cell.robot for gain in found}:
        own = {str(k): g.test.p_value for k, g in enumerate(found) if g.cell.robot == robot}
        adjusted |= holm(own)
    return [replace(gain, adjusted=adjusted[str(k)]) for k, gain in enumerate(found)]
