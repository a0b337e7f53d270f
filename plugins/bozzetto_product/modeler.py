"""The product modeler: curves on a rough shape in, surfaces between them out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Curve as ShapeCurve
from bozzetto.geometry import Shapes
from bozzetto.ink import Drawing, Stroke
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
from bozzetto.view import Camera, fit_points, standard_view
from bozzetto_product.commands.all_commands import all_commands
from bozzetto_product.commands.rough_commands import begun_on_box
from bozzetto_product.hand_over.imported import product_of_network, product_of_shapes
from bozzetto_product.hand_over.shapes import curves_of, shapes_of
from bozzetto_product.hand_over.template_facts import with_template
from bozzetto_product.model.arcs import Arc
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.details import Detail
from bozzetto_product.model.emblems import Emblem
from bozzetto_product.model.patches import CurveGroup, Patch
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.rough_shapes import DRAWN_ON, FollowedShape, RoughShape
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.pieces import without_idle_joints
from bozzetto_product.operations.rounded_corners import rounded_anew
from bozzetto_product.report import FIGURES, cautions_of, report_of
from bozzetto_product.solve.found_patches import with_patches_found, without_patches
from bozzetto_product.solve.result import ProductResult
from bozzetto_product.solve.solver import solve_product
from bozzetto_product.tools.all_tools import all_tools
from bozzetto_product.tools.draw_curve import with_drawn
from bozzetto_product.tools.emblem import with_drawing_laid
from bozzetto_product.view.scene import scene_of

ALONG_AXIS: Final = 0.99
"""Cosine to an axis from which on a view shows one side only."""

MARGIN: Final = 0.2
"""Part of the canvas around a rough shape, on each side."""


class ProductModeler(PartsModeler[ProductState, ProductResult]):
    """Curves drawn on a rough shape, and surfaces between them (Kara & Shimada, 13.2)."""

    id = "bozzetto.product"
    state_type = ProductState
    state_version = 2
    part_types = (Curve, Arc, Patch, Detail, Emblem, RoughShape, FollowedShape, CurveGroup)
    first_parameters = ("mirror",)
    figures = FIGURES

    @override
    def create(self, context: Context) -> ProductState:
        """Return a product with the rough shapes that a file gives, by default a box to draw on.

        Where something is visible that can be drawn on, a box would only be in its way.
        """
        plane = Plane(context.symmetry_point, context.symmetry_normal)
        state = with_template(ProductState(symmetry=plane), context.facts)
        if state.nodes or context.facts.get("network") is not None or context.has_surface:
            return state
        return begun_on_box(state)

    @override
    def upgrade(self, state: dict[str, Any], version: int) -> dict[str, Any]:
        """Bring an older state up to date: version 1 kept places of curves that nobody read."""
        if version >= 2:
            return state
        nodes = [
            {key: value for key, value in node.items() if key != "places"}
            if node["$type"] == "Curve"
            else node
            for node in state.get("nodes", ())
        ]
        return {**state, "nodes": nodes}

    @override
    def tools(self) -> Sequence[Tool[ProductState]]:
        """Return the tools of the pen, most used first."""
        return all_tools()

    @override
    def commands(self) -> Sequence[Command]:
        """Return the commands on curves, surfaces and rough shapes."""
        return all_commands()

    @override
    def next_step(self, state: ProductState, tool: Tool[ProductState]) -> NextStep:
        """Return what the tool says."""
        return tool.next_step(state)

    @override
    def view_advice(self, state: ProductState, camera: Camera, job: Job) -> ViewAdvice | None:
        """Return the rough shape of a product that is not begun: it is not on the sheet yet.

        It is best seen whole and from between its sides, so that curves can be drawn over several
        of them.
        """
        if not state.nodes or any(not isinstance(node, RoughShape) for node in state.nodes):
            return None
        scene = scene_of(state, None)
        if np.abs(camera.axes[2]).max() >= ALONG_AXIS:
            better = fit_points(standard_view(camera, "three-quarter"), scene.points(), MARGIN)
            return ViewAdvice("good", "Only one side is in view.", better, scene)
        seen, depths = camera.project(scene.points())
        if ((seen >= 0.0) & (seen <= camera.viewport)).all() and (depths > 0.0).all():
            return ViewAdvice("good", "", scene=scene)
        better = fit_points(camera, scene.points(), MARGIN)
        return ViewAdvice("good", "The rough shape is not wholly in view.", better, scene)

    @override
    def read_drawing(self, drawing: Drawing, context: Context, job: Job) -> ProductState:
        """Return the product of a file: a network of curves, or strokes on a rough shape.

        Strokes of one name are one curve; each other stroke is one.

        Raises
        ------
        UserError
            If the file is empty, or makes no sense.
        """
        if context.facts.get("network") is not None:
            return product_of_network(context.facts, context.drawings, job)
        if not len(drawing.strokes):
            raise UserError("The drawing has no strokes and no network. Draw a curve first.")
        state = self.create(replace(context, scene=Scene()))
        curves = _curves_in(tuple(drawing.strokes))
        for number, strokes in enumerate(curves):
            job.checkpoint(number / len(curves), drawing.name)
            own = Scene.put_off(partial(self._solved_scene, state, job))
            state = with_drawn(state, strokes, replace(context, scene=context.scene + own))
        return state

    def _solved_scene(self, state: ProductState, job: Job) -> Scene:
        return self.scene(state, self.solve(state, Job(cancelled=job.cancelled)))

    @override
    def read_shapes(self, shapes: Shapes) -> ProductState:
        """Return a product whose curves are those of other shapes, joined where they meet."""
        return product_of_shapes(shapes)

    @override
    def add_drawing(self, state: ProductState, drawing: Drawing, context: Context) -> ProductState:
        """Return the product with the closed lines of a drawing as a detail on a surface.

        Raises
        ------
        UserError
            If there is no surface to lay them on, or the drawing has no closed lines.
        """
        return with_drawing_laid(state, drawing, context)

    @override
    def follow(self, sources: Mapping[str, Shapes]) -> ProductState:
        """Return a product that is drawn on the surfaces of other models.

        Raises
        ------
        UserError
            If none of them has a surface.
        """
        state = ProductState()
        for source, shapes in sources.items():
            if shapes.solids or shapes.surfaces or shapes.breps or shapes.patchworks:
                name = state.unused_name(DRAWN_ON)
                part = FollowedShape(state.unused_id(), name, source=source)
                state = state.with_node(part)
        if not state.nodes:
            raise UserError("There is no surface to draw on. Choose an object that has one.")
        return replace(state, selected="")

    @override
    def sources(self, state: ProductState) -> Sequence[str]:
        """Return the ids of the models that are drawn on."""
        return tuple(part.source for part in state.of_kind(FollowedShape))

    @override
    def with_sources(self, state: ProductState, sources: Sequence[str]) -> ProductState:
        """Return the state drawn on other models."""
        fresh = iter(sources)
        nodes = tuple(
            replace(node, source=next(fresh)) if isinstance(node, FollowedShape) else node
            for node in state.nodes
        )
        return replace(state, nodes=nodes)

    @override
    def with_parts(
        self, state: ProductState, nodes: tuple[Any, ...], selected: str
    ) -> ProductState:
        """Return the state with other parts; loops are found again where curves went or came.

        A surface that is deleted is switched off, and not found again. A corner of which the radius
        was changed is rounded anew.

        Raises
        ------
        UserError
            If that cannot be, because curves there were changed since, or it is too large.
        """
        after = replace(state, nodes=nodes, selected=selected)
        arcs = {arc.id: arc for arc in state.of_kind(Arc)}
        for arc in after.of_kind(Arc):
            if arc.id in arcs and arc.radius != arcs[arc.id].radius:
                after = rounded_anew(after, arc, arc.radius)
        ids = {node.id for node in nodes}
        gone = [patch for patch in state.of_kind(Patch) if patch.id not in ids]
        before = {curve.id for curve in state.of_kind(Curve)}
        if before == {curve.id for curve in after.of_kind(Curve)}:
            return without_patches(after, gone) if gone else after
        return with_patches_found(without_idle_joints(after))

    @override
    def solve(self, state: ProductState, job: Job) -> ProductResult:
        """Cut curves at their joints and fill the loops; what did not change is remembered."""
        return solve_product(state, job)

    @override
    def scene(self, state: ProductState, result: ProductResult | None) -> Scene:
        """Return rough shapes, surfaces, curves, joints and open edges."""
        return scene_of(state, result)

    @override
    def shapes(self, state: ProductState, result: ProductResult) -> Shapes:
        """Return solids or open surfaces with their exact form, and the curves."""
        return shapes_of(state, result)

    @override
    def curves(self, state: ProductState, result: ProductResult) -> Sequence[ShapeCurve]:
        """Return the curves, exact, for others to snap to."""
        return curves_of(state, result)

    @override
    def report(self, state: ProductState, result: ProductResult, job: Job) -> Mapping[str, Any]:
        """Return loops, surfaces and their quality, joints, and what is open."""
        return report_of(state, result, job)

    @override
    def cautions(self, state: ProductState, result: ProductResult) -> Sequence[Caution]:
        """Return surfaces that are missing, and what is open."""
        return cautions_of(state, result)


def _curves_in(strokes: tuple[Stroke, ...]) -> list[tuple[Stroke, ...]]:
    """Return strokes by their names, those without one alone, in the order drawn."""
    groups: dict[object, list[Stroke]] = {}
    for number, stroke in enumerate(strokes):
        groups.setdefault(stroke.group or number, []).append(stroke)
    return [tuple(group) for group in groups.values()]
