"""The silhouette modeler's place in the program: state in; solid, picture and shapes out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Shapes, Skeleton, Skin, Solid, Texture
from bozzetto.ink import Drawing, Strokes
from bozzetto.plugin import (
    Caution,
    Command,
    Context,
    Job,
    NextStep,
    PartsModeler,
    Tool,
    override,
    remembered,
)
from bozzetto.scene import Layer, Scene, Shaded
from bozzetto_silhouette.analysis.figures import FIGURES
from bozzetto_silhouette.analysis.report import cautions_of, report_of
from bozzetto_silhouette.appearance.paint_layer import lost_paint, paint_facts
from bozzetto_silhouette.appearance.part_groups import with_groups
from bozzetto_silhouette.appearance.surface_look import (
    finely_shown,
    known_texture,
    paint_edges,
    painted,
    sketched,
    texture_of,
)
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid
from bozzetto_silhouette.model.sketch_plane import sheet_under
from bozzetto_silhouette.model.state import Cut, Group, Part, SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.rigging.armature import armature_of
from bozzetto_silhouette.rigging.hand_over import handed_over
from bozzetto_silhouette.rigging.key_poses import clip_of
from bozzetto_silhouette.rigging.posing import (
    Posed,
    joints_layer,
    rig_facts,
    rig_of,
    skinned,
    skinned_draft,
)
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.draft import draft_of
from bozzetto_silhouette.solids.evaluate import evaluated
from bozzetto_silhouette.solids.placements import carried, outlined_parts, placement_of, shown_parts
from bozzetto_silhouette.tools import all_tools
from bozzetto_silhouette.tools.animate import motion_commands
from bozzetto_silhouette.tools.attachment import ATTACH, offers_to_attach
from bozzetto_silhouette.tools.brush import brush_commands
from bozzetto_silhouette.tools.draw_outline import DrawOutline
from bozzetto_silhouette.tools.hole_filling import FILL
from bozzetto_silhouette.view.handles import handles_layer
from bozzetto_silhouette.view.ink_layers import deviation_layer, ink_layers

PREVIEW_RESOLUTION = 64
"""Cells along the longest side for an answer within a blink."""


@dataclass(frozen=True, eq=False)
class SilhouetteResult:
    """The shape of the whole tree, and the solid of every part in its own object frame.

    Attributes
    ----------
    body : Body or None
        None where nothing is left.
    mesh, shown : Mesh or None
        The same for files, and for the screen (`Painted`), as its joints were turned.
    skin : Skin or None
        The joints and weights of `mesh` where it is posed; files get a skin in any case.
    texture : Texture or None
        Of `shown`, where a picture lies on it; files get one for strokes of paint, too.
    final : bool
        Whether this is more than a preview.
    solids : dict of str to SilhouetteSolid
        By the id of the part; without those that go straight through.
    """

    body: Body | None
    mesh: Mesh | None
    shown: Mesh | None
    skin: Skin | None
    texture: Texture | None
    final: bool
    solids: Mapping[str, SilhouetteSolid]


class Silhouette(PartsModeler[SilhouetteState, SilhouetteResult]):
    """Closed outlines become convolution solids (Kukelova & Durikovic 2007)."""

    id = "bozzetto.silhouette"
    state_type = SilhouetteState
    state_version = 4
    part_types = (Part, Cut, Group)
    first_parameters = ("inflation", "operation", "blend")
    figures = FIGURES

    @override
    def tools(self) -> Sequence[Tool[SilhouetteState]]:
        """Return the tools, most used first."""
        return all_tools()

    @override
    def commands(self) -> Sequence[Command]:
        """Return what is done to the chosen part, and to the motion, most used first."""
        return (ATTACH, FILL, *brush_commands(), *motion_commands())

    @override
    def next_step(self, state: SilhouetteState, tool: Tool[SilhouetteState]) -> NextStep:
        """Return what the tool says; where there is no part, that one is to be drawn first."""
        if not state.nodes and tool.id != DrawOutline.id:
            return NextStep(DrawOutline.hint, tool=DrawOutline.id)
        return tool.next_step(state)

    @override
    def ink(self, state: SilhouetteState) -> Strokes:
        """Return the outlines of the shown parts where they stand; not what was rubbed or cut."""
        return Strokes(
            stroke.moved(carried(state, part))
            for part in outlined_parts(state)
            for stroke in part.strokes
        )

    @override
    def read_drawing(self, drawing: Drawing, context: Context, job: Job) -> SilhouetteState:
        """Read all strokes of a drawing as one part; nested outlines are holes.

        Raises
        ------
        UserError
            If the drawing is empty or does not close.
        """
        if not len(drawing.strokes):
            raise UserError("The drawing has no strokes. Draw a closed outline first.")
        part = Part(
            id="n1",
            name="Part 1",
            strokes=drawing.strokes,
            sheet=sheet_under(drawing.strokes[0], context),
        )
        outline_of(part)
        return SilhouetteState().with_node(part)

    @override
    def solve(self, state: SilhouetteState, job: Job) -> SilhouetteResult:
        """Make one watertight solid; what did not change is remembered.

        A preview of several parts is a draft of them, not united, unless gestures land on it. While
        joints turn and parts stay as they are it is what was made of these.
        """
        resolution, final = state.resolution, job.quality == "final"
        if not final:
            resolution = min(resolution, PREVIEW_RESOLUTION)
            if not job.drawn_on:
                return _drafted(state, resolution, job)
        body, solids = evaluated(state, resolution, job.checkpoint)
        if body is None:
            return SilhouetteResult(None, None, None, None, None, final, solids)
        if final:
            _united.put(_United(body, solids), state)
        return SilhouetteResult(body, *_as_posed(state, body, job, fine=final), final, solids)

    @override
    def scene(self, state: SilhouetteState, result: SilhouetteResult | None) -> Scene:
        """Return the shape in clay and, faintly, the ink that made it.

        Ink belongs to the shape at rest: while that is posed its joints are shown instead, and
        where it has a motion nothing but the shape.
        """
        layers: list[Layer | None] = []
        if result is not None and result.shown is not None:
            layers.append(Layer("shape", (Shaded(result.shown, texture=result.texture),)))
        if state.posing and result is not None:
            layers.append(joints_layer(state))
        elif not (state.keys and state.turns):
            layers += ink_layers(state) if state.nodes else ()
            if result is not None and result.final:
                layers.append(_deviation(state, result))
            layers.append(None if state.posing else handles_layer(state))
        return Scene(tuple(layer for layer in layers if layer is not None))

    @override
    def shapes(self, state: SilhouetteState, result: SilhouetteResult) -> Shapes:
        """Return one solid, triangles grouped by part, and the skeleton of each part."""
        if result.mesh is None or result.shown is None or result.body is None:
            return Shapes()
        skin = result.skin
        if skin is None and (result.final or result.body.solid is not None):
            skin = skinned(state, result.body, painted(state, result.body)).skin
        armature = armature_of(state)
        if skin is not None and armature is not None:
            clip = clip_of(armature, state)
            clips = () if clip is None else (clip,)
            skin = handed_over(armature, replace(skin, clips=clips))
        texture = texture_of(state, result.body)
        solid = Solid(result.mesh, texture=texture, skin=skin)
        skeletons = []
        for part in state.parts:
            if part.id in result.solids:
                skeleton = result.solids[part.id].skeleton
                nodes, bones = skeleton.nodes, skeleton.edges.astype(np.int32)
                flat = np.column_stack([nodes[:, :2], np.zeros(len(nodes))])
                stands = placement_of(state, part)
                radii = nodes[:, 2] * stands.scale
                skeletons.append(Skeleton(stands.points(flat), radii, bones))
        return Shapes(
            solids=(with_groups(state, result.body, solid),),
            skeletons=tuple(skeletons),
        )

    @override
    def report(
        self, state: SilhouetteState, result: SilhouetteResult, job: Job
    ) -> Mapping[str, Any]:
        """Report how close every part is to its outline, and whether the whole can be printed."""
        figures = report_of(
            state, result.body, result.solids, job, lambda: offers_to_attach(state, job)
        )
        rig = None if result.body is None else rig_of(state)
        paint = None if result.body is None else paint_facts(state, result.body)
        if paint is not None:
            figures = {**figures, "paint": paint}
        return figures if rig is None else {**figures, "rig": rig_facts(rig)}

    @override
    def cautions(self, state: SilhouetteState, result: SilhouetteResult) -> tuple[Caution, ...]:
        """Return cautions about strokes that are not in the shape or on it, and a coarser shape."""
        lost = () if result.body is None else lost_paint(state, result.body)
        return (*cautions_of(state, result.body), *lost)

    # -- parts --

    @override
    def released(self, part: Part | Group, group: Group) -> Part | Group:
        """Return a node that stays where its group had moved it."""
        return replace(part, pose=group.pose.after(part.pose))

    # -- documents --

    @override
    def upgrade(self, state: dict[str, Any], version: int) -> dict[str, Any]:
        """Bring an older state up to date.

        Version 2 kept whether handles were shown. Version 1 had a flat list of parts that
        shared their parameters and never met.
        """
        if version >= 2:  # version 3 had no strokes of paint
            return {key: value for key, value in state.items() if key != "held"}
        shared = {key: state[key] for key in ("inflation", "softness") if key in state}
        nodes = [
            {"$type": "Part", "id": f"n{k}", "name": f"Part {k}", "blend": 0.0, **shared, **part}
            for k, part in enumerate(state.get("parts", ()), 1)
        ]
        kept = {key: state[key] for key in ("resolution",) if key in state}
        return {"nodes": nodes, "selected": "n1" if nodes else "", **kept}


class _United(NamedTuple):
    """The shape of all nodes of a state, and the solids of its parts."""

    body: Body
    solids: Mapping[str, SilhouetteSolid]


@remembered(limit=4, key=lambda state: (state.unpainted, state.resolution))
def _united(state: SilhouetteState) -> _United | None:
    """Return what was made of some nodes finally; only what was put here is known."""
    return None


def _drafted(state: SilhouetteState, resolution: int, job: Job) -> SilhouetteResult:
    """Return what is shown while a value is dragged, a joint is, or a motion plays."""
    posed = state.posing or bool(state.turns)
    has_paint = any(part.paint_strokes for part in state.parts)
    known = _united.known(state) if posed or has_paint else None
    if known is not None:
        return SilhouetteResult(
            known.body, *_as_posed(state, known.body, job, fine=not posed), False, known.solids
        )  # fmt: skip
    draft, solids = draft_of(state, resolution, job.checkpoint)
    if draft is None:
        return SilhouetteResult(None, None, None, None, None, False, solids)
    if draft.body.solid is not None:  # one part by itself
        moved = _as_posed(state, draft.body, job, fine=False)
    else:
        mesh = sketched(state, draft, job.checkpoint)
        if posed:
            mesh = skinned_draft(state, draft, mesh, job.checkpoint)
        moved = (*Posed(mesh, mesh, None), None)
    return SilhouetteResult(draft.body, *moved, False, solids)


def _as_posed(
    state: SilhouetteState, body: Body, job: Job, *, fine: bool
) -> tuple[Mesh, Mesh, Skin | None, Texture | None]:
    """Return a body's meshes with their colours, as its joints were turned.

    With `fine` what is shown has a texture if a picture lies on it, and else finer triangles where
    strokes of paint end. A texture that is known is shown in any case.
    """
    look = painted(state, body, job.checkpoint)
    if state.posing or state.turns:
        posed = skinned(state, body, look, job.checkpoint)
    else:
        posed = Posed(*look, None)
    if state.picture is not None:
        texture = texture_of(state, body, job.checkpoint) if fine else known_texture(state, body)
        if texture is None:
            return (*posed, None)
        bare = replace(posed.shown, colors=None, cover=None)
        return posed.mesh, bare, posed.skin, texture
    edges = paint_edges(state, body, job.checkpoint) if fine else None
    if edges is None:
        return (*posed, None)
    return posed.mesh, finely_shown(state, body, edges, posed.shown), posed.skin, None


def _deviation(state: SilhouetteState, result: SilhouetteResult) -> Layer | None:
    """Show where the chosen part's silhouette is not the one that was drawn."""
    chosen = [part for part in shown_parts(state) if part.id == state.selected]
    if not chosen or chosen[0].id not in result.solids:
        return None
    return deviation_layer(state, chosen[0], result.solids[chosen[0].id])
