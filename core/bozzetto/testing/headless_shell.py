"""A shell without a window: what the program does between the pen and the modeler."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

from bozzetto.document.history import History
from bozzetto.document.links import resolved
from bozzetto.document.model import Document, Model, OpaqueState
from bozzetto.errors import UserError
from bozzetto.geometry.shapes import Shapes
from bozzetto.images.stored_picture import Picture
from bozzetto.ink.stroke import Stroke
from bozzetto.plugin.commands import Command
from bozzetto.plugin.context import Context
from bozzetto.plugin.gesture import Drag, Gesture, Ink, Tap
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.job import Job
from bozzetto.plugin.tool import Tool
from bozzetto.plugin.view_advice import ViewAdvice
from bozzetto.scene.display_list import Handle, Scene
from bozzetto.view.camera import Camera
from bozzetto.workbench.links import with_state
from bozzetto.workbench.workbench import Workbench


class Shell:
    """Opens a modeler, draws with its tools, undoes, solves, saves and opens again.

    Every call takes the way that the program takes: through the registry, its guard, the
    workbench and the history.

    Parameters
    ----------
    registry : Registry
    folder : Path
        An empty folder for saved documents.

    Attributes
    ----------
    camera : Camera
        The view in which gestures are made.
    """

    def __init__(self, registry: Registry, folder: Path) -> None:
        self.registry = registry
        self.workbench = Workbench(registry)
        self.history = History(Document())
        self.camera = Camera()
        self._folder = folder
        self._model_id = ""

    # -- what there is ------------------------------------------------------------

    @property
    def document(self) -> Document:
        """The document now."""
        return self.history.document

    @property
    def model(self) -> Model:
        """The model that is being drawn, with what it follows in it."""
        return resolved(self.document)[self._model_id]

    @property
    def state(self) -> Any:
        """The state of that model."""
        return self.model.state

    def context(self) -> Context:
        """Return the world around a gesture made now, with every model's scene and curves in it."""
        scene = self.workbench.scene(self.document, Job())
        drawn = next((model for model in self.document if model.id == self._model_id), None)
        return Context(
            camera=self.camera,
            scene=scene,
            curves=self.workbench.curves.of(self.document),
            sources={} if drawn is None else self.workbench.given_sources(drawn),
        )

    def commands(self) -> tuple[Command, ...]:
        """Return the commands of the model's modeler; empty where it has none."""
        return self.workbench.commands.of(self.model.modeler)

    def advice(self, camera: Camera | None = None) -> ViewAdvice | None:
        """Return the modeler's advice on a view, by default `camera`; None where it gives none."""
        return self.workbench.view_advice(self.model, camera or self.camera)

    def tools(self) -> tuple[Tool[Any], ...]:
        """Return the tools of the model's modeler."""
        return self.workbench.tools(self.model.modeler)

    def tool(self, wish: str | None, gesture: Literal["ink", "tap", "drag"]) -> Tool[Any]:
        """Return the tool of that id, or the first one for a kind of gesture.

        A tap goes to a tool for drags where there is none for taps.

        Raises
        ------
        UserError
            If there is none.
        """
        if wish is not None:
            return self.workbench.tool(self.model.modeler, wish)
        kinds = ("tap", "drag") if gesture == "tap" else (gesture,)
        for kind in kinds:
            for tool in self.tools():
                if tool.gesture == kind:
                    return tool
        raise UserError(f"The modeler {self.model.modeler} has no tool for {gesture}.")

    def handles(self) -> tuple[Handle, ...]:
        """Return the handles that the model shows."""
        return tuple(item for _, item in self.scene().items() if isinstance(item, Handle))

    # -- what the hand does ------------------------------------------------------------

    def open(self, modeler: str) -> Model:
        """Begin a new, empty model; `modeler` is an id or the last part of one."""
        modeler_id = self.registry.resolve(modeler)
        model = self.workbench.create(modeler_id, self.context())
        self._model_id = model.id
        self._keep("new", model)
        return model

    def draw(self, *strokes: Stroke, tool: str | None = None, committed: bool = True) -> Model:
        """Draw strokes with a tool, by default the first that takes ink."""
        return self.do(Ink(strokes, committed), tool=self.tool(tool, "ink"))

    def tap(self, x: float, y: float, *, tool: str | None = None) -> Model:
        """Tap the sheet at canvas pixels, by default with the first tool for taps."""
        return self.do(Tap(x, y, self.camera), tool=self.tool(tool, "tap"))

    def drag(self, handle: str, path: Stroke, *, tool: str | None = None) -> Model:
        """Take a handle along a path, by default with the first tool for drags."""
        return self.do(Drag(handle, path), tool=self.tool(tool, "drag"))

    def do(self, gesture: Gesture, *, tool: Tool[Any]) -> Model:
        """Apply any gesture with a tool: preview, then apply, as the program does."""
        context = self.context()
        self.workbench.preview(self.model, tool, gesture, context)
        return self._keep(tool.title, self.workbench.apply(self.model, tool, gesture, context))

    def preview(self, gesture: Gesture, *, tool: Tool[Any]) -> Scene:
        """Return what is shown while the pen is down."""
        return self.workbench.preview(self.model, tool, gesture, self.context())

    def run(self, command: str) -> Model:
        """Run a command by its id."""
        commands = self.workbench.commands
        found = commands.find(self.model.modeler, command)
        return self._keep(found.title, commands.run(self.model, found, self.context()))

    def use(self, modeler: str) -> Model:
        """Begin a model of another modeler that follows this one, or starts from its shapes."""
        modeler_id = self.registry.resolve(modeler)
        sources = self.workbench.sources
        follows = "follow" in self.registry.info(modeler_id).abilities
        made = sources.following if follows else sources.from_models
        model = made(modeler_id, [self.model], Job())
        self._model_id = model.id
        return self._keep("use", model)

    def choose(self, model_id: str) -> Model:
        """Go on with another model of the document, such as one that the last one follows."""
        model = resolved(self.document)[model_id]
        self._model_id = model_id
        return model

    def place(self, picture: Picture) -> Model:
        """Give the model a picture to work on, as if it had been dropped on the sheet."""
        made = self.workbench.sources.with_picture(self.model, picture, self.context())
        return self._keep("Add sketch", made)

    def set(self, **values: object) -> Model:
        """Change parameters."""
        return self._keep("parameters", self.workbench.set_parameters(self.model, values))

    def put(self, state: Any) -> Model:
        """Continue from a state of your own."""
        return self._keep("state", with_state(self.registry, self.model, state))

    def undo(self) -> bool:
        """Take the last step back; false where there is none."""
        before = self.history.position
        self.history.undo()
        return self.history.position != before

    def redo(self) -> bool:
        """Take a step forward again; false where there is none."""
        before = self.history.position
        self.history.redo()
        return self.history.position != before

    # -- what comes out ------------------------------------------------------------

    def solve(self, job: Job | None = None) -> Any:
        """Solve the model; `job` is by default a final one that nobody cancels."""
        return self.workbench.solve(self.model, job or Job())

    def scene(self) -> Scene:
        """Return the scene of the solved model."""
        return self.workbench.model_scene(self.model, self.solve())

    def shapes(self) -> Shapes:
        """Return the shapes for export."""
        return self.workbench.shapes([self.model], Job())

    def save(self) -> Path:
        """Save the document in the shell's folder."""
        from bozzetto.document.storage.bozz_file import write_document

        path = self._folder / "document.bozz"
        write_document(self.document, path)
        return path

    def reopen(self) -> Sequence[str]:
        """Save the document, open it again and go on with that.

        Returns
        -------
        sequence of str
            What the program would tell the person about it.

        Raises
        ------
        UserError
            If the model came back closed, because its modeler cannot be had.
        """
        from bozzetto.document.storage.bozz_file import read_document

        document, report = read_document(self.save(), self.registry)
        self.history = History(document)
        if isinstance(self.model.state, OpaqueState):
            raise UserError(f"The model came back closed: {'; '.join(report.warnings)}")
        return report.warnings

    def _keep(self, label: str, model: Model) -> Model:
        self.history.apply(label, self.document.with_model(model))
        return model
