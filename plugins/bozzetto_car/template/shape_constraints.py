"""Inequalities that keep a car a car, whatever a sketch asks for.

Kara & Shimada (2008) subject the deformation of the template to soundness constraints: nothing
may pass through anything else, and each of them can be abandoned. Here each is a row that is
not below 0 in a sound car. There are two kinds, both over the variables of a symmetric car
(`Template.basis`), so that a solver needs no others:

* the **rules** of the template's file: linear, ``matrix @ variables + constants``;
* **folds**: no corner of a patch turns over. With the neighbours A and B of a corner P and the
  normal n of the patch in the template, n · (A - P) × (B - P) stays above zero for all four
  corners. That is quadratic in the variables. A quadrangle of which all corners turn
  the same way is convex seen along n, so the patch lies open over it.

All slacks are in mm: the area at a corner is divided by the side of a square as large as the
patch, which gives the width of the corner, mostly some hundred mm.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Index
from bozzetto_car.template.model import Template

FOLD_MARGIN: Final = 10.0
"""Least width of a corner, mm. At zero the surface would have no normal there."""


def fold_name(patch: str) -> str:
    """Return the name of the constraint that keeps a patch and its mirror image open."""
    half = patch[:-2] if patch.endswith((".R", ".L")) else patch
    return f"The patch {half} does not fold"


def soundness_names(template: Template) -> tuple[str, ...]:
    """Return the names of all constraints of a template, each once, rules first."""
    folds = (fold_name(patch.name) for patch in template.patches)
    return tuple(dict.fromkeys((*(rule.name for rule in template.rules), *folds)))


@dataclass(frozen=True, eq=False)
class Soundness:
    """The inequalities of a template that are switched on.

    Attributes
    ----------
    names : tuple of str, length m
        Name of each row. The four corners of a patch share one name.
    matrix : (l, q) float
    constants : (l,) float, mm
        The linear rows; they come first.
    basis : (3 n, q) float
        `Template.basis`.
    corners : (m - l, 3) int
        The node of each corner, and the next and the previous node around the patch.
    normals : (m - l, 3) float
        Normal of the patch in the template, divided by its size, 1/mm.
    """

    names: tuple[str, ...]
    matrix: Array
    constants: Array
    basis: Array
    corners: Index
    normals: Array

    @classmethod
    def of(cls, template: Template, without: Collection[str] = ()) -> Soundness:
        """Return the inequalities of a template.

        Parameters
        ----------
        template : Template
            The template.
        without : collection of str
            Names that are switched off; names that the template does not know are ignored.
        """
        rules = [rule for rule in template.rules if rule.name not in without]
        rows = np.zeros((len(rules), *template.positions.shape))
        for row, rule in zip(rows, rules, strict=True):
            for node, axis, factor in rule.terms:
                row[node, axis] += factor
        names = [rule.name for rule in rules]
        corners, normals = [], []
        # The left half is the mirror image: its rows would be the same.
        right = [patch for patch in template.patches if not patch.name.endswith(".L")]
        for patch in right:
            name = fold_name(patch.name)
            if name in without:
                continue
            places = template.positions[list(patch.nodes)]
            across = np.cross(places[2] - places[0], places[3] - places[1])
            doubled = np.linalg.norm(across)
            normal = across / doubled / np.sqrt(0.5 * doubled) if doubled else across
            for number in range(4):
                corners.append([patch.nodes[(number + step) % 4] for step in (0, 1, 3)])
                normals.append(normal)
                names.append(name)
        return cls(
            tuple(names),
            rows.reshape(len(rules), template.positions.size) @ template.basis,
            np.array([rule.constant for rule in rules]),
            template.basis,
            np.array(corners, np.intp).reshape(-1, 3),
            np.array(normals).reshape(-1, 3),
        )

    def slacks(self, variables: ArrayLike) -> Array:
        """Return the distance of each row from violation, (m,) mm; negative where it is violated.

        Parameters
        ----------
        variables : (q,) array_like
            Variables of a car; `Template.reduced` computes them from its nodes.
        """
        values = np.asarray(variables, float)
        ahead, back = self._arms(values)
        widths = np.einsum("ij,ij->i", self.normals, np.cross(ahead, back))
        return np.concatenate((self.matrix @ values + self.constants, widths - FOLD_MARGIN))

    def jacobian(self, variables: ArrayLike) -> Array:
        """Return the derivatives of the slacks by the variables, (m, q)."""
        values = np.asarray(variables, float)
        ahead, back = self._arms(values)
        by_next, by_last = np.cross(back, self.normals), np.cross(self.normals, ahead)
        count = len(self.corners)
        rows = np.zeros((count, len(self.basis) // 3, 3))
        each = np.arange(count)
        for column, part in enumerate((-by_next - by_last, by_next, by_last)):
            rows[each, self.corners[:, column]] = part
        return np.vstack((self.matrix, rows.reshape(count, len(self.basis)) @ self.basis))

    def least(self, variables: ArrayLike) -> dict[str, float]:
        """Return the least slack of each constraint by its name, mm, for reports."""
        found: dict[str, float] = {}
        for name, slack in zip(self.names, self.slacks(variables).tolist(), strict=True):
            found[name] = min(slack, found.get(name, np.inf))
        return found

    def _arms(self, variables: Array) -> tuple[Array, Array]:
        """Return the vectors from each corner to its next and previous nodes, (m - l, 3) mm."""
        at, ahead, back = (self.basis @ variables).reshape(-1, 3)[self.corners.T]
        return ahead - at, back - at
