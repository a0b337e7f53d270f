"""Turntables of documents, as GIF, as MP4 or as a row of PNG files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from bozzetto.atomic_files import write_bytes
from bozzetto.errors import UserError
from bozzetto.plugin.job import Job

if TYPE_CHECKING:
    from bozzetto.document.model import Document
    from bozzetto.view.camera import Camera
    from bozzetto.workbench.workbench import Workbench

MOVING: Final = (".gif", ".mp4")
"""Endings of moving pictures."""

ENDINGS: Final = (*MOVING, ".png")
"""Of the files: a moving picture, or a row of pictures."""

LEAD: Final = 3.0
"""Seconds in which a sketch is drawn and fades, before what it became turns."""


def write_turntable(
    bench: Workbench,
    document: Document,
    path: Path,
    count: int,
    seconds: float,
    job: Job | None = None,
    *,
    replaces: bool = True,
    from_sketch: bool = False,
    camera: Camera | None = None,
    **style: Any,
) -> tuple[Path, ...]:
    """Write pictures of all visible objects from all around.

    Parameters
    ----------
    bench : Workbench
        Solves what is shown.
    document : Document
        What turns.
    path : Path
        Ends in .gif, in .mp4, or in .png: then a number stands before that in the name of each
        file.
    count : int
        How many pictures.
    seconds : float
        How long one turn takes in a moving picture.
    job : Job, optional
        Is told how far it has come.
    replaces : bool
        Whether files of a row may be there already.
    from_sketch : bool
        Whether it begins with the sketch, in this view if something of it is there.
    camera : Camera, optional
        By default the document's own.
    style
        As in `scene.turntable.turned_pictures`.

    Returns
    -------
    tuple of Path
        The files that were written.

    Raises
    ------
    UserError
        If the ending is another one, a number is out of its range, a file is in the way, there is
        no sketch to begin with, or what makes an MP4 is not installed.
    """
    from bozzetto.images.gif import gif_of_pictures
    from bozzetto.images.mp4 import mp4_of_pictures
    from bozzetto.images.png import write_png
    from bozzetto.scene.turntable import MOST_PICTURES, pictures_from_sketch, turned_pictures

    if path.suffix.lower() not in ENDINGS:
        raise UserError("A turntable is a .gif, an .mp4, or a row of .png files. Choose one.")
    if not seconds > 0.0:
        raise UserError("A turn takes some time. Give seconds above 0.")
    job = job or Job()
    scene = bench.scene(document, job)
    rate = count / seconds
    if not from_sketch:
        total, pictures = count, turned_pictures(scene, count, **style)
    else:
        style.pop("view", None)
        lead = min(MOST_PICTURES, max(2, round(LEAD * rate)))
        own = _seen_through(bench, document, camera or document.camera)
        total, strokes = lead + count, bench.readings.ink_of(document)
        pictures = pictures_from_sketch(scene, strokes, own, count, lead, **style)

    def watched() -> Iterator[Any]:
        for number, pixels in enumerate(pictures):
            job.checkpoint(number / total, f"{number + 1} / {total}")
            yield pixels

    if path.suffix.lower() in MOVING:
        film_of = gif_of_pictures if path.suffix.lower() == ".gif" else mp4_of_pictures
        write_bytes(path, film_of(watched(), rate))
        return (path,)
    digits = len(str(total))
    paths = tuple(
        path.with_name(f"{path.stem}-{number + 1:0{digits}}{path.suffix}")
        for number in range(total)
    )
    there = next((one.name for one in paths if one.exists()), None)
    if there is not None and not replaces:
        raise UserError(f"There is a picture “{there}” already. Choose another name or folder.")
    for one, pixels in zip(paths, watched(), strict=True):
        write_png(one, pixels)
    return paths


def _seen_through(bench: Workbench, document: Document, own: Camera | None) -> Camera | None:
    """Return the view of a picture that an object was drawn on; a person's own where none is."""
    from bozzetto.view.camera import Camera

    start = own or Camera()
    for model in document:
        if not model.visible or bench.is_foreign(model) or not bench.advises(model.modeler):
            continue
        advice = bench.view_advice(model, start)
        if advice is None or advice.pinned or advice.better is None:
            continue
        there = bench.view_advice(model, advice.better)
        if there is not None and there.pinned:
            return advice.better
    return own
