"""Films of what moves: a document let go for a while, or as it was recorded."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.document.links import resolved
from bozzetto.errors import UserError
from bozzetto.exchange.export import WRITERS
from bozzetto.exchange.ready_shapes import Recording
from bozzetto.plugin.cautions import Caution
from bozzetto.plugin.context import Context
from bozzetto.plugin.job import Job
from bozzetto.view.camera import Camera
from bozzetto.workbench.export_document import (
    ObjectShapes,
    chosen_models,
    object_shapes,
    unusable,
)

if TYPE_CHECKING:
    from bozzetto.document.model import Document, Model
    from bozzetto.plugin.tool import Tool
    from bozzetto.workbench.workbench import Workbench

LONGEST: Final = 0.05
"""Longest step of a tool, s; see `Tool.step`."""

MOST_FRAMES: Final = 3600
"""Frames of a film: a minute at 60 a second."""

SAME_TIME: Final = 1e-3
"""Seconds between two frames: files hold times in single precision."""

ANIMATIONS: Final = (".glb", ".usdz")
"""Endings of the files that hold how parts move."""

ENDINGS: Final = (*ANIMATIONS, ".gif", ".mp4")
"""Of the files that are films."""

NOTHING_RECORDED: Final = (
    "Nothing was recorded in this document. Move something with the pen, or let it play, then save "
    "the document."
)


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
    times = frame_times(seconds, rate)
    job = job or Job()
    players = {model.id: tool for model in document if (tool := _player(bench, model)) is not None}
    if not players:
        raise UserError("Nothing in this document moves by itself.")
    yield document
    for model in resolved(document).values():
        if model.id in players and model.sources:
            bench.solve(model, job)  # a tool is given what was solved
    count = len(times) - 1
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


def frame_times(seconds: float, rate: float) -> list[float]:
    """Return the times of the documents that `frames` yields, s.

    Raises
    ------
    UserError
        If there are too many, or none.
    """
    if not (seconds > 0.0 and rate > 0.0 and seconds * rate <= MOST_FRAMES):
        raise UserError(
            f"A film has 1 to {MOST_FRAMES} frames. Choose seconds and frames a second above 0, "
            f"and no more than {MOST_FRAMES} together."
        )
    return [number / rate for number in range(max(1, round(seconds * rate)) + 1)]


def recordings(
    bench: Workbench,
    document: Document,
    ask: Callable[[Model], tuple[float, ...]] | None = None,
) -> dict[str, tuple[float, ...]]:
    """Return when visible objects recorded how they moved, by their ids, s; see `recorded_times`.

    Those that recorded nothing, or one pose, are left out.

    Parameters
    ----------
    bench : Workbench
        Knows the modelers.
    document : Document
        Stays as it is.
    ask : callable, optional
        Gives the times of an object; by default `Workbench.recorded`.
    """
    usable = [one for one in document if one.visible and unusable(bench, one) is None]
    rows = {model.id: (ask or bench.recorded)(model) for model in usable}
    return {number: times for number, times in rows.items() if len(times) > 1}


def recorded_times(
    recordings: Mapping[str, Sequence[float]], rate: float | None = None
) -> list[float]:
    """Return the times of a film of all recordings, which begin together, s from its beginning.

    Parameters
    ----------
    recordings : mapping of str to sequence of float
        See `recordings`.
    rate : float, optional
        Frames a second; by default all times that were recorded. Where these are more frames than
        a film has, they are spread evenly.

    Raises
    ------
    UserError
        If there are none, or the rate is none.
    """
    if not recordings:
        raise UserError(NOTHING_RECORDED)
    if rate is not None and not 0.0 < rate < np.inf:
        raise UserError("A film has frames. Choose frames a second above 0.")
    own = [np.asarray(times) - times[0] for times in recordings.values()]
    longest = max(float(times[-1]) for times in own)
    if rate is None:
        found = np.unique(np.concatenate(own))
        found = found[np.concatenate(([True], np.diff(found) > SAME_TIME))]
        count = len(found)
    else:
        count = max(2, int(np.ceil(longest * rate - SAME_TIME)) + 1)
        found = np.minimum(np.arange(min(count, MOST_FRAMES)) / rate, longest)
    if count > MOST_FRAMES:
        found = np.linspace(0.0, longest, MOST_FRAMES)
    times: list[float] = found.tolist()
    return times


def pace_of(times: Sequence[float], rate: float) -> float:
    """Return how many frames a second show times truly: those of the rate at most."""
    return min(rate, (len(times) - 1) / times[-1])


def replayed(
    bench: Workbench,
    document: Document,
    recordings: Mapping[str, Sequence[float]],
    times: Sequence[float],
    job: Job | None = None,
) -> Iterator[Document]:
    """Yield a document as it was at times of its recordings; one that is over stands still.

    Parameters
    ----------
    bench : Workbench
        Runs the modelers.
    document : Document
        Stays as it is.
    recordings : mapping of str to sequence of float
        See `recordings`.
    times : sequence of float
        From the beginning, s.
    job : Job, optional
        Is told how far it has come.
    """
    job = job or Job()
    for number, time in enumerate(times):
        job.checkpoint(number / len(times), f"{number + 1} / {len(times)}")
        now = document
        for model in document:
            if model.id in recordings:
                first, last = recordings[model.id][0], recordings[model.id][-1]
                now = now.with_model(bench.replayed(model, min(first + time, last)))
        yield now


def animation_of(
    bench: Workbench,
    films: Iterable[Document],
    seconds: Sequence[float],
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
        See `frames` and `replayed`.
    seconds : sequence of float
        Their times.
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
    made: bytes = write_motion(shapes, seconds)
    return made


def with_recording(
    bench: Workbench,
    document: Document,
    objects: ObjectShapes,
    names: Sequence[str] | None,
    paths: Sequence[str | os.PathLike[str]],
    job: Job,
) -> ObjectShapes:
    """Return shapes for export with how they moved, where that was recorded and a file holds it.

    Parameters
    ----------
    bench : Workbench
        Solves what is shown.
    document : Document
        As it is now.
    objects : ObjectShapes
        What is exported of it.
    names : sequence of str, optional
        Of the objects.
    paths : sequence of path
        Of the files.
    job : Job
        Is told how far it has come.
    """
    from bozzetto.exchange.formats import find
    from bozzetto.exchange.mesh.gltf_motion import rigid_motions
    from bozzetto.geometry import meshed

    holding = any("motions" in find(path, WRITERS).keeps for path in paths)
    if objects.recording is not None or not holding:
        return objects
    models, _ = chosen_models(document, names)
    chosen = {model.id for model in models}
    known = {key: times for key, times in recordings(bench, document).items() if key in chosen}
    if not known:
        return objects
    times = recorded_times(known)
    frames = [meshed(objects.shapes)]
    for then in replayed(bench, document, known, times, job):
        models, _ = chosen_models(then, names)
        frames.append(meshed(object_shapes(bench, models, job).shapes))
    try:
        motions = rigid_motions(frames)
    except UserError as problem:
        unmoved = Caution(f"What was recorded is not in the file. {problem.message}")
        return replace(objects, cautions=(*objects.cautions, ("", unmoved)))
    return replace(objects, recording=Recording([row[1:] for row in motions], times))


def picture_film_of(
    bench: Workbench,
    films: Iterable[Document],
    rate: float,
    size: tuple[int, int],
    camera_for: Callable[[Any, Document], Camera] | None = None,
    ending: str = ".gif",
) -> bytes:
    """Return a GIF or an MP4 of all visible objects.

    Parameters
    ----------
    bench : Workbench
        Solves what is shown.
    films : iterable of Document
        See `frames` and `replayed`.
    rate : float
        Frames a second.
    size : (int, int)
        px.
    camera_for : callable, optional
        Gives the view from the first scene and its document; by default that of the document, or
        one that shows everything.
    ending : {".gif", ".mp4"}
        Of the file.
    """
    from bozzetto.images.gif import gif_of_pictures
    from bozzetto.images.mp4 import mp4_of_pictures
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

    film_of = gif_of_pictures if ending == ".gif" else mp4_of_pictures
    return film_of(pictures(), rate)


def _player(bench: Workbench, model: Model) -> Tool[Any] | None:
    """Return the tool of a model that goes on by itself, if there is one."""
    if not model.visible or unusable(bench, model) is not None:
        return None
    return next((tool for tool in bench.tools(model.modeler) if tool.plays), None)
