"""Forces in bars that were drawn: the method of joints, springs, the ground."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.plugin import Job
from bozzetto_polyhedron.mechanism.analysis import balance_of
from bozzetto_polyhedron.mechanism.stepper import Stepper
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solve.forces import forces_of
from bozzetto_polyhedron.solve.moving import moving
from tests.plugins.polyhedron.linkages import linkage
from tests.plugins.polyhedron.mechanisms import box_on_ground

MODELER = PolyhedronModeler()
BRACKET = {"a": (300, 400), "b": (300, 600), "c": (600, 400)}


def test_a_bracket_pulls_its_tie_and_presses_its_strut():
    """Weights of the bars go half to their ends: the tip carries half of both."""
    state = replace(linkage(BRACKET, ("ac", "bc"), held="ab"), gravity=True, forces=True)
    made = moving(state)
    found = forces_of(state, made)
    masses = made.machine.assembly.masses
    tip = 0.5 * masses.sum() * 9.81
    angle = np.arctan2(200.0, 300.0)
    tie, strut = found.newtons
    assert found.balanced
    assert tie == pytest.approx(tip / np.tan(angle), rel=1e-4)
    assert strut == pytest.approx(-tip / np.sin(angle), rel=1e-4)
    scene = MODELER.scene(state, MODELER.solve(state, Job()))
    (layer,) = (layer for layer in scene.layers if layer.name == "forces")
    assert len(layer.items) == 4


def test_forces_that_do_not_hold_are_said():
    state = replace(linkage(BRACKET, ("ac", "bc"), held="a"), gravity=True, forces=True)
    assert not forces_of(state, moving(state)).balanced
    said = [each.message for each in MODELER.cautions(state, MODELER.solve(state, Job()))]
    assert any("would not stay" in text for text in said)
    weightless = replace(state, gravity=False)
    said = [each.message for each in MODELER.cautions(weightless, MODELER.solve(state, Job()))]
    assert any("Nothing is loaded" in text for text in said)


def test_the_ground_carries_what_stands_on_it():
    assembly, motion = box_on_ground(height=0.02)
    loads = Stepper(assembly).loads(motion)
    assert loads[0] == pytest.approx(np.zeros(6), abs=1e-5)
    fallen = Stepper(assembly).loads(replace(motion, places=np.add(motion.places, (0.0, 0.0, 0.1))))
    assert fallen[0, 2] == pytest.approx(-0.2 * 9.81)


def test_a_load_that_nothing_carries_is_left():
    assembly, motion = box_on_ground(height=1.0)
    left = balance_of(assembly, motion, np.array([[0, 0, -3.0, 0, 0, 0]])).left
    assert left == pytest.approx(1.0)
