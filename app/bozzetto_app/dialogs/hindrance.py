"""Words about what hinders a save: somebody else's document, or a file that was changed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QDateTime, QLocale

from bozzetto.document.recovery.file_lock import Locked
from bozzetto_app.i18n import tr

if TYPE_CHECKING:
    from bozzetto.atomic_files import FileChanged, FileStamp
    from bozzetto_app.session.files import Hindrance


def said_of(problem: FileChanged | Locked) -> str:
    """Return the obstacle to a save, as a sentence."""
    if isinstance(problem, Locked):
        return tr(
            "Files",
            "{user} on {host} has this document open.",
            user=problem.holder.user,
            host=problem.holder.host,
        )
    name = problem.path.name
    if problem.expected is None:
        return tr("Files", "There is a file “{name}” already.", name=name)
    return tr("Files", "“{name}” was changed by another program.", name=name)


def explained(hindrance: Hindrance) -> str:
    """Return the facts that the person needs in order to choose."""
    problem = hindrance.problem
    if isinstance(problem, Locked):
        return tr(
            "Files",
            "Take it over only if it is not being worked on there any more: who saves last "
            "writes over the other.",
        )
    lines = [tr("Files", "On the disk: {facts}", facts=_facts(problem.found))]
    if problem.expected is not None:
        lines.append(tr("Files", "As you had it: {facts}", facts=_facts(problem.expected)))
    return "\n".join(lines)


def _facts(stamp: FileStamp) -> str:
    """Time and size of a file."""
    locale = QLocale()
    when = QDateTime.fromMSecsSinceEpoch(stamp.modified // 1_000_000)
    date = locale.toString(when.date(), QLocale.FormatType.ShortFormat)
    return tr(
        "Files",
        "{date}, {time}, {bytes} bytes",
        date=date,
        time=when.toString("HH:mm:ss"),
        bytes=locale.toString(stamp.size),
    )
