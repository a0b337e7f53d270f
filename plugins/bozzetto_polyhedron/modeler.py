"""The polyhedron modeler: a line drawing in; exact solids out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from bozzetto.errors import UserError
from bozzetto.geometry import Curve, Shapes
from bozzetto.ink import Drawing, Strokes
from bozzetto.plugin import (
    Caution,
    Command,
    Context,
    Job,
    NextStep,
    PartsModeler,
    Tool,
    ViewAdvice,
    override,
)
from bozzetto.scene import Scene
from bozzetto.view import Camera
from bozzetto_polyhedron.commands.listing import all_commands
from bozzetto_polyhedron.hand_over import shapes_of, traced_curves
from bozzetto_polyhedron.model.assign_stroke import drawings_in, new_body
from bozzetto_polyhedron.model.changes import Added, Chamfer, Copies, Fillet, Join, Mirror, Push
from bozzetto_polyhedron.model.earlier_states import with_spots
from bozzetto_polyhedron.model.fittings import Coil, Crank, Hinge, Link, Pin, Slider, Trace
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.round_sizes import RimSize, RoundSize
from bozzetto_polyhedron.model.state import (
    Body,
    BodyGroup,
    Choice,
    Measure,
    Opening,
    PolyhedronState,
    Slant,
)
from bozzetto_polyhedron.report import FIGURES, cautions_of, report_of
from bozzetto_polyhedron.solve.followed import Sources, bodies_of
from bozzetto_polyhedron.solve.pipeline import Solved, solved
from bozzetto_polyhedron.solve.recording import at_time, recorded_times, recorded_until
from bozzetto_polyhedron.tools.draw_lines import DrawLines
from bozzetto_polyhedron.tools.listing import all_tools
from bozzetto_polyhedron.tools.pieces import FreePiece
from bozzetto_polyhedron.tools.turn_solid import DRAW_FIRST
from bozzetto_polyhedron.view.drawn_views import advice_before, advice_on_drawings
from bozzetto_polyhedron.view.scene import scene_of

BEGINNING: Final = (DrawLines.id, FreePiece.id)
"""Tools that need no drawing: by the second one pieces of other objects come to a mechanism."""


@dataclass(frozen=True, eq=False)
class PolyhedronResult:
    """Results of every drawing, by its id, the drawings, and the shapes of other objects."""

    bodies: Mapping[str, Solved]
    drawings: tuple[Body, ...]
    sources: Sources


class PolyhedronModeler(PartsModeler[PolyhedronState, PolyhedronResult]):
    """A drawing of all edges becomes a solid (Masry, Kang, Susilo & Lipson 2004)."""

    id = "bozzetto.polyhedron"
    state_type = PolyhedronState
    state_version = 2
    part_types = (
        *(Body, Measure, RoundSize, RimSize, Slant, Opening),
        *(Push, Added, Chamfer, Fillet, Mirror, Copies, Join),
        *(Link, Coil, Slider, Pin, Hinge, Crank, Trace, Followed, BodyGroup),
    )
    first_parameters = ("answer", "length", "depth")
    figures = FIGURES

    @override
    def tools(self) -> Sequence[Tool[PolyhedronState]]:
        """Return the tools of the pen, most used first."""
        return all_tools()

    @override
    def commands(self) -> Sequence[Command]:
        """Return the commands on the chosen body."""
        return all_commands()

    @override
    def next_step(self, state: PolyhedronState, tool: Tool[PolyhedronState]) -> NextStep:
        """Return what the tool says; of an empty sheet, that edges are to be drawn first."""
        if not state.nodes and tool.id not in BEGINNING:
            return DRAW_FIRST
        return tool.next_step(state)

    @override
    def upgrade(self, state: dict[str, Any], version: int) -> dict[str, Any]:
        """Read version 1 as well: held corners were places of the drawing, held at rest."""
        return with_spots(state) if version < 2 else state

    @override
    def view_advice(self, state: PolyhedronState, camera: Camera, job: Job) -> ViewAdvice | None:
        """Return the view without perspective until a drawing is turned."""
        return advice_before(state.of_kind(Body), camera)

    @override
    def advice_on_result(
        self,
        state: PolyhedronState,
        result: PolyhedronResult,
        camera: Camera,
        seen: Sequence[PolyhedronResult],
    ) -> ViewAdvice | None:
        """Return the view that shows drawings as another one showed them before they were moved."""
        return advice_on_drawings(result.drawings, camera, [earlier.drawings for earlier in seen])

    @override
    def read_drawing(self, drawing: Drawing, context: Context, job: Job) -> PolyhedronState:
        """Return the bodies of a whole drawing, each turned into a solid at once.

        Raises
        ------
        UserError
            If it is empty.
        """
        if not len(drawing.strokes):
            raise UserError("The drawing has no strokes. Draw the edges of a solid first.")
        state = self.create(context)
        for strokes in drawings_in(tuple(drawing.strokes)):
            job.checkpoint(0.5, drawing.name)
            state = new_body(state, strokes, Choice())
        first = state.nodes[0]
        return state.with_node(first)

    @override
    def follow(self, sources: Mapping[str, Shapes]) -> PolyhedronState:
        """Return a mechanism whose bodies are the parts of other objects, and go with them."""
        return bodies_of(sources)

    @override
    def sources(self, state: PolyhedronState) -> Sequence[str]:
        """Return the objects whose parts are bodies here."""
        return tuple(dict.fromkeys(part.source for part in state.of_kind(Followed)))

    @override
    def with_sources(self, state: PolyhedronState, sources: Sequence[str]) -> PolyhedronState:
        """Return the same mechanism of the parts of other objects."""
        others = dict(zip(self.sources(state), sources, strict=True))
        nodes = tuple(
            replace(node, source=others[node.source]) if isinstance(node, Followed) else node
            for node in state.nodes
        )
        return replace(state, nodes=nodes)

    @override
    def ink(self, state: PolyhedronState) -> Strokes:
        """Return the drawings of all bodies that are shown, where they stand now."""
        return Strokes(
            stroke if body.placement.is_identity else stroke.moved(body.placement)
            for body in state.shown(Body)
            for stroke in body.strokes
        )

    @override
    def solve(self, state: PolyhedronState, job: Job) -> PolyhedronResult:
        """Solve every body; what did not change is remembered."""
        bodies = [body for body in state.of_kind(Body) if len(body.strokes)]
        results: dict[str, Solved] = {}
        for number, body in enumerate(bodies):

            def checkpoint(
                fraction: float = 0.0, doing: str = "", number: int = number, name: str = body.name
            ) -> None:
                job.checkpoint((number + fraction) / len(bodies), f"{name}: {doing}")

            checkpoint(0.0, "Lines")
            results[body.id] = solved(body, state, job.quality, checkpoint)
        return PolyhedronResult(results, tuple(state.shown(Body)), job.sources)

    @override
    def scene(self, state: PolyhedronState, result: PolyhedronResult | None) -> Scene:
        """Return ink, lines, findings and solids."""
        if result is None:
            return scene_of(state, {})
        return scene_of(state, result.bodies, result.sources)

    @override
    def shapes(self, state: PolyhedronState, result: PolyhedronResult) -> Shapes:
        """Return every body that is shown: its exact planes, or its triangles where it is sheet."""
        return shapes_of(state, result.bodies, result.sources)

    @override
    def recorded(self, state: PolyhedronState) -> Sequence[float]:
        """Return when poses were recorded since everything was at rest."""
        return recorded_times(state)

    @override
    def replayed(self, state: PolyhedronState, seconds: float) -> PolyhedronState:
        """Return the state in the pose of a time, with the traces that were drawn until then."""
        return recorded_until(at_time(state, seconds), seconds)

    @override
    def curves(self, state: PolyhedronState, result: PolyhedronResult) -> Sequence[Curve]:
        """Return the paths that corners were traced along."""
        return traced_curves(state, result.sources)

    @override
    def report(
        self, state: PolyhedronState, result: PolyhedronResult, job: Job
    ) -> Mapping[str, Any]:
        """Return corners, vertices, faces, ranked answers and health."""
        return report_of(state, result.bodies, result.sources, job)

    @override
    def cautions(self, state: PolyhedronState, result: PolyhedronResult) -> tuple[Caution, ...]:
        """Return what of the drawings looks wrong or could mean another solid."""
        return cautions_of(state, result.bodies, result.sources)
