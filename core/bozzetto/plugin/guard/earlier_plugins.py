"""Plugins that were written for an earlier version of the contract."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bozzetto.plugin.job import Job


def with_job(function: Callable[..., Any], *arguments: Any, job: Job) -> tuple[Any, ...]:
    """Return the arguments of a call, and the job behind them where the function takes it.

    Before version 2.1 `report`, `read_drawing` and `view_advice` came without a job. Which
    version a plugin was written for does not tell, for its manifest names a range.

    Parameters
    ----------
    function : callable
        The plugin's.
    *arguments
        What it takes in every version.
    job : Job
        What it takes today.
    """
    try:
        inspect.signature(function).bind(*arguments, job)
    except TypeError:
        return arguments
    except ValueError:  # a function of a C library says nothing of its arguments
        pass
    return (*arguments, job)
