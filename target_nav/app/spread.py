"""Work spread over processes, one process a job: py_trees keeps one blackboard a process."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import TypeVar

Order = TypeVar("Order")
Done = TypeVar("Done")


def run_all(execute: Callable[[Order], Done], todo: Sequence[Order], jobs: int) -> Iterator[Done]:
    """Results as they come, in no order. `execute` is a function of a module, for it is sent to the processes."""
    if jobs <= 1:
        yield from map(execute, todo)
        return
    # spawned, not forked: a worker must not inherit threads or an open ROS context
    with ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn")) as pool:
        for done in as_completed([pool.submit(execute, order) for order in todo]):
            yield done.result()
