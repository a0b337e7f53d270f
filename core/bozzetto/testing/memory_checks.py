"""Checks of what a modeler remembers: no answer may depend on it.

Answers may be remembered, as long as nobody can see it: whoever asks the same gets the same,
whatever was asked before, of this document or of another one, in this process or a fresh one.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace

from bozzetto.document.model import Model
from bozzetto.document.storage.state_codec import decode_state, encode_state
from bozzetto.errors import UserError
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.testing.questions import Question, answers, questions
from bozzetto.testing.subject import Broken, Subject
from bozzetto.workbench.workbench import Workbench

_ELSEWHERE = """
import json, sys
from bozzetto.document.storage.bozz_file import read_document
from bozzetto.plugin.host.registry import Registry
from bozzetto.testing.questions import answers, questions
from bozzetto.workbench.workbench import Workbench
registry = Registry(extra=sys.argv[2:])
document, _ = read_document(sys.argv[1], registry)
bench = Workbench(registry)
print(json.dumps(answers(bench, questions(bench, document.models[0])[::-1])))
"""


def check_forgetting(subject: Subject) -> None:
    """Check that answers do not depend on what was asked before, whatever is remembered."""
    with subject.drawn() as shell, subject.drawn(1) as other:
        registry, model = shell.registry, shell.model
        first = _asked(Workbench(registry), model)
        copied = replace(model, state=decode_state(type(model.state), encode_state(model.state)))
        bench = Workbench(registry)
        row = questions(bench, copied)
        between = _row_of_another(bench, other.model)
        mixed: dict[str, str] = {}
        for number, question in enumerate(reversed(row)):
            if between:
                answers(bench, [between[number % len(between)]])
            mixed |= answers(bench, [question])
        _compare(first, mixed, "in another order, with another document between")


def check_fresh_process(subject: Subject) -> None:
    """Check that answers are those of a fresh process, asked in the opposite order."""
    with subject.drawn() as shell:
        bench = Workbench(shell.registry)
        first = answers(bench, questions(bench, shell.model))
        _compare(first, _elsewhere(shell.save(), subject.packages), "in a fresh process")


def _asked(bench: Workbench, model: Model) -> dict[str, str]:
    """Return the answers; the same questions, asked again at once, must give the same."""
    row = questions(bench, model)
    first = answers(bench, row)
    _compare(first, answers(bench, row), "the second time")
    return first


def _row_of_another(bench: Workbench, model: Model) -> list[Question]:
    """Return questions about another document; none where it cannot even be shown."""
    try:
        return questions(bench, model)
    except (UserError, PluginFault):
        return []


def _compare(first: dict[str, str], again: dict[str, str], how: str) -> None:
    if first.keys() != again.keys():
        raise Broken(f"{how}, there are other handles or commands")
    others = [name for name in first if first[name] != again[name]]
    if others:
        more = f" and {len(others) - 1} more" if len(others) > 1 else ""
        raise Broken(
            f"asked {how}, {others[0]}{more} is another; an answer must not depend on what was "
            "asked before, so what is remembered needs a key with all that it depends on"
        )


def _elsewhere(document: os.PathLike[str], packages: tuple[str, ...]) -> dict[str, str]:
    """Return the answers of a fresh process, asked in the opposite order."""
    path = os.pathsep.join(path for path in sys.path if path)
    done = subprocess.run(
        [sys.executable, "-c", _ELSEWHERE, document, *packages],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": path},
        check=False,
    )
    if done.returncode:
        last = (done.stderr.strip().splitlines() or [""])[-1]
        raise Broken(f"it does not work in a process of its own: {last}")
    told: dict[str, str] = json.loads(done.stdout.splitlines()[-1])
    return told
