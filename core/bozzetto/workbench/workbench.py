"""The workbench: documents, modelers and pictures brought together, without a window.

The shell and the command line both do their work through these functions, so whatever the
pen can do can be done from a script or a test. Every call into a plugin goes through the
registry's guard.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from bozzetto.document.model import Document, Model, OpaqueState, new_id
from bozzetto.errors import UserError
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.shapes import Shapes
from bozzetto.plugin.cache import forget_all
from bozzetto.plugin.cautions import Caution, Warns
from bozzetto.plugin.context import Context
from bozzetto.plugin.gesture import Gesture
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.job import Job
from bozzetto.plugin.modeler import (
    Modeler,
    Reports,
    TellsNext,
    Tool,
)
from bozzetto.plugin.view_advice import AdvisesOnResults, AdvisesView, MovesView, ViewAdvice
from bozzetto.scene.display_list import Image, Layer, Scene
from bozzetto.view.camera import Camera
from bozzetto.workbench.commands import ModelCommands
from bozzetto.workbench.curve_cache import KnownCurves
from bozzetto.workbench.part_edits import PartEdits
from bozzetto.workbench.placed import plain, scene_in_world, shapes_in_world
from bozzetto.workbench.sources import ModelSources

KEPT_RESULTS = 64
"""Limit of solved results that are kept; they can always be made again."""


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
    curves : KnownCurves
        What solved models offer to snap to and to start from.

    Notes
    -----
    Results are derived: they are cached by the identity of the (immutable) state and may
    be dropped at any time. All methods may be called from any thread.
    """

    def __init__(self, registry: Registry) -> None:
        self.registry = registry
        self.parts = PartEdits(registry)
        self.commands = ModelCommands(registry)
        self.curves = KnownCurves(registry)
        self.sources = ModelSources(self)
        self._results: OrderedDict[tuple[int, str], tuple[Any, Any]] = OrderedDict()
        self._lock = threading.Lock()
        self._moved: tuple[Scene, Placement, Scene] | None = None

    # -- making and changing models --

    def create(self, modeler_id: str, context: Context, *, name: str | None = None) -> Model:
        """Make an empty model of a modeler."""
        modeler = self.registry.modeler(modeler_id)
        state = self.registry.guard.call(modeler_id, "create", modeler.create, context)
        self.registry.guard.check_state(modeler_id, modeler.state_type, state)
        return Model(
            new_id(),
            name or modeler.title,
            modeler_id,
            state,
            state_version=modeler.state_version,
        )

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
        modeler = self.registry.modeler(modeler_id)
        made = self.registry.guard.call(modeler_id, "tools", modeler.tools)
        return self.registry.guard.check_tools(modeler_id, made)

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
        self._refuse_closed(model)
        gesture, context = self._in_frame_of(model, gesture, context)
        state = self.registry.guard.call(
            model.modeler, f"{tool.id}.apply", tool.apply, model.state, gesture, context
        )
        modeler = self.registry.modeler(model.modeler)
        self.registry.guard.check_state(model.modeler, modeler.state_type, state)
        return replace(model, state=state)

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
        same = self.registry.guard.call(
            before.modeler,
            "its state",
            lambda one, two: bool(one == two),
            before.state,
            after.state,
        )
        return not same

    def preview(self, model: Model, tool: Tool[Any], gesture: Gesture, context: Context) -> Scene:
        """Return what to show while the pen is down, in the world, marked as the model's own.

        A layer stands in for the model's layer of the same name; see `Scene.under`.
        """
        gesture, context = self._in_frame_of(model, gesture, context)
        scene = self.registry.guard.call(
            model.modeler, f"{tool.id}.preview", tool.preview, model.state, gesture, context
        )
        return scene_in_world(self.registry.guard.check_scene(model.modeler, scene), model)

    def next_hint(self, model: Model, tool: Tool[Any]) -> str:
        """Say what to do next with a tool, as the model is now."""
        if not isinstance(tool, TellsNext):
            return tool.hint
        guard = self.registry.guard
        said = guard.call(model.modeler, f"{tool.id}.next_hint", tool.next_hint, model.state)
        return guard.check_hint(model.modeler, said)

    def _in_frame_of(
        self, model: Model, gesture: Gesture, context: Context
    ) -> tuple[Gesture, Context]:
        """Return a gesture and its world as they are in a model's own frame.

        The newest moved scene is kept: moving one takes longer than a preview may.
        """
        if model.placement.is_identity:
            return gesture, context
        inverse = model.placement.inverse()
        known = self._moved
        if known is None or known[0] is not context.scene or known[1] != inverse:
            known = self._moved = (context.scene, inverse, context.scene.placed(inverse))
        rest = replace(context, scene=Scene()).moved(inverse)
        return gesture.moved(inverse), replace(rest, scene=known[2])

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
        self._refuse_closed(model)
        return self.parts.set_parameters(model, values)

    # -- looking --

    def view_advice(
        self, model: Model, camera: Camera, seen: Iterable[Model] = ()
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
            The model as it was a moment ago, newest first, while the view was pinned to it. Where
            it has changed, the view may have to go along; see `MovesView`.
        """
        modeler = self._modeler_of(model)
        if not isinstance(modeler, AdvisesView):
            return None
        own = camera.moved(model.placement.inverse())
        result = self.best_result(model)
        if result is not None and isinstance(modeler, AdvisesOnResults):
            earlier = self._results_of(seen, model.placement, result)
            advice = self.registry.guard.call(
                model.modeler, "advice_on_result", modeler.advice_on_result,
                model.state, result, own, earlier,
            )  # fmt: skip
            return self._in_world(model, self.registry.guard.check_advice(model.modeler, advice))
        along = self._view_after(model, modeler, own, seen)
        advice = self.registry.guard.call(
            model.modeler, "view_advice", modeler.view_advice, model.state, along or own
        )
        advice = self.registry.guard.check_advice(model.modeler, advice)
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

    def _results_of(self, seen: Iterable[Model], placement: Placement, now: Any) -> tuple[Any, ...]:
        """Return the results of earlier states that are still known, but for that of now."""
        known = (
            self.result(model, quality)
            for model in seen
            if model.placement == placement
            for quality in ("final", "preview")
        )
        return tuple(result for result in known if result is not None and result is not now)

    def _view_after(
        self, model: Model, modeler: object, camera: Camera, seen: Iterable[Model]
    ) -> Camera | None:
        """Return the view that a pinned view becomes, in the model's own frame."""
        if not isinstance(modeler, MovesView):
            return None
        for before in seen:
            if before.state is model.state or before.placement != model.placement:
                continue
            found = self.registry.guard.call(
                model.modeler, "view_after", modeler.view_after, before.state, model.state, camera
            )
            if found is not None:
                view: Camera = self.registry.guard.check_view(model.modeler, found)
                return view
        return None

    def advice_scene(self, document: Document, camera: Camera) -> Scene:
        """Return what depends on the view of the visible models; lay it over their scene."""
        layers: list[Layer] = []
        for model in document:
            if model.visible and not self.is_foreign(model):
                advice = self.view_advice(model, camera)
                layers.extend(advice.scene.layers if advice is not None else ())
        return Scene(tuple(layers))

    # -- solving --

    def solve(self, model: Model, job: Job) -> Any:
        """Return the result of a model's recipe: remembered, or solved now."""
        known = self.result(model, job.quality)
        if known is not None:
            return known
        modeler = self._modeler_of(model)
        result = self.registry.guard.call(model.modeler, "solve", modeler.solve, model.state, job)
        if job.quality == "final":
            # A preview has some milliseconds, and its curves would be exchanged in a moment.
            self.curves.try_to_learn(model, result)
        with self._lock:
            self._results[id(model.state), job.quality] = (model.state, result)
            while len(self._results) > KEPT_RESULTS:
                self._results.popitem(last=False)
        return result

    def result(self, model: Model, quality: str = "final") -> Any | None:
        """Return the remembered result of exactly this state, or None."""
        with self._lock:
            entry = self._results.get((id(model.state), quality))
            if entry is None or entry[0] is not model.state:
                return None
            self._results.move_to_end((id(model.state), quality))
            return entry[1]

    def forget_results(self) -> None:
        """Drop all results and what modelers remember: their documents are closed."""
        with self._lock:
            self._results.clear()
        forget_all()
        self.curves.forget()

    def best_result(self, model: Model) -> Any | None:
        """Return the final result where it is known, else the preview's, else None."""
        final = self.result(model, "final")
        return final if final is not None else self.result(model, "preview")

    # -- what to show and to hand over --

    def model_scene(self, model: Model, result: Any | None) -> Scene:
        """Return one model's scene in the world, marked as its own."""
        modeler = self._modeler_of(model)
        scene = self.registry.guard.call(model.modeler, "scene", modeler.scene, model.state, result)
        scene = self.registry.guard.check_scene(model.modeler, scene)
        return scene_in_world(scene, model)

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
        for model in document:
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
    def is_foreign(model: Model) -> bool:
        """Whether a model belongs to a plugin that is not here."""
        return isinstance(model.state, OpaqueState)

    def shapes(self, models: Iterable[Model], job: Job) -> Shapes:
        """Return the shapes of models, in the world, named and coloured as in the document."""
        total = Shapes()
        for model in models:
            if self.is_foreign(model):
                continue
            modeler = self._modeler_of(model)
            result = self.solve(model, job)
            shapes = self.registry.guard.call(
                model.modeler, "shapes", modeler.shapes, model.state, result
            )
            self.registry.guard.check_shapes(model.modeler, shapes)
            total += shapes_in_world(shapes, model)
        return total

    def report(self, model: Model, job: Job) -> dict[str, Any]:
        """Return figures on a model's quality, as JSON values; empty if its modeler has none."""
        modeler = self._modeler_of(model)
        result = self.solve(model, job)
        if not isinstance(modeler, Reports):
            return {}
        said = self.registry.guard.call(
            model.modeler, "report", modeler.report, model.state, result
        )
        said = self.registry.guard.check_report(model.modeler, said)
        return {str(key): plain(value) for key, value in said.items()}

    def cautions(self, model: Model, job: Job) -> tuple[Caution, ...]:
        """Return what a person must know of a model's result; empty where all is well."""
        modeler = self._modeler_of(model)
        if not isinstance(modeler, Warns):
            return ()
        result = self.solve(model, job)
        said = self.registry.guard.call(
            model.modeler, "cautions", modeler.cautions, model.state, result
        )
        return self.registry.guard.check_cautions(model.modeler, said)

    def _modeler_of(self, model: Model) -> Modeler[Any, Any]:
        self._refuse_closed(model)
        return self.registry.modeler(model.modeler)

    def _refuse_closed(self, model: Model) -> None:
        if self.is_foreign(model):
            raise UserError(
                f"“{model.name}” was made with the plugin {model.modeler!r}, which is not "
                "installed or switched off. Install it to change this object."
            )
