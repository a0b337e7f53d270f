"""Cameras: how the sheet looks at the world."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera as Camera
    from bozzetto.view.camera import Rays as Rays
    from bozzetto.view.eye_fixed_motion import FOV_LIMITS as FOV_LIMITS
    from bozzetto.view.navigation import fit_points as fit_points
    from bozzetto.view.navigation import turn as turn
    from bozzetto.view.navigation import with_kind as with_kind
    from bozzetto.view.rotations import triple as triple
    from bozzetto.view.standard_views import STANDARD_VIEWS as STANDARD_VIEWS
    from bozzetto.view.standard_views import look_along as look_along
    from bozzetto.view.standard_views import standard_view as standard_view
else:
    __getattr__, __all__ = lazy_names(
        __name__,
        {
            "bozzetto.view.camera": "Camera Rays",
            "bozzetto.view.eye_fixed_motion": "FOV_LIMITS",
            "bozzetto.view.navigation": "fit_points turn with_kind",
            "bozzetto.view.rotations": "triple",
            "bozzetto.view.standard_views": "STANDARD_VIEWS look_along standard_view",
        },
    )
