"""Animate: key poses become a motion, which plays in the window and goes into GLB files."""

from __future__ import annotations

from collections.abc import Sequence

from bozzetto.plugin import Command, Context, Drag, NextStep, override
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.rigging.gait import swaying, walking
from bozzetto_silhouette.rigging.key_poses import (
    at_next_key,
    at_rest,
    moved_on,
    with_key,
    without_key,
)
from bozzetto_silhouette.tools.erasing_tool import ErasingTool

PLAY = "Press P to play the motion and to stop it; File › Film of what moves makes a file of it."


class Animate(ErasingTool):
    """Plays the motion; joints are dragged as with any tool."""

    id = "animate"
    title = "Animate"
    icon = "icons/animate.svg"
    hint = (
        "Choose Walk or Sway among the commands; or switch Pose on, drag joints, and keep each "
        "pose as a key."
    )
    gesture = "tap"
    plays = True

    @override
    def step(
        self, state: SilhouetteState, held: Drag | None, seconds: float, context: Context
    ) -> SilhouetteState:
        """Return the state a moment later in its motion."""
        return moved_on(state, seconds)

    @override
    def next_step(self, state: SilhouetteState) -> NextStep:
        """Return how to play a motion, else how to make one."""
        return NextStep(PLAY) if state.keys else super().next_step(state)


def motion_commands() -> Sequence[Command]:
    """Return what can be done to the motion, most used first."""
    return (
        Command(
            "walk",
            "Walk",
            "Let what has legs walk on the spot; its motion goes into GLB files.",
            walking,
            enabled=_has_parts,
        ),
        Command(
            "sway",
            "Sway",
            "Let the shape sway gently where it stands; its motion goes into GLB files.",
            swaying,
            enabled=_has_parts,
        ),
        Command(
            "keep-pose",
            "Keep this pose as a key",
            "Add the pose to the end of the motion, which goes through all of them in turn.",
            with_key,
            enabled=_has_parts,
        ),
        Command(
            "next-pose",
            "Go to the next key pose",
            "Show the next pose of the motion, to look at it or to go on from it.",
            at_next_key,
            enabled=_has_motion,
        ),
        Command(
            "forget-pose",
            "Forget the last key pose",
            "Take the last pose out of the motion.",
            without_key,
            enabled=_has_motion,
        ),
        Command(
            "rest",
            "Back to rest",
            "Put all joints back to where they were drawn, and forget the motion.",
            at_rest,
            enabled=_is_posed,
        ),
    )


def _has_parts(state: SilhouetteState) -> bool:
    return bool(state.nodes)


def _has_motion(state: SilhouetteState) -> bool:
    return bool(state.keys)


def _is_posed(state: SilhouetteState) -> bool:
    return bool(state.keys or state.turns)
