"""Export of a document's objects, with warnings of all that is left out."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.document.links import resolved
from bozzetto.errors import UserError
from bozzetto.exchange.cad.cad_curves import points_on
from bozzetto.exchange.export import WRITERS, Exported, prepare_file
from bozzetto.exchange.formats import find
from bozzetto.exchange.handover import AS_USUAL, Handover
from bozzetto.exchange.left_out import LeftOut
from bozzetto.exchange.mesh.picture_places import Checkpoint, no_checkpoint
from bozzetto.exchange.ready_shapes import Ready, Recording
from bozzetto.exchange.svg.writer import is_plan
from bozzetto.geometry.shapes import Shapes
from bozzetto.plugin.cautions import Caution
from bozzetto.view.camera import Camera
from bozzetto.view.page_views import framing, page_view
from bozzetto.view.standard_views import standard_view
from bozzetto.workbench.placed import told_apart

if TYPE_CHECKING:
    from bozzetto.document.model import Document, Model
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench

ABSENT = {
    "absent": (
        "its plugin is not installed",
        "install the plugin that has the modeler {modeler}",
    ),
    "disabled": (
        "its plugin {plugin} is switched off",
        "switch it on in the list of plugins (Help › Plugins)",
    ),
    "broken": (
        "its plugin {plugin} cannot be used",
        "look in the list of plugins (Help › Plugins) for the reason",
    ),
    "ready": (
        "this version of its plugin {plugin} cannot read it",
        "update the plugin",
    ),
}
"""Why an object cannot be handed over and what to do, by how its plugin stands."""


@dataclass(frozen=True)
class ObjectShapes:
    """Shapes of objects for export, and what a person must know of them.

    Attributes
    ----------
    shapes : Shapes
    left_out : tuple of LeftOut
        Objects that are not in the shapes.
    cautions : tuple of (str, Caution)
        What their modelers warn of, each with the name of the object.
    recording : Recording, optional
        How they moved, for files that hold it; see `bozzetto.workbench.films.with_recording`.
    """

    shapes: Shapes
    left_out: tuple[LeftOut, ...] = ()
    cautions: tuple[tuple[str, Caution], ...] = ()
    recording: Recording | None = None

    def warnings(self, *, baseless_only: bool = False) -> tuple[str, ...]:
        """Return the cautions as sentences, with objects' names where there are several objects."""
        several = len({name for name, _ in self.cautions}) > 1
        return tuple(
            f"{name}: {caution.message}" if several else caution.message
            for name, caution in self.cautions
            if caution.baseless or not baseless_only
        )


def chosen_models(
    document: Document, names: Sequence[str] | None
) -> tuple[list[Model], list[LeftOut]]:
    """Return the objects to export, and those that stay behind because they are hidden.

    The objects come with what they are made from; see `bozzetto.document.links.resolved`.

    Parameters
    ----------
    document : Document
        The document that holds them.
    names : sequence of str, optional
        Names of the objects wanted, hidden or not; all of one name. By default all that are
        visible.

    Raises
    ------
    UserError
        If there is no object of a name.
    """
    models = resolved(document).values()
    if names is not None:
        missing = sorted(set(names) - {model.name for model in document})
        if missing:
            known = ", ".join(dict.fromkeys(model.name for model in document)) or "none"
            raise UserError(f"There is no object {', '.join(missing)}; there are: {known}.")
        return [model for model in models if model.name in names], []
    hidden = [
        LeftOut(f"“{model.name}”", (model.name,), "it is hidden", "show it, or ask for it by name")
        for model in document
        if not model.visible
    ]
    return [model for model in models if model.visible], hidden


def links_of(model: Model) -> dict[str, list[str]]:
    """Return the names of what a model follows and of what it keeps frozen; nothing if none."""
    links = {
        "follows": [source.name for source in model.linked],
        "frozen": [source.name for source in model.frozen],
    }
    return {word: names for word, names in links.items() if names}


def unusable(bench: Workbench, model: Model) -> LeftOut | None:
    """Return why an object cannot be shown or exported now; None if it can."""
    if bench.is_usable(model):
        return None
    standing = bench.registry.standing(model.modeler)
    reason, advice = ABSENT.get(standing.status, ABSENT["ready"])
    facts = {"modeler": model.modeler, "plugin": standing.plugin}
    what = f"“{model.name}”"
    return LeftOut(what, (model.name,), reason.format(**facts), advice.format(**facts))


def object_shapes(bench: Workbench, models: Iterable[Model], job: Job) -> ObjectShapes:
    """Return the shapes of objects, in the world, and no two objects' parts with one name.

    Objects whose plugin cannot be used and empty ones do not keep the others back.

    Raises
    ------
    UserError
        If the recipe of an object has no solution.
    PluginFault
        If its plugin fails.
    """
    rows: list[tuple[str, Shapes]] = []
    left_out: list[LeftOut] = []
    cautions: list[tuple[str, Caution]] = []
    for model in models:
        problem = unusable(bench, model)
        if problem is not None:
            left_out.append(problem)
            continue
        made = bench.shapes([model], job)
        cautions += [(model.name, caution) for caution in bench.cautions(model, job)]
        if not made:
            what, advice = f"“{model.name}”", "draw more of it, then export"
            left_out.append(LeftOut(what, (model.name,), "it has no shape yet", advice))
        rows.append((model.name, made))
    shapes = sum(told_apart(rows), Shapes())
    return ObjectShapes(shapes, tuple(left_out), tuple(cautions))


def prepared_files(
    objects: ObjectShapes,
    paths: Sequence[str | os.PathLike[str]],
    camera: Camera | None,
    *,
    view: str | None = None,
    whole: bool = True,
    handover: Handover = AS_USUAL,
    checkpoint: Checkpoint = no_checkpoint,
    ready: Ready | None = None,
) -> list[Exported]:
    """Return files of some objects, each in the format that its ending names.

    Parameters
    ----------
    objects : ObjectShapes
        The shapes, from `object_shapes`.
    paths : sequence of path
        Nothing is written there.
    camera : Camera, optional
        The person's view, for flat formats. Where the shapes do not lie in it, the
        three-quarter view that frames them takes its place. What lies flat is a plan: seen from
        above, at true size.
    view : str, optional
        A standard view to take instead.
    whole : bool
        Whether the person's view must show all of the shapes, or some are enough.
    handover : Handover
        Unit, axes, size, number of triangles or quads, and whether flat files are drawings.
    checkpoint : callable
        As `Job.checkpoint`; asked where a file takes long.
    ready : Ready, optional
        The shapes as they are handed over so, where somebody has use for them.

    Raises
    ------
    UserError
        As `bozzetto.exchange.export.export`; names the objects that were left out where nothing
        else is there.
    """
    formats = [find(path, WRITERS) for path in paths]
    if objects.left_out and not objects.shapes:
        said = [part.sentence(f"{formats[0].short} file") for part in objects.left_out]
        raise UserError(" ".join(("There is nothing to export.", *said, *objects.warnings())))
    if view is not None:
        standard_view(Camera(), view)  # one that does not exist is told whatever is written
    ready = ready or Ready(objects.shapes, handover, checkpoint, objects.recording)
    made = []
    for chosen, path in zip(formats, paths, strict=True):
        shown = chosen.flat or (chosen.draws and handover.lines is not None)
        seen = _camera_for(ready, camera, view, whole=whole) if shown else camera
        file = prepare_file(ready, path, seen, formats)
        notes = file.notes
        if view is not None and not shown:
            notes = (*notes, f"{chosen.short} files hold all sides and no view of them.")
        made.append(replace(file, left_out=(*objects.left_out, *file.left_out), notes=notes))
    return made


def _camera_for(
    ready: Ready, camera: Camera | None, view: str | None, *, whole: bool
) -> Camera | None:
    points = ready.points if ready.handover.lines else _points_of(ready.placed)
    if view is not None:
        return framing(points, view, plans=True)
    return None if is_plan(points) else page_view(points, camera, whole=whole)


def _points_of(shapes: Shapes) -> NDArray[np.float64]:
    """Return points of all that a flat file shows, mm."""
    lines = [points_on(curve) for curve in shapes.curves]
    return np.concatenate(lines) if lines else np.zeros((0, 3))
