"""A box drawn and turned in a shell, and what is made of it."""

from __future__ import annotations

import numpy as np

from bozzetto.plugin import Job
from bozzetto.testing import Shell
from bozzetto.view import turn
from bozzetto_polyhedron.drawing_on.changed import Changed
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS

MODELER = PolyhedronModeler()


def with_box(shell: Shell, seed: int, turned: tuple[float, float] = (15.0, -6.0)) -> Shell:
    """Draw a box, turn it into a solid, and look at it from elsewhere."""
    solid = OBJECTS["box"]
    shell.open("bozzetto.polyhedron")
    shell.camera = VIEW
    shell.draw(*strokes_of(fitted(solid), solid.edges, jitter=1.0, seed=seed))
    shell.run("next-answer")
    shell.camera = turn(VIEW, *turned)
    return shell


def changed(shell: Shell, body: str = "n1") -> Changed:
    """Return a body with all that was drawn on it."""
    made = MODELER.solve(shell.state, Job()).bodies[body].changed
    assert made is not None
    return made


def body(shell: Shell, body: str = "n1") -> PlanarBody:
    return changed(shell, body).body


def facing(shell: Shell) -> int:
    """Return the face that looks at the eye most."""
    return int(np.argmin(body(shell).normals @ shell.camera.axes[2]))
