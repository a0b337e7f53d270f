"""Readings of ink: the strokes of objects, or ink that waits, as a model of another modeler."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.document.model import Document, Model
from bozzetto.document.waiting_ink import strokes_of
from bozzetto.errors import UserError
from bozzetto.scene.palette import LIGHT, Palette

if TYPE_CHECKING:
    from bozzetto.ink.drawing import Drawing
    from bozzetto.ink.stroke import Stroke
    from bozzetto.plugin.context import Context
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench

NO_INK: Final = "There is no ink in it: it was not drawn with a pen. Choose another object."


class Reading(msgspec.Struct, frozen=True, eq=False):
    """Ink as one modeler reads it.

    Attributes
    ----------
    model : Model
        A new one, solved.
    picture : (h, w, 4) uint8
        What it looks like, without a ground.
    """

    model: Model
    picture: NDArray[np.uint8]


class InkReadings:
    """Hands ink that is there to other modelers, through the guard.

    Parameters
    ----------
    bench : Workbench
        Runs the modelers.
    """

    def __init__(self, bench: Workbench) -> None:
        self._bench = bench

    def drawing_of(self, models: Iterable[Model]) -> Drawing:
        """Return the ink of models as one drawing in the world; see `Modeler.ink`.

        Hidden models and those of absent plugins have none.

        Raises
        ------
        UserError
            If there is no ink.
        """
        row = [model for model in models if model.visible and not self._bench.is_foreign(model)]
        strokes = self.ink_of(row)
        if not strokes:
            raise UserError(NO_INK)
        return self.drawing_of_strokes(strokes, row[0].name)

    def ink_of(self, models: Iterable[Model]) -> list[Stroke]:
        """Return the strokes of models in the world, in their order; none of what is hidden."""
        return [
            stroke.moved(model.placement)
            for model in models
            if model.visible and not self._bench.is_foreign(model)
            for stroke in self._bench.guarded(model).ink(model.state)
        ]

    def drawing_of_document(self, document: Document) -> Drawing:
        """Return the ink of all visible objects; where none is made of ink, what waits.

        Raises
        ------
        UserError
            If there is no ink.
        """
        try:
            return self.drawing_of(document)
        except UserError:
            if not document.waiting:
                raise
            return self.drawing_of_strokes(strokes_of(document.waiting), "Drawing")

    @staticmethod
    def drawing_of_strokes(strokes: Iterable[Stroke], name: str) -> Drawing:
        """Return loose strokes as a drawing; its camera is that of the first."""
        from bozzetto.ink.drawing import Drawing
        from bozzetto.ink.stroke import Strokes

        ink = Strokes(strokes)
        return Drawing(ink, ink[0].camera, name)

    def readers(self, *, without: Iterable[str] = ()) -> tuple[str, ...]:
        """Return the modelers that a person can draw with, but for some; not all read all ink."""
        left_out = set(without)
        known = self._bench.registry.modelers()
        return tuple(info.id for info in known if info.listed and info.id not in left_out)

    def read(self, modeler_id: str, drawing: Drawing, context: Context, job: Job) -> Model:
        """Return a solved model of a drawing.

        Raises
        ------
        UserError
            If the modeler cannot read it, or no shape comes of it.
        """
        own = replace(context, camera=drawing.camera)
        model = self._bench.sources.from_drawing(modeler_id, drawing, {}, own, job)
        job.checkpoint(0.3, "Reading the ink")
        shapes = self._bench.shapes([model], job)
        if not shapes:
            raise UserError("No shape comes of this ink. Choose another modeler.")
        return model

    def reading(
        self,
        modeler_id: str,
        drawing: Drawing,
        context: Context,
        job: Job,
        *,
        side: int,
        palette: Palette = LIGHT,
    ) -> Reading:
        """Return a solved model with a square picture of it, `side` pixels wide; see `read`."""
        from bozzetto.scene.snapshot import picture

        model = self.read(modeler_id, drawing, context, job)
        scene = self._bench.model_scene(model, self._bench.solve(model, job))
        job.checkpoint(0.9, "Making a picture")
        return Reading(model, picture(scene, palette=palette, size=(side, side), background=False))
