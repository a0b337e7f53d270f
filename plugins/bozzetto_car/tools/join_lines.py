"""Join lines: make them sharp or smooth where they pass a node, or even in curvature."""

from __future__ import annotations

from dataclasses import replace

from bozzetto.errors import UserError
from bozzetto.plugin import Context, NextStep, Tap, Tool, override
from bozzetto_car.body.build import body_in_work
from bozzetto_car.body.chain_smoothing import own_edges, smooth_parts
from bozzetto_car.solver.pipeline import template_of
from bozzetto_car.state import CarState
from bozzetto_car.template.line_joints import next_joints
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import edge_called
from bozzetto_car.view.joint_items import JOIN_TOOL
from bozzetto_car.view.picking import touched


class JoinLines(Tool[CarState]):
    """The tool for joints of lines: a touch on a node makes its line sharp or smooth.

    A touch on an edge keeps the curvature of its whole smooth line even (G2), or no more.
    """

    id = JOIN_TOOL
    title = "Join lines"
    icon = "icons/join.svg"
    hint = "Touch a node: its line gets sharp or smooth. Touch an edge: its line bends evenly."
    gesture = "drag"

    @override
    def next_step(self, state: CarState) -> NextStep:
        """Return what a touch does."""
        return NextStep(self.hint)

    @override
    def tap(self, state: CarState, tap: Tap, context: Context) -> CarState:
        """Change how lines join at the node, or along the edge, that is touched.

        Raises
        ------
        UserError
            If there is no body yet, nothing is touched, or no line runs there.
        """
        body = body_in_work(state)
        name = touched(body.network, (tap.x, tap.y), tap.camera)
        if not name:
            raise UserError("Nothing is touched. Touch a node in which lines meet, or an edge.")
        template = template_of(state)
        if name in template.node:
            return replace(state, joints=next_joints(template, state.joints, template.node[name]))
        return replace(state, flowing=_with_line(state, body.template, name))


def _with_line(state: CarState, template: Template, name: str) -> tuple[str, ...]:
    """Return the edges whose lines bend evenly after a touch on one edge."""
    (own,) = own_edges(template, (edge_called(template, name),))
    line: set[int] = set()
    for chain, first, last in smooth_parts(template):
        part = own_edges(template, chain.edges[first:last])
        line |= part if own in part else set()
    if not line:
        raise UserError(
            f"The edge {name} runs on smoothly at neither end. Touch a node in which it meets "
            "another edge, then touch it again."
        )
    names = {template.edge_names[one] for one in line}
    others = tuple(one for one in state.flowing if one not in names)
    return others if len(others) < len(state.flowing) else (*others, template.edge_names[own])
