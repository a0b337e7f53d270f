"""The motion panel: the key poses of a shape as figures, and what can be done to them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

from PySide6.QtCore import QSize, QTimer
from PySide6.QtWidgets import QGridLayout, QLabel, QPushButton, QWidget

from bozzetto.errors import UserError
from bozzetto.plugin import Context, PanelHost, override
from bozzetto_app.toolkit import PanelScroll, PanelWorker
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.panel.film_strip import FilmStrip, Strip
from bozzetto_silhouette.rigging.armature import armature_of
from bozzetto_silhouette.rigging.gait import swaying, walking
from bozzetto_silhouette.rigging.key_poses import (
    at_key,
    at_time,
    figures_of,
    with_changed_key,
    with_key,
    with_moved_key,
    without_key,
)

PATIENCE: Final = 120
"""Time from a change of keys to their new figures, ms."""

NOTHING: Final = "Draw a shape with limbs: it can be posed, and moved."

NO_MOTION: Final = (
    "No motion yet. Take a walk or a sway; or switch Pose on, drag joints, and keep each pose."
)

NO_JOINTS: Final = "This shape has no joints. Draw a longer shape or a limb."

Change = Callable[[SilhouetteState], SilhouetteState]

ROWS: Final[tuple[tuple[str, str, str, Change], ...]] = (
    ("Walk", "Walk", "Let what has legs walk on the spot", partial(walking, context=Context())),
    ("Sway", "Sway", "Let the shape sway where it stands", partial(swaying, context=Context())),
    ("Keep pose", "Keep a key pose", "Add this pose after the one that is shown", with_key),
    ("Change", "Change a key pose", "Put this pose in place of the one shown", with_changed_key),
    ("Earlier", "Move a key pose", "Let the pose that is shown come earlier",
     partial(with_moved_key, places=-1)),
    ("Later", "Move a key pose", "Let the pose that is shown come later",
     partial(with_moved_key, places=1)),
    ("Forget", "Forget a key pose", "Take the pose that is shown out of the motion", without_key),
)  # fmt: skip
"""Word on the button, step in the history, what it does, and how."""

COLUMNS: Final = 3
"""Of buttons."""

ALWAYS: Final = ("Walk", "Sway", "Keep pose")
"""Buttons for which no motion is needed."""


class MotionPanel(PanelScroll):
    """The panel that shows the key poses of the chosen shape.

    Parameters
    ----------
    host : PanelHost
        Access to the selected object.
    parent : QWidget
        The widget that holds the panel.
    """

    def __init__(self, host: PanelHost, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("motion")
        self.setProperty("behind", True)
        self.setWindowTitle("Motion")
        self._host = host
        self._figures = PanelWorker(self)
        self._drawn: tuple[object, object] = (None, None)
        self._posable: object = None
        self._soon = QTimer(self, singleShot=True, interval=PATIENCE)
        self._soon.timeout.connect(self._draw_figures)
        inside = QWidget()
        grid = QGridLayout(inside)
        grid.setContentsMargins(0, 0, 4, 0)
        grid.setSpacing(6)
        self.sentence = QLabel(inside)
        self.sentence.setWordWrap(True)
        self.strip = FilmStrip(inside)
        self.strip.key_chosen.connect(self._go_to_key)
        self.strip.time_dragged.connect(self._go_to_time)
        self.buttons: dict[str, QPushButton] = {}
        for number, (word, label, tip, change) in enumerate(ROWS):
            button = QPushButton(word, inside)
            button.setToolTip(tip)
            button.setAccessibleName(f"{word}: {tip}")
            button.clicked.connect(lambda _, c=change, said=label: self._press(c, said))
            grid.addWidget(button, *divmod(number, COLUMNS))
            self.buttons[word] = button
        # Below the buttons, which stay where they are: a second click is on the same one.
        below = grid.rowCount()
        grid.addWidget(self.sentence, below, 0, 1, COLUMNS)
        grid.addWidget(self.strip, below + 1, 0, 1, COLUMNS)
        grid.setRowStretch(below + 2, 1)
        self.setWidget(inside)
        host.on_change(self._refresh)
        self._refresh()

    @property
    def busy(self) -> bool:
        """Whether the panel does not show the newest state yet."""
        return self._soon.isActive() or self._figures.busy

    @override
    def sizeHint(self) -> QSize:
        return QSize(280, 330)

    @property
    def _state(self) -> SilhouetteState | None:
        state = self._host.state
        return state if isinstance(state, SilhouetteState) else None

    def _refresh(self) -> None:
        """Show the newest state; called at every moment of a motion that plays."""
        state = self._state
        if state is None:
            return
        count = len(state.keys)
        posable = bool(state.nodes) and self._posable is state.nodes
        for word, button in self.buttons.items():
            button.setEnabled(posable and (word in ALWAYS or count > 0))
        self.strip.setEnabled(posable)
        self.strip.show_keys(count, state.time / state.beat)
        if count:
            what = f"{count} key pose{'s' * (count > 1)}"
            seconds = count * state.beat
            self._say(f"{what}, {seconds:.4g} s. P plays the motion with the tool Animate.")
        elif posable or self._drawn[0] is not state.nodes:
            self._say(NO_MOTION if state.nodes else NOTHING)
        else:
            self._say(NO_JOINTS if state.nodes else NOTHING)
        if self._drawn[0] is not state.nodes or self._drawn[1] is not state.keys:
            self._soon.start()

    def _say(self, words: str) -> None:
        if self.sentence.text() != words:
            self.sentence.setText(words)

    def _draw_figures(self) -> None:
        """Have the joints found and the figures made: some hundredths of a second."""
        state = self._state
        if state is None:
            return

        def done(strip: Strip | None) -> None:
            self._drawn = (state.nodes, state.keys)
            self._posable = None if strip is None else state.nodes
            self.strip.show_figures(strip)
            self._refresh()

        self._figures.ask(lambda: _strip_of(state), done, lambda _: done(None))

    def _go_to_key(self, number: int) -> None:
        self._change(lambda state: at_key(state, number), "Go to a key pose")

    def _go_to_time(self, keys: float, going: bool) -> None:
        def gone(state: SilhouetteState) -> SilhouetteState:
            exact = keys.is_integer()
            return at_key(state, int(keys)) if exact else at_time(state, keys * state.beat)

        self._change(gone, "Go to a time", going=going)

    def _press(self, change: Change, label: str) -> None:
        """Do what a button says, unless that is there already: no step of the history is empty."""

        def changed(state: SilhouetteState) -> SilhouetteState:
            made = change(state)
            if made == state:
                raise UserError("That is how it is already.")
            return made

        self._change(changed, label)

    def _change(self, change: Change, label: str, *, going: bool = False) -> None:
        """Change the state; the joints are known, so that it is done at once."""
        state = self._state
        if state is None or self._posable is not state.nodes:
            return
        try:
            made = change(state)
        except UserError as problem:
            self._host.complain(problem)
        else:
            self._host.change(made, label, going=going)


def _strip_of(state: SilhouetteState) -> Strip | None:
    armature = armature_of(state)
    if armature is None or (armature.rig.parents < 0).all():
        return None
    return Strip(figures_of(state), armature.rig.parents, armature.radii)
