"""The program, as far as a plugin's own panel sees it."""

from bozzetto.errors import UserError
from bozzetto.plugin import Context


class StandInHost:
    """A `bozzetto.plugin.PanelHost` that keeps a state and writes down what it is asked for.

    Parameters
    ----------
    state : State
        The selected object's state.
    next_step : callable, optional
        What `next_step` says of a state.
    templates : sequence of TemplateFile
        Those of plugins.

    Attributes
    ----------
    say_next : callable
        The same; another one may be put there.
    """

    def __init__(self, state, next_step=None, templates=()):
        self.state = state
        self.templates = templates
        self.labels, self.going, self.problems = [], [], []
        self.say_next = next_step
        self._callbacks = []

    @property
    def next_step(self):
        return self.say_next(self.state)

    def change(self, state, label, *, going=False):
        self.labels.append(label)
        self.going.append(going)
        self.put(state)

    def run(self, command):
        try:
            state = command.run(self.state, Context())
        except UserError as problem:
            self.complain(problem)
        else:
            self.change(state, command.title)

    def put(self, state):
        """Put another state there, as an undo does."""
        self.state = state
        for callback in self._callbacks:
            callback()

    def complain(self, problem):
        self.problems.append(problem.message)

    def on_change(self, callback):
        self._callbacks.append(callback)
