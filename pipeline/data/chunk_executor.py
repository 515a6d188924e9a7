"""Drawing a pose set on an engine: its chunks cut into shards, put together again in order."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial

from pipeline.engine.config import LOCAL, EngineConfig
from pipeline.engine.running import fans_out, try_tasks, workers_of
from pipeline.errors import EngineError
from robots.sampling import ChunkExecutor, Draw, Samples


def chunk_executor(engine: EngineConfig, workers: int) -> ChunkExecutor | None:
    """Return how an engine draws the chunks of a pose set, or None if this process does.

    Args:
        engine: Where tasks run.
        workers: How many at a time; 0 leaves it to the engine, and to one for each core where that
            is local and has one worker only.
    """
    if not workers:
        workers = 0 if engine.name == LOCAL and engine.workers == 1 else engine.workers
    engine = replace(engine, workers=workers)
    if not fans_out(engine):
        return None
    return ChunkExecutor(_Shards(engine), engine.start_up_s)


@dataclass(frozen=True)
class _Shards:
    engine: EngineConfig

    def __call__(self, draw: Draw, numbers: Sequence[int]) -> Iterator[Samples]:
        """Draw chunks in shards and yield the chunks in order, as soon as all before are there."""
        size = math.ceil(len(numbers) / (self.engine.pieces * workers_of(self.engine)))
        shards = [numbers[i : i + size] for i in range(0, len(numbers), size)]
        ready: dict[int, list[Samples]] = {}
        following = 0
        with closing(try_tasks(self.engine, partial(_shard, draw), shards, "dataset")) as endings:
            for number, outcome in endings:
                if outcome.lost:
                    raise EngineError(
                        f"shard {number} of {len(shards)} of a pose set was lost: "
                        f"{outcome.problem}. Sets that were finished are kept; the same command "
                        "makes the others"
                    )
                ready[number] = outcome.result()
                while following in ready:
                    yield from ready.pop(following)
                    following += 1


def _shard(draw: Draw, numbers: Sequence[int]) -> list[Samples]:
    return [draw(number) for number in numbers]
