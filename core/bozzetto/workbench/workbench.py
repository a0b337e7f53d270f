"""The workbench: documents, modelers and pictures brought together, without a window.

The shell and the command line both do their work through these functions, so whatever the
pen can do can be done from a script or a test. Every call into a plugin goes through the
registry's guard.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from bozzetto.document.links import resolved
from bozzetto.document.model import Document, Model, OpaqueState, new_id
from bozzetto.errors import UserError
from bozzetto.plugin.overrides import overrides
from bozzetto.scene.display_list import Image, Layer, Scene
from bozzetto.workbench.commands import ModelCommands
from bozzetto.workbench.curve_cache import KnownCurves
from bozzetto.workbench.links import frozen_cautions, with_state
from bozzetto.workbench.part_edits import PartEdits
from bozzetto.workbench.placed import plain, scene_in_world, shapes_in_world
from bozzetto.workbench.readings import InkReadings
from bozzetto.workbench.results import KnownResults
from bozzetto.workbench.sources import ModelSources

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement
    from bozzetto.geometry.shapes import Shapes
    from bozzetto.plugin.cautions import Caution
    from bozzetto.plugin.context import Context
    from bozzetto.plugin.figures import Figure
    from bozzetto.plugin.gesture import Drag, Gesture
    from bozzetto.plugin.guard.guarded_modeler import GuardedModeler
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.job import Job
    from bozzetto.plugin.modeler import Modeler
    from bozzetto.plugin.next_step import NextStep
    from bozzetto.plugin.tool import Tool
    from bozzetto.plugin.view_advice import ViewAdvice
    from bozzetto.view.camera import Camera
    from bozzetto.workbench.previews import ModelPreview


class Workbench:
    """Runs modelers on documents.

    Parameters
    ----------
    registry : Registry
        Where modelers come from, and the guard that every call passes.

    Attributes
    ----------
    parts : PartEdits
        Edits of the parts of models.
    commands : ModelCommands
        Commands of modelers.
    sources : ModelSources
        Makes models of drawings, shapes and pictures.
    readings : InkReadings
        Ink that is there, read by other modelers.
    curves : KnownCurves
        What solved models offer to snap to and to start from.

    Notes
    -----
    Results are derived: they are cached by the identity of the (immutable) state, and of the
    results that it was made from, and may be dropped at any time. All methods may be called from
    any thread.
    """

    def __init__(self, registry: Registry) -> None:
        self.registry = registry
        self.parts = PartEdits(registry)
        self.commands = ModelCommands(registry)
        self.curves = KnownCurves(registry)
        self.sources = ModelSources(self)
        self.readings = InkReadings(self)
        self._results = KnownResults(self)
        self._moved: tuple[Scene, Placement, Scene] | None = None

    # -- making and changing models --

    def create(self, modeler_id: str, context: Context, *, name: str | None = None) -> Model:
        """Make an empty model of a modeler."""
        state = self.registry.guarded(modeler_id).create(context)
        return self.new_model(modeler_id, state, name or self.registry.info(modeler_id).title)

    def new_model(self, modeler_id: str, state: Any, name: str) -> Model:
        """Return a new model of a state that its modeler made."""
        version = self.registry.modeler(modeler_id).state_version
        model = Model(new_id(), name, modeler_id, state, state_version=version)
        return with_state(self.registry, model, state)

    def tool(self, modeler_id: str, tool_id: str) -> Tool[Any]:
        """Return a tool of a modeler by its id.

        Raises
        ------
        UserError
            If the modeler has no such tool.
        """
        for tool in self.tools(modeler_id):
            if tool.id == tool_id:
                return tool
        raise UserError(f"The modeler {modeler_id} has no tool {tool_id!r}.")

    def tools(self, modeler_id: str) -> tuple[Tool[Any], ...]:
        """Return all tools of a modeler."""
        return self.registry.guarded(modeler_id).tools()

    def apply(self, model: Model, tool: Tool[Any], gesture: Gesture, context: Context) -> Model:
        """Return the model after a gesture with one of its tools.

        Gesture and context are in the world; the tool gets them in the model's own frame.

        Raises
        ------
        UserError, Unfinished
            As the tool says.
        PluginFault
            If the tool fails otherwise.
        """
        modeler, (to_own, own) = self.guarded(model), self._frame_of(model, context)
        state = modeler.apply(tool, model.state, gesture.moved(to_own), own)
        return with_state(self.registry, model, state)

    def differs(self, before: Model, after: Model, *, only_chosen: bool = False) -> bool:
        """Whether anything at all is different in two states of a model.

        Parameters
        ----------
        before, after : Model
            Two states of one model.
        only_chosen : bool
            Whether at most the chosen part differs; then states are compared by value.
        """
        if before.state is after.state:
            return False
        if not only_chosen:
            return True
        return not self.guarded(before).is_same(before.state, after.state)

    def begin(self, model: Model, tool: Tool[Any], context: Context) -> ModelPreview:
        """Return the preview of a gesture that begins; gestures and scenes are in the world."""
        from bozzetto.workbench.previews import ModelPreview

        to_own, own = self._frame_of(model, context)
        modeler = self.guarded(model)
        return ModelPreview(modeler, modeler.begin(tool, model.state, own), model, to_own)

    def preview(self, model: Model, tool: Tool[Any], gesture: Gesture, context: Context) -> Scene:
        """Return what a gesture shows while the pen is down, in the world; see `begin`."""
        return self.begin(model, tool, context).update(gesture)

    def step(
        self,
        model: Model,
        tool: Tool[Any],
        held: Drag | None,
        seconds: float,
        context: Context,
    ) -> Model:
        """Return the model a moment later, by a tool that moves it; see `Tool.step`.

        Parameters
        ----------
        model : Model
            As the last step left it.
        tool : Tool
            One of its modeler's.
        held : Drag, optional
            The drag so far, in the world.
        seconds : float
            Time since the last step.
        context : Context
            The world around.
        """
        to_own, own = self._frame_of(model, context)
        held = None if held is None else held.moved(to_own)
        state = self.guarded(model).step(tool, model.state, held, seconds, own)
        return model if state is model.state else with_state(self.registry, model, state)

    def recorded(self, model: Model) -> tuple[float, ...]:
        """Return the times at which a model has recorded how it moved; see `Modeler.recorded`."""
        return self.guarded(model).recorded(model.state)

    def replayed(self, model: Model, seconds: float) -> Model:
        """Return a model as it was at a time of its recording; see `Modeler.replayed`."""
        state = self.guarded(model).replayed(model.state, seconds)
        return model if state is model.state else with_state(self.registry, model, state)

    def next_step(self, model: Model, tool: Tool[Any]) -> NextStep:
        """Return what to do next with a tool, as the model is now; its place is in the world."""
        step = self.guarded(model).next_step(model.state, tool)
        if step.place is None:
            return step
        x, y, z = model.placement.points([step.place])[0].tolist()
        return replace(step, place=(x, y, z))

    def _frame_of(self, model: Model, context: Context) -> tuple[Placement, Context]:
        """Return the way into a model's own frame, and the world as it is seen from there.

        The newest moved scene is kept: moving one takes longer than a preview may.
        """
        inverse = model.placement.inverse()
        if inverse.is_identity:
            return inverse, context
        known = self._moved
        if known is None or known[0] is not context.scene or known[1] != inverse:
            known = self._moved = (context.scene, inverse, context.scene.placed(inverse))
        rest = replace(context, scene=Scene()).moved(inverse)
        return inverse, replace(rest, scene=known[2])

    def set_parameters(self, model: Model, values: Mapping[str, object]) -> Model:
        """Return the model with parameters changed.

        Names that the state does not know are parameters of its parts; see
        `PartEdits.set_parameters`.

        Raises
        ------
        UserError
            If a name is unknown or a value out of range.
        PluginFault
            If the state's own check of itself fails.
        """
        self.guarded(model)  # refuses what is closed
        return self.parts.set_parameters(model, values)

    # -- looking --

    def view_advice(
        self,
        model: Model,
        camera: Camera,
        seen: Iterable[Model] = (),
        job: Job | None = None,
        result: Any | None = None,
    ) -> ViewAdvice | None:
        """Return the modeler's advice on a view of a model; None where it gives none.

        The camera is in the world, and so is what comes back.

        Parameters
        ----------
        model : Model
            The model that is drawn on.
        camera : Camera
            The view.
        seen : iterable of Model
            The model as it was a moment ago, newest first, while the view was pinned to it or
            showed it as it was drawn. Where it has changed, the view may have to go along; see
            `Modeler.view_after`.
        job : Job, optional
            Says whether anybody still waits for the advice.
        result : optional
            What is seen of the model; the best known result without it.
        """
        from bozzetto.plugin.job import Job

        modeler = self.guarded(model)
        own = camera.moved(model.placement.inverse())
        if result is None:
            result = self.best_result(model)
        if result is not None and self.advises_on_results(model.modeler):
            earlier = self._results_of(seen, model.placement, result)
            advice = modeler.advice_on_result(model.state, result, own, earlier)
            return None if advice is None else self._in_world(model, advice)
        along = self._view_after(modeler, model, own, seen)
        advice = modeler.view_advice(model.state, along or own, job or Job())
        if advice is None:
            return None
        if along is not None:
            advice = replace(advice, better=along, pinned=True, follow=True)
        return self._in_world(model, advice)

    def _in_world(self, model: Model, advice: ViewAdvice) -> ViewAdvice:
        better = advice.better
        return replace(
            advice,
            better=None if better is None else better.moved(model.placement),
            scene=scene_in_world(advice.scene, model),
        )

    def advises(self, modeler_id: str) -> bool:
        """Whether a modeler may have advice on a view; False where it cannot be used."""
        modeler = self._usable(modeler_id)
        return modeler is not None and (
            overrides(modeler, "view_advice") or overrides(modeler, "advice_on_result")
        )

    def advises_on_results(self, modeler_id: str) -> bool:
        """Whether a modeler's advice on a view follows from results, which may be previews."""
        modeler = self._usable(modeler_id)
        return modeler is not None and overrides(modeler, "advice_on_result")

    def _usable(self, modeler_id: str) -> Modeler[Any, Any] | None:
        """Return a modeler; None where its plugin is absent, broken or switched off."""
        try:
            return self.registry.modeler(modeler_id)
        except UserError:
            return None

    def _results_of(self, seen: Iterable[Model], placement: Placement, now: Any) -> tuple[Any, ...]:
        """Return the results of earlier states that are still known, but for that of now."""
        known = (
            self.result(model, quality)
            for model in seen
            if model.placement == placement
            for quality in ("final", "preview")
        )
        return tuple(result for result in known if result is not None and result is not now)

    @staticmethod
    def _view_after(
        modeler: GuardedModeler, model: Model, camera: Camera, seen: Iterable[Model]
    ) -> Camera | None:
        """Return the view that a pinned view becomes, in the model's own frame."""
        for before in seen:
            if before.state is model.state or before.placement != model.placement:
                continue
            found = modeler.view_after(before.state, model.state, camera)
            if found is not None:
                return found
        return None

    def advice_scene(self, document: Document, camera: Camera, job: Job | None = None) -> Scene:
        """Return what depends on the view of the visible models; lay it over their scene."""
        layers: list[Layer] = []
        for model in document:
            if model.visible and not self.is_foreign(model):
                advice = self.view_advice(model, camera, job=job)
                layers.extend(advice.scene.layers if advice is not None else ())
        return Scene(tuple(layers))

    # -- solving --

    def solve(self, model: Model, job: Job) -> Any:
        """Return the result of a model's recipe: remembered, or solved now.

        What it follows has to be in it (`bozzetto.document.links.resolved`); that is solved too.

        Raises
        ------
        UserError
            If it has no solution, or one of its sources has none.
        PluginFault
            If its plugin fails.
        """
        return self._results.solve(model, job)

    def result(self, model: Model, quality: str = "final") -> Any | None:
        """Return the remembered result of exactly this recipe, or None."""
        return self._results.known(model, quality)

    def given_sources(self, model: Model) -> Mapping[str, Shapes]:
        """Return what a model was made from when it was solved last, for `Context.sources`.

        It is in the frame of the model; empty before. Nothing is solved for it.
        """
        return self._results.given_sources(model)

    def forget_results(self) -> None:
        """Drop all results and what modelers remember: their documents are closed."""
        from bozzetto.plugin.cache import forget_all

        self._results.forget()
        forget_all()
        self.curves.forget()

    def best_result(self, model: Model) -> Any | None:
        """Return the final result where it is known, else the preview's, else None."""
        final = self.result(model, "final")
        return final if final is not None else self.result(model, "preview")

    # -- what to show and to hand over --

    def model_scene(self, model: Model, result: Any | None) -> Scene:
        """Return one model's scene in the world, marked as its own."""
        return scene_in_world(self.guarded(model).scene(model.state, result), model)

    def scene(self, document: Document, job: Job | None = None) -> Scene:
        """Return all visible models and underlays of a document.

        Parameters
        ----------
        document : Document
            The document to show.
        job : Job, optional
            Solves what is not yet solved; without it unsolved models show what they can.
        """
        layers = list(self.underlay_layers(document))
        for model in resolved(document).values():
            if model.visible and not self.is_foreign(model):
                result = self.best_result(model) if job is None else self.solve(model, job)
                layers.extend(self.model_scene(model, result).layers)
        return Scene(tuple(layers))

    @staticmethod
    def underlay_layers(document: Document) -> Iterator[Layer]:
        """Yield the visible underlays, each as a layer."""
        for underlay in document.underlays:
            if underlay.visible:
                image = Image(
                    underlay.pixels,
                    underlay.corner,
                    underlay.across,
                    underlay.down,
                    underlay.opacity,
                )
                yield Layer(underlay.name, (image,))

    @staticmethod
    def is_alone(document: Document, model: Model | None) -> bool:
        """Whether nothing is visible but a model, or nothing at all."""
        wanted = "" if model is None else model.id
        others = any(each.visible and each.id != wanted for each in document)
        return not others and not any(underlay.visible for underlay in document.underlays)

    @staticmethod
    def is_foreign(model: Model) -> bool:
        """Whether a model belongs to a plugin that is not here."""
        return isinstance(model.state, OpaqueState)

    def is_usable(self, model: Model) -> bool:
        """Whether a model can be changed and solved: its plugin is here, on, and can read it."""
        standing = self.registry.standing(model.modeler)
        return standing.status in ("ready", "loaded") and not self.is_foreign(model)

    def shapes(self, models: Iterable[Model], job: Job) -> Shapes:
        """Return the shapes of models, in the world, named and coloured as in the document.

        Of a document they are those of all its models; single models are given with what they
        follow in them (`bozzetto.document.links.resolved`).
        """
        from bozzetto.geometry.shapes import Shapes

        total = Shapes()
        for model in resolved(models).values() if isinstance(models, Document) else models:
            if self.is_foreign(model):
                continue
            total += shapes_in_world(self.own_shapes(model, job), model)
        return total

    def own_shapes(self, model: Model, job: Job) -> Shapes:
        """Return the shapes of a model as its modeler hands them over, in its own frame."""
        return self.guarded(model).shapes(model.state, self.solve(model, job))

    def report(self, model: Model, job: Job) -> dict[str, Any]:
        """Return figures on a model's quality, as JSON values; empty if its modeler has none."""
        said = self.guarded(model).report(model.state, self.solve(model, job), job)
        return {str(key): plain(value) for key, value in said.items()}

    def figures(self, model: Model) -> Mapping[str, Figure]:
        """Return the words, units and bounds of what `report` tells; see `Modeler.figures`."""
        return self.registry.modeler(model.modeler).figures

    def first_parameters(self, model: Model) -> tuple[str, ...]:
        """Return the parameters of a model and its parts that come first in forms.

        Those of a model whose plugin is not here come in their own order.
        """
        try:
            return self.registry.modeler(model.modeler).first_parameters
        except UserError:
            return ()

    def cautions(self, model: Model, job: Job) -> tuple[Caution, ...]:
        """Return what a person must know of a model's result; empty where all is well."""
        told = self.guarded(model).cautions(model.state, self.solve(model, job))
        return (*told, *frozen_cautions(model))

    def guarded(self, model: Model) -> GuardedModeler:
        """Return the modeler of a model.

        Raises
        ------
        UserError
            If its plugin is not here.
        """
        if self.is_foreign(model):
            raise UserError(
                f"“{model.name}” was made with the modeler {model.modeler!r}, whose plugin is not "
                "installed or switched off. Install it to change this object."
            )
        return self.registry.guarded(model.modeler)
