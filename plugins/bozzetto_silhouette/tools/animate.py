"""Animate: key poses become a motion, which plays in the window and goes into GLB files."""

from __future__ import annotations

from collections.abc import Sequence

from bozzetto.plugin import Command, Context, Drag, NextStep, override
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.rigging.gait import swaying, walking
from bozzetto_silhouette.rigging.key_poses import (
    at_key,
    at_rest,
    key_at,
    moved_on,
    with_changed_key,
    with_key,
    with_moved_key,
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
            "Add the pose to the motion, after the key pose that is shown.",
            lambda state, context: with_key(state),
            enabled=_has_parts,
        ),
        Command(
            "change-pose",
            "Change the key pose",
            "Put this pose in the place of the key pose that is shown.",
            lambda state, context: with_changed_key(state),
            enabled=_has_motion,
        ),
        Command(
            "next-pose",
            "Go to the next key pose",
            "Show the next pose of the motion, to look at it or to go on from it.",
            lambda state, context: at_key(state, key_at(state) + 1),
            enabled=_has_motion,
        ),
        Command(
            "later-pose",
            "Key pose later",
            "Exchange the key pose that is shown and the one after it.",
            lambda state, context: with_moved_key(state, 1),
            enabled=_has_motion,
        ),
        Command(
            "forget-pose",
            "Forget the key pose",
            "Take the key pose that is shown out of the motion.",
            lambda state, context: without_key(state),
            enabled=_has_motion,
        ),
        Command(
            "rest",
            "Back to rest",
            "Put all joints back to where they were drawn, and forget the motion.",
            lambda state, context: at_rest(state),
            enabled=_is_posed,
        ),
    )


def _has_parts(state: SilhouetteState) -> bool:
    return bool(state.nodes)


def _has_motion(state: SilhouetteState) -> bool:
    return bool(state.keys)


def _is_posed(state: SilhouetteState) -> bool:
    return bool(state.keys or state.turns)
