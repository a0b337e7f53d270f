"""Check of tools that move a model in time; see `checks` for the others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from bozzetto.document.model import Model
from bozzetto.document.storage.state_codec import state_digest
from bozzetto.errors import UserError
from bozzetto.plugin.drag_steps import LONGEST
from bozzetto.plugin.gesture import Drag
from bozzetto.plugin.job import Job
from bozzetto.plugin.overrides import overrides
from bozzetto.plugin.tool import Tool
from bozzetto.testing.deep_equal import same
from bozzetto.testing.headless_shell import Shell
from bozzetto.testing.subject import Subject, ensure
from bozzetto.testing.synthetic_pen import Pen

SECONDS: Final = (0.001, 1.0 / 60.0, LONGEST)
"""Times that one step stands for."""


def check_steps(subject: Subject) -> None:
    """Check that a tool that moves a model in time gives states that can be stored and solved.

    Held and let go, with a short and a long step, it gives the same state twice, and leaves alone
    the one that it is given.
    """
    for opened in (subject.shell, subject.drawn):
        with opened() as shell:
            for tool in shell.tools():
                if overrides(tool, "step"):
                    _check_tool(shell, tool)
                else:
                    told = f"the tool {tool.id} plays, and has no step that moves anything"
                    ensure(not tool.plays, told)


def _check_tool(shell: Shell, tool: Tool[Any]) -> None:
    model, context = shell.model, shell.context()
    for held in _hands(shell):
        for seconds in SECONDS:
            before = state_digest(model.state)
            try:
                once, again = (
                    shell.workbench.step(model, tool, held, seconds, context) for _ in range(2)
                )
            except UserError:
                continue
            ensure(same(once.state, again.state), f"{tool.id}.step differs the second time")
            ensure(state_digest(model.state) == before, f"{tool.id}.step changed its argument")
            model = once
        _solve(shell, model)


def _hands(shell: Shell) -> Iterator[Drag | None]:
    """Yield nobody's hand, and hands that take a handle, the middle of the sheet, or nothing."""
    yield None
    path = Pen().along([(600.0, 450.0), (700.0, 350.0)])
    for handle in [*(each.id for each in shell.handles()), "", "no such handle"][-3:]:
        yield Drag(handle, path)
    yield None


def _solve(shell: Shell, model: Model) -> None:
    try:
        result = shell.workbench.solve(model, Job(quality="preview"))
        shell.workbench.model_scene(model, result)
    except UserError as problem:
        ensure(bool(problem.message.strip()), "a UserError needs words")
