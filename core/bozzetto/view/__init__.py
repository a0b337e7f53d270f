"""Cameras: how the sheet looks at the world."""

from __future__ import annotations

from bozzetto.view.camera import Camera, Rays

__all__ = ["Camera", "Rays"]
