"""Sources of models: drawings, the shapes of others, and pictures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.document.links import resolved
from bozzetto.errors import UserError
from bozzetto.geometry.placement import Placement
from bozzetto.plugin.overrides import overrides
from bozzetto.scene.display_list import Shaded
from bozzetto.workbench.links import with_state

if TYPE_CHECKING:
    from bozzetto.document.model import Document, Model
    from bozzetto.exchange.reading import MeshFile
    from bozzetto.geometry.shapes import Shapes
    from bozzetto.images.stored_picture import Picture
    from bozzetto.ink.drawing import Drawing
    from bozzetto.plugin.context import Context
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench

Box = NDArray[np.float64]
"""Least and largest corner, (2, 3), mm; NaN where there is nothing."""

NOWHERE: Final = np.full((2, 3), np.nan)

GAP: Final = 0.4
"""Room between a new object and what it is placed beside, in widths of the new one."""


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
        job: Job | None = None,
        on: Iterable[Model] = (),
    ) -> Model:
        """Make a model of a whole drawing, as if it had been drawn by hand.

        Where the drawing says in which steps it was made, these are taken one by one. What it
        says beyond its strokes is in the context all the way (`Context.facts`), and so are the
        pictures and drawings that it names.

        Parameters
        ----------
        modeler_id : str
            The modeler of the new model.
        drawing : Drawing
            The strokes, and what its file says besides.
        values : mapping of str to object
            Parameters of the model when it is drawn.
        context : Context, optional
            The world around.
        job : Job, optional
            Says whether anybody still waits.
        on : iterable of Model
            What is drawn on, and followed from then on; by default what the drawing says
            (`linked_drawings.models_drawn_on`). The new model comes with it (`Model.linked`).

        Raises
        ------
        UserError
            If the drawing makes no sense to the modeler, or this one cannot follow others.
        """
        from bozzetto.plugin.context import Context
        from bozzetto.plugin.job import Job

        context = replace(
            context or Context(camera=drawing.camera),
            facts=drawing.facts,
            pictures=drawing.pictures,
            drawings=drawing.drawings,
            templates=self._bench.registry.templates(modeler_id),
        )
        job = job or Job()
        begun = self.begun(modeler_id, drawing, context, job, on)
        if begun is not None:
            from bozzetto.workbench.linked_drawings import with_steps
            from bozzetto.workbench.play_steps import run_steps

            if begun.linked:
                drawing = with_steps(drawing, self._bench.tools(modeler_id))
            model = run_steps(self._bench, begun, drawing, context, job)
        else:
            state = self._read(modeler_id, drawing, context, job)
            name = drawing.name or self._bench.registry.info(modeler_id).title
            model = self._bench.new_model(modeler_id, state, name)
        return self._bench.set_parameters(model, values) if values else model

    def begun(
        self,
        modeler_id: str,
        drawing: Drawing,
        context: Context,
        job: Job,
        on: Iterable[Model] = (),
    ) -> Model | None:
        """Return the model on which the first step of a drawing is taken.

        None where its strokes are read all at once. See `from_drawing`.
        """
        from bozzetto.workbench.linked_drawings import SHAPES, models_drawn_on

        row = tuple(on) or models_drawn_on(self._bench, drawing, job)
        if row:
            known = (*self._bench.registry.info(modeler_id).facts, *SHAPES)
            beside = [key for key in known if key in drawing.facts]
            if beside:
                raise UserError(
                    f"The drawing has “{beside[0]}”, and is drawn on another object. Leave one of "
                    "them out."
                )
            model = self.following(modeler_id, row, job, drawing.name)
            linked = tuple(source for source in row if source.id in model.sources)
            return replace(model, linked=linked)
        return self._bench.create(modeler_id, context, name=drawing.name) if drawing.steps else None

    def _read(self, modeler_id: str, drawing: Drawing, context: Context, job: Job) -> Any:
        """Return the state that a modeler makes of a drawing.

        A drawing without strokes, for a modeler that reads drawings as all do, is made by its
        `create`, which has the facts in its context.
        """
        registry = self._bench.registry
        guarded, modeler = registry.guarded(modeler_id), registry.modeler(modeler_id)
        if len(drawing.strokes) or overrides(modeler, "read_drawing"):
            return guarded.read_drawing(drawing, context, job)
        if any(key in drawing.facts for key in registry.info(modeler_id).facts):
            return guarded.create(context)
        other = registry.told_by(drawing.facts)
        if other:
            title = registry.info(other).title
            raise UserError(f"“{drawing.name}” is a file of {title}. Choose that modeler.")
        return guarded.read_drawing(drawing, context, job)

    def from_shapes(self, modeler_id: str, shapes: Shapes, name: str) -> Model:
        """Make a model of shapes from another program.

        Raises
        ------
        UserError
            If the modeler cannot start from shapes.
        """
        info = self._bench.registry.info(modeler_id)
        if "read_shapes" not in info.abilities:
            raise UserError(
                f"{info.title} cannot start from what is there. Choose another modeler."
            )
        state = self._bench.registry.guarded(modeler_id).read_shapes(shapes)
        return self._bench.new_model(modeler_id, state, name)

    def from_mesh_file(
        self, modeler_id: str, file: MeshFile, name: str, values: Mapping[str, object] | None = None
    ) -> Model:
        """Make a model of what was read of a file, upright and in millimetres as far as is known.

        Parameters
        ----------
        modeler_id : str
            The modeler of the new model.
        file : MeshFile
            What was read.
        name : str
            Of the model.
        values : mapping of str to object, optional
            Parameters; *up* and *unit* come before what the file seems to be in.

        Raises
        ------
        UserError
            As in `from_shapes`.
        """
        shapes = file.shapes
        chosen = dict(values or {})
        if file.guess is not None:
            from bozzetto.parameters import parameter_fields

            fields = {field.name for field in parameter_fields(self._state_type(modeler_id))}
            guessed = {"up": file.guess.up, "unit": file.guess.unit}
            if fields.issuperset(guessed):
                chosen = guessed | chosen
            else:
                shapes = file.upright
        model = self.from_shapes(modeler_id, shapes, name)
        return self._bench.set_parameters(model, chosen) if chosen else model

    def ink_of_file(self, modeler_id: str, file: MeshFile, name: str) -> Drawing | None:
        """Return the curves of a file as ink, where it has nothing else and a modeler needs ink."""
        shapes = file.shapes
        starts = "read_shapes" in self._bench.registry.info(modeler_id).abilities
        if starts or not shapes.curves or any(True for _ in shapes.meshes()):
            return None
        from bozzetto.exchange.cad.curves_drawing import drawing_of_curves

        return drawing_of_curves(shapes.curves, name)

    def _state_type(self, modeler_id: str) -> type:
        return self._bench.registry.modeler(modeler_id).state_type

    def following(
        self, modeler_id: str, models: Iterable[Model], job: Job, name: str = ""
    ) -> Model:
        """Make a model that is made from other models and changes with them.

        Parameters
        ----------
        modeler_id : str
            The modeler of the new model.
        models : iterable of Model
            The models to follow, at least one.
        job : Job
            Solves what is not yet solved.
        name : str
            By default the title of the modeler.

        Raises
        ------
        UserError
            If the modeler cannot follow, or has no use for their shapes.
        """
        info = self._bench.registry.info(modeler_id)
        if "follow" not in info.abilities:
            raise UserError(f"{info.title} cannot follow other objects. Choose another modeler.")
        row = tuple(models)
        if not row:
            raise UserError("Choose the objects to start from.")
        shapes = {
            model.id: self._bench.own_shapes(model, job).placed(model.placement) for model in row
        }
        state = self._bench.registry.guarded(modeler_id).follow(shapes)
        return self._bench.new_model(modeler_id, state, name or info.title)

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
        return "add_picture" in self._bench.registry.info(modeler_id).abilities

    def with_picture(self, model: Model, picture: Picture, context: Context) -> Model:
        """Return the model with one more picture to work on.

        Raises
        ------
        UserError
            If its modeler takes no pictures, or has no use for this one.
        """
        modeler = self._bench.guarded(model)
        if not self.takes_pictures(model.modeler):
            title = self._bench.registry.info(model.modeler).title
            raise UserError(f"{title} takes no pictures. Choose another modeler.")
        if not picture.pixels.size:  # unpacked here, for damaged bytes are not the plugin's fault
            raise UserError(f"The picture “{picture.name}” is empty. Choose another one.")
        own = context.moved(model.placement.inverse())
        state = modeler.add_picture(model.state, picture, own)
        return with_state(self._bench.registry, model, state)

    def takes_drawings(self, modeler_id: str) -> bool:
        """Whether drawings of other files can be added to models of a modeler."""
        return "add_drawing" in self._bench.registry.info(modeler_id).abilities

    def with_drawing(self, model: Model, drawing: Drawing, context: Context) -> Model:
        """Return the model with a drawing of another file in it.

        Raises
        ------
        UserError
            If its modeler takes none, or has no use for this one.
        """
        modeler = self._bench.guarded(model)
        if not self.takes_drawings(model.modeler):
            title = self._bench.registry.info(model.modeler).title
            raise UserError(f"{title} takes no drawings. Import the file as an object of its own.")
        if not len(drawing.strokes):
            raise UserError(f"The drawing “{drawing.name}” has no lines. Choose another one.")
        own = context.moved(model.placement.inverse())
        state = modeler.add_drawing(model.state, drawing, own)
        return with_state(self._bench.registry, model, state)

    def from_picture(
        self,
        modeler_id: str,
        picture: Picture,
        values: Mapping[str, object],
        context: Context | None = None,
    ) -> Model:
        """Make a model that works on a picture; see `with_picture`."""
        from bozzetto.plugin.context import Context

        context = context or Context()
        model = self._bench.create(modeler_id, context, name=picture.name)
        model = self.with_picture(model, picture, context)
        return self._bench.set_parameters(model, values) if values else model

    def beside(self, model: Model, document: Document, job: Job) -> Model:
        """Place a new model that nobody drew in its place beside all that is visible.

        It goes along the horizontal axis along which it is narrower, so that two cars stand side
        by side. A model that shows no surface yet, such as a sketch without marks, counts as
        large as one that has just begun; one that has none then, and the first of all, stay.

        Parameters
        ----------
        model : Model
            The new model, which is in no document yet.
        document : Document
            What is there.
        job : Job
            Solves the new model.
        """
        others = [other for other in resolved(document).values() if other.visible]
        there = _around(
            [self._extent(other, self._bench.best_result(other), job) for other in others]
        )
        own = self._extent(model, self._solved(model, job), job)
        if not np.isfinite([there, own]).all():
            return model
        widths = own[1] - own[0]
        axis = int(np.argmin(widths[:2]))
        offset = np.zeros(3)
        offset[axis] = there[1, axis] - own[0, axis] + GAP * widths[axis]
        x, y, z = offset.tolist()
        return replace(model, placement=Placement(offset=(x, y, z)))

    def _extent(self, model: Model, result: Any, job: Job) -> Box:
        """Return the box of the surfaces that a model shows, or would if it had just begun."""
        from bozzetto.plugin.context import Context

        if self._bench.is_foreign(model):
            return NOWHERE
        shown = self._bench.model_scene(model, result).of_kinds(Shaded).bounds()
        if np.isfinite(shown).all():
            return shown
        begun = replace(model, state=self._bench.create(model.modeler, Context()).state)
        scene = self._bench.model_scene(begun, self._solved(begun, job))
        return scene.of_kinds(Shaded).bounds()

    def _solved(self, model: Model, job: Job) -> Any:
        try:
            return self._bench.solve(model, job)
        except UserError:
            return None


def _around(boxes: Iterable[Box]) -> Box:
    """Return the box around boxes, those without extent left out; NaN around none."""
    found = np.array([box for box in boxes if np.isfinite(box).all()] or [NOWHERE])
    return np.array([found[:, 0].min(axis=0), found[:, 1].max(axis=0)])
