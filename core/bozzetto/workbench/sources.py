"""Sources of models: drawings, the shapes of others, and pictures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from bozzetto.document.model import Model, new_id
from bozzetto.errors import UserError
from bozzetto.geometry.shapes import Shapes
from bozzetto.images.stored_picture import Picture
from bozzetto.ink.drawing import Drawing
from bozzetto.plugin.context import Context
from bozzetto.plugin.gesture import Ink
from bozzetto.plugin.job import Job
from bozzetto.plugin.modeler import ReadsDrawings, ReadsShapes, TakesPictures

if TYPE_CHECKING:
    from bozzetto.workbench.workbench import Workbench


class ModelSources:
    """Makes models of what there is already, through the guard.

    Parameters
    ----------
    bench : Workbench
        Runs the modelers.
    """

    def __init__(self, bench: Workbench) -> None:
        self._bench = bench

    def from_drawing(
        self,
        modeler_id: str,
        drawing: Drawing,
        values: Mapping[str, object],
        context: Context | None = None,
    ) -> Model:
        """Make a model of a whole drawing, as if it had been drawn by hand.

        Where the drawing says in which steps it was made, these are taken one by one. What it
        says beyond its strokes is in the context all the way (`Context.facts`), and so are the
        pictures that it names.
        """
        context = replace(
            context or Context(camera=drawing.camera),
            facts=drawing.extra,
            pictures=drawing.pictures,
        )
        model = self._bench.create(modeler_id, context, name=drawing.name)
        modeler = self._bench.registry.modeler(modeler_id)
        if drawing.steps:
            from bozzetto.workbench.play_steps import run_steps

            model = run_steps(self._bench, model, drawing, context)
        elif isinstance(modeler, ReadsDrawings):
            state = self._bench.registry.guard.call(
                modeler_id, "read_drawing", modeler.read_drawing, drawing, context
            )
            self._bench.registry.guard.check_state(modeler_id, modeler.state_type, state)
            model = replace(model, state=state)
        else:
            first = next((t for t in self._bench.tools(modeler_id) if t.gesture == "ink"), None)
            if first is None:
                raise UserError(f"{modeler.title} takes no ink. Choose another modeler.")
            if not len(drawing.strokes):
                raise UserError("The drawing has no strokes. Draw something first.")
            gesture = Ink(tuple(drawing.strokes), committed=True)
            model = self._bench.apply(model, first, gesture, context)
        return self._bench.set_parameters(model, values) if values else model

    def from_shapes(self, modeler_id: str, shapes: Shapes, name: str) -> Model:
        """Make a model of shapes from another program.

        Raises
        ------
        UserError
            If the modeler cannot start from shapes.
        """
        modeler = self._bench.registry.modeler(modeler_id)
        if not isinstance(modeler, ReadsShapes):
            raise UserError(
                f"{modeler.title} cannot start from what is there. Choose another modeler."
            )
        state = self._bench.registry.guard.call(
            modeler_id, "read_shapes", modeler.read_shapes, shapes
        )
        self._bench.registry.guard.check_state(modeler_id, modeler.state_type, state)
        return Model(new_id(), name, modeler_id, state, state_version=modeler.state_version)

    def from_models(
        self, modeler_id: str, models: Iterable[Model], job: Job, name: str = ""
    ) -> Model:
        """Make a model of the shapes of other models, where they stand; see `from_shapes`.

        Parameters
        ----------
        modeler_id : str
            The modeler of the new model.
        models : iterable of Model
            The models to start from, at least one.
        job : Job
            Solves what is not yet solved.
        name : str
            By default that of the first model.
        """
        row = tuple(models)
        if not row:
            raise UserError("Choose the objects to start from.")
        shapes = self._bench.shapes(row, job)
        if not shapes:
            raise UserError(f"“{row[0].name}” has no shape to start from. Draw something first.")
        return self.from_shapes(modeler_id, shapes, name or row[0].name)

    def takes_pictures(self, modeler_id: str) -> bool:
        """Whether a modeler works on pictures."""
        return isinstance(self._bench.registry.modeler(modeler_id), TakesPictures)

    def with_picture(self, model: Model, picture: Picture, context: Context) -> Model:
        """Return the model with one more picture to work on.

        Raises
        ------
        UserError
            If its modeler takes no pictures, or has no use for this one.
        """
        self._bench._refuse_closed(model)
        modeler = self._bench.registry.modeler(model.modeler)
        if not isinstance(modeler, TakesPictures):
            raise UserError(f"{modeler.title} takes no pictures. Choose another modeler.")
        if not picture.pixels.size:  # unpacked here, for damaged bytes are not the plugin's fault
            raise UserError(f"The picture “{picture.name}” is empty. Choose another one.")
        context = context.moved(model.placement.inverse())
        state = self._bench.registry.guard.call(
            model.modeler, "with_picture", modeler.with_picture, model.state, picture, context
        )
        self._bench.registry.guard.check_state(model.modeler, modeler.state_type, state)
        return replace(model, state=state)

    def from_picture(
        self,
        modeler_id: str,
        picture: Picture,
        values: Mapping[str, object],
        context: Context | None = None,
    ) -> Model:
        """Make a model that works on a picture; see `with_picture`."""
        context = context or Context()
        model = self._bench.create(modeler_id, context, name=picture.name)
        model = self.with_picture(model, picture, context)
        return self._bench.set_parameters(model, values) if values else model
