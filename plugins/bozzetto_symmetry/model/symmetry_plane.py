"""The centre plane, and the frame in which it is y = 0."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.plugin import cached_property

Point = tuple[float, float, float]

Y_AXIS = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class CentrePlane:
    """The plane of symmetry.

    Parameters
    ----------
    point : (x, y, z)
        Any point on it, mm.
    normal : (x, y, z)
        Towards the side that counts as the positive one; kept at unit length.

    Raises
    ------
    UserError
        If a number is not finite or the normal has no direction.
    """

    point: Point = (0.0, 0.0, 0.0)
    normal: Point = (0.0, 1.0, 0.0)

    def __post_init__(self) -> None:
        if not np.isfinite((*self.point, *self.normal)).all():
            raise UserError("The centre plane holds a number that is not finite.")
        largest = max(abs(v) for v in self.normal)
        if largest == 0.0:
            raise UserError("The centre plane's normal has no direction.")
        scaled = np.asarray(self.normal) / largest
        unit = scaled / np.linalg.norm(scaled)
        object.__setattr__(self, "normal", tuple(float(v) for v in unit))

    @cached_property
    def placement(self) -> Placement:
        """The way from the plane's frame, where the plane is y = 0, to the model's frame.

        The smallest turn that takes the y axis to the normal; for a plane along two axes its
        numbers are exact, and for y = 0 nothing moves at all.
        """
        normal = np.asarray(self.normal)
        cosine = float(normal[1])
        if cosine < -0.999999:
            turn = np.diag([1.0, -1.0, -1.0])  # half a turn about x
        else:
            axis = np.cross(Y_AXIS, normal)
            skew = np.array(
                [[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]], float
            )
            turn = np.eye(3) + skew + skew @ skew / (1.0 + cosine)
        height = float(np.asarray(self.point) @ normal)
        x, y, z = (height * float(v) + 0.0 for v in normal)
        return Placement(tuple(float(v) + 0.0 for v in turn.ravel()), 1.0, (x, y, z))

    @cached_property
    def inverse(self) -> Placement:
        """The way from the model's frame to the plane's frame."""
        return self.placement.inverse()
