"""The car modeler: marks on sketches in, a body of exact surfaces out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from bozzetto.errors import UserError
from bozzetto.geometry import Curve, Shapes
from bozzetto.ink import Drawing, Strokes
from bozzetto.plugin import (
    Caution,
    Command,
    Context,
    Group,
    Job,
    NextStep,
    PartsModeler,
    Tool,
    ViewAdvice,
    override,
)
from bozzetto.scene import Picture, Scene
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.body.build import body_of
from bozzetto_car.body.drag_preview import body_at_rest_of, preview_of
from bozzetto_car.body.edge_ink import ink_of
from bozzetto_car.commands import all_commands
from bozzetto_car.export import curves_of, shapes_of
from bozzetto_car.listening import listening
from bozzetto_car.marking.standing_mesh import standing_mesh
from bozzetto_car.marks_file import (
    car_from_facts,
    car_of_template,
    is_car_file,
    is_template_file,
)
from bozzetto_car.report import FIGURES, cautions_of, report_of
from bozzetto_car.solver.pipeline import blend_problem
from bozzetto_car.state import CarMesh, CarState, Sketch, StylingCurve
from bozzetto_car.styling.commands import styling_commands
from bozzetto_car.tools import all_tools
from bozzetto_car.view.mark_items import MARK_TOOL
from bozzetto_car.view.next_step import needs_marks, next_mark_step
from bozzetto_car.view.scene import scene_of
from bozzetto_car.view.view_advice import advice_following, advice_on, view_after

NO_MARKS: Final = (
    "This file holds no marks of a car. Give a file with “views”, or drop a picture and mark it."
)


SOLVING: Final = "Cameras and shape"


class Car(PartsModeler[CarState, Body]):
    """The modeler in which a template takes the shape of a marked sketch (Kara & Shimada 2008)."""

    id = "bozzetto.car"
    state_type = CarState
    state_version = 2
    part_types = (Sketch, CarMesh, StylingCurve, Group)
    first_parameters = ("template", "trace", "shading")
    figures = FIGURES

    @override
    def upgrade(self, state: dict[str, Any], version: int) -> dict[str, Any]:
        """Return today's form of a state; before 2 a template of one's own counted if there."""
        if version < 2 and state.get("own"):
            return {**state, "template": "own"}
        return state

    @override
    def create(self, context: Context) -> CarState:
        """Return the template as it stands, or the car of a file's marks or template."""
        return _car_of(context, Job())

    @override
    def tools(self) -> Sequence[Tool[CarState]]:
        """Return the tools of the pen, most used first."""
        return all_tools()

    @override
    def commands(self) -> Sequence[Command]:
        """Return the commands for a car and its styling curves."""
        return (*all_commands(), *styling_commands())

    @override
    def ink(self, state: CarState) -> Strokes:
        """Return the strokes along edges, those on a sketch as seen through its camera."""
        return ink_of(state)

    @override
    def read_drawing(self, drawing: Drawing, context: Context, job: Job) -> CarState:
        """Return the car of a file's marks, or one that begins with the template of a file.

        Raises
        ------
        UserError
            If there are neither, or they make no sense; the message names the key.
        """
        if not (is_car_file(context.facts) or is_template_file(context.facts)):
            raise UserError(NO_MARKS)
        return _car_of(context, job)

    @override
    def add_picture(self, state: CarState, picture: Picture, context: Context) -> CarState:
        """Add a sketch, which is chosen; or give the chosen sketch its missing picture."""
        chosen = next((s for s in state.sketches if s.id == state.selected), None)
        if chosen is not None and chosen.picture is None:
            return state.with_node(replace(chosen, picture=picture))
        sketch = Sketch(
            id=state.unused_id(),
            name=state.unused_name("Sketch"),
            picture=picture,
            width=float(picture.width),
            height=float(picture.height),
        )
        return replace(state.with_node(sketch), asked="")

    @override
    def read_shapes(self, shapes: Shapes) -> CarState:
        """Return a car that takes the shape of a mesh, by the points that its file names."""
        return CarState().with_node(standing_mesh(shapes, "n1", "Mesh"))

    @override
    def solve(self, state: CarState, job: Job) -> Body:
        """Solve cameras, shape and surfaces; see `solver` and `body`."""
        with listening(job, 0.0, SOLVING):
            return preview_of(state) if job.quality == "preview" else body_at_rest_of(state)

    @override
    def scene(self, state: CarState, result: Body | None) -> Scene:
        """Return the sketch, the body over it, and the handles."""
        return scene_of(state, result)

    @override
    def shapes(self, state: CarState, result: Body) -> Shapes:
        """Return the surfaces, exact bicubic patches, and the styling curves."""
        return shapes_of(state, result)

    @override
    def curves(self, state: CarState, result: Body) -> tuple[Curve, ...]:
        """Return edges and styling curves for other models to snap to."""
        return curves_of(state, result)

    @override
    def report(self, state: CarState, result: Body, job: Job) -> Mapping[str, Any]:
        """Return nodes, cameras, residuals, constraints, creases and dimensions."""
        return report_of(result, state.edits, job, state.tyre)

    @override
    def cautions(self, state: CarState, result: Body) -> tuple[Caution, ...]:
        """Return what was left out, and whether any sketch shapes the car."""
        problem = blend_problem(state)
        return (*((Caution(problem),) if problem else ()), *cautions_of(result))

    @override
    def next_step(self, state: CarState, tool: Tool[CarState]) -> NextStep:
        """Return the next mark while the sketch in work has no camera, else what the tool says."""
        if tool.id != MARK_TOOL and needs_marks(state):
            return replace(next_mark_step(state), tool=MARK_TOOL)
        return tool.next_step(state)

    @override
    def view_advice(self, state: CarState, camera: Camera, job: Job) -> ViewAdvice:
        """Return whether the view is through the sketch, and the way back to it."""
        with listening(job, 0.0, SOLVING):
            return advice_on(state, body_of(state), camera)

    @override
    def view_after(self, seen: CarState, state: CarState, camera: Camera) -> Camera | None:
        """Return the view through the sketch's new camera, for a view through an earlier one."""
        return view_after(seen, state, camera)

    @override
    def advice_on_result(
        self, state: CarState, result: Body, camera: Camera, seen: Sequence[Body]
    ) -> ViewAdvice:
        """Return the same of a solved car, which may be a preview; nothing is solved for it."""
        return advice_following(state, result, camera, seen)

    @override
    def with_parts(
        self,
        state: CarState,
        nodes: tuple[Sketch | CarMesh | StylingCurve | Group, ...],
        selected: str,
    ) -> CarState:
        """Return the state with other parts; where none is chosen, no tangents are revealed."""
        revealed = state.revealed if selected else ""
        return replace(state, nodes=nodes, selected=selected, revealed=revealed)


def _car_of(context: Context, job: Job) -> CarState:
    if is_car_file(context.facts):
        return car_from_facts(context.facts, context.pictures, job, context.templates)
    if is_template_file(context.facts):
        return car_of_template(context.facts)
    return CarState()
