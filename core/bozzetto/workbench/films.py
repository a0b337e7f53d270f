"""Films of what moves: a document let go for a while, as an animation or as GIF."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.document.links import resolved
from bozzetto.errors import UserError
from bozzetto.plugin.context import Context
from bozzetto.plugin.job import Job
from bozzetto.view.camera import Camera
from bozzetto.workbench.export_document import chosen_models, object_shapes, unusable

if TYPE_CHECKING:
    from bozzetto.document.model import Document, Model
    from bozzetto.plugin.tool import Tool
    from bozzetto.workbench.workbench import Workbench

LONGEST: Final = 0.05
"""Longest step of a tool, s; see `Tool.step`."""

MOST_FRAMES: Final = 3600
"""Frames of a film: a minute at 60 a second."""

ENDINGS: Final = (".glb", ".usdz", ".gif")
"""Of the files that are films."""


def frames(
    bench: Workbench, document: Document, seconds: float, rate: float, job: Job | None = None
) -> Iterator[Document]:
    """Yield a document as it is at the beginning and after each frame.

    An object whose tool refuses to go on stands still from there on, as long as another one moves.

    Parameters
    ----------
    bench : Workbench
        Runs the tools.
    document : Document
        Stays as it is.
    seconds, rate : float
        How long, s, and frames a second.
    job : Job, optional
        Is told how far it has come.

    Raises
    ------
    UserError
        If nothing in it moves by itself, or there are too many frames.
    """
    if not (seconds > 0.0 and rate > 0.0 and seconds * rate <= MOST_FRAMES):
        raise UserError(
            f"A film has 1 to {MOST_FRAMES} frames. Choose seconds and frames a second above 0, "
            f"and no more than {MOST_FRAMES} together."
        )
    job = job or Job()
    players = {model.id: tool for model in document if (tool := _player(bench, model)) is not None}
    if not players:
        raise UserError("Nothing in this document moves by itself.")
    yield document
    for model in resolved(document).values():
        if model.id in players and model.sources:
            bench.solve(model, job)  # a tool is given what was solved
    count = max(1, round(seconds * rate))
    steps = max(1, -int(-1.0 / rate // LONGEST))
    still: dict[str, UserError] = {}
    for number in range(count):
        job.checkpoint(number / count, f"{number + 1} / {count}")
        for model in [model for model in document if model.id in players.keys() - still.keys()]:
            context = Context(camera=document.camera or Camera())
            context = replace(context, sources=bench.given_sources(model))
            try:
                for _ in range(steps):
                    model = bench.step(model, players[model.id], None, 1.0 / rate / steps, context)
            except UserError as problem:
                still[model.id] = problem
                if len(still) == len(players):
                    raise
                continue
            document = document.with_model(model)
        yield document


def animation_of(
    bench: Workbench,
    films: Iterable[Document],
    rate: float,
    ending: str = ".glb",
    names: Sequence[str] | None = None,
    warn: Callable[[Sequence[str]], Any] = lambda warnings: None,
) -> bytes:
    """Return a file with an animation of some objects, by default of all that are visible.

    Parameters
    ----------
    bench : Workbench
        Solves what is shown.
    films : iterable of Document
        See `frames`.
    rate : float
        Frames a second.
    ending : {".glb", ".usdz"}
        Of the file.
    names : sequence of str, optional
        Of the objects.
    warn : callable
        Is given sentences about what is left out.

    Raises
    ------
    UserError
        If there is no shape.
    """
    from bozzetto.exchange.formats import FORMATS, find, function
    from bozzetto.geometry import meshed

    shapes: list[Any] = []
    for document in films:
        models, _ = chosen_models(document, names)
        objects = object_shapes(bench, models, Job())
        if not shapes:
            warn(objects.warnings())
        shapes.append(meshed(objects.shapes))
    if not any(shapes[0].meshes()):
        raise UserError("There is no shape to write. Turn a drawing into a solid first.")
    write_motion = function(find(f"film{ending}", FORMATS), "write_motion")
    seconds = [number / rate for number in range(len(shapes))]
    made: bytes = write_motion(shapes, seconds)
    return made


def gif_of(
    bench: Workbench,
    films: Iterable[Document],
    rate: float,
    size: tuple[int, int],
    camera_for: Callable[[Any, Document], Camera] | None = None,
) -> bytes:
    """Return a GIF of all visible objects.

    Parameters
    ----------
    bench : Workbench
        Solves what is shown.
    films : iterable of Document
        See `frames`.
    rate : float
        Frames a second.
    size : (int, int)
        px.
    camera_for : callable, optional
        Gives the view from the first scene and its document; by default that of the document, or
        one that shows everything.
    """
    from bozzetto.images.gif import gif_of_pictures
    from bozzetto.scene.snapshot import own_or_framed, picture

    def pictures() -> Iterator[NDArray[np.uint8]]:
        camera = None
        for document in films:
            scene = bench.scene(document, Job())
            if camera is None:
                camera = (
                    own_or_framed(scene, document.camera, size)
                    if camera_for is None
                    else camera_for(scene, document)
                )
            yield picture(scene, camera=camera, size=size)

    return gif_of_pictures(pictures(), rate)


def _player(bench: Workbench, model: Model) -> Tool[Any] | None:
    """Return the tool of a model that goes on by itself, if there is one."""
    if not model.visible or unusable(bench, model) is not None:
        return None
    return next((tool for tool in bench.tools(model.modeler) if tool.plays), None)
