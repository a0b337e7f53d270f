"""Pictures of a whole scene, framed by themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.scene.display_list import Handle, Layer, Scene, Shaded
from bozzetto.scene.palette import LIGHT, Palette
from bozzetto.scene.renderer import Shading, render
from bozzetto.scene.thickness_view import thickness_view
from bozzetto.view.page_views import framing, page_view

if TYPE_CHECKING:
    from bozzetto.scene.wall_thickness import Walls
    from bozzetto.view.camera import Camera


def picture(
    scene: Scene,
    *,
    view: str = "three-quarter",
    camera: Camera | None = None,
    palette: Palette = LIGHT,
    size: tuple[int, int] = (1200, 900),
    scale: float = 1.0,
    shading: Shading = "clay",
    background: bool = True,
) -> NDArray[np.uint8]:
    """Render a still picture of a scene, without handles.

    Handles are left out, and so are layers that hold handles and no surface: the lines and
    dots beside them belong to them.

    Parameters
    ----------
    scene : Scene
        What to draw.
    view : str
        Name of a standard view (see `bozzetto.view.standard_views`) that frames the scene.
    camera : Camera, optional
        Looks through this instead, whatever the view.
    palette : Palette
        Colours of the theme.
    size : (width, height)
        Pixels; ``scale`` multiplies them, and the widths of lines with them.
    scale : float
        Picture pixels per canvas pixel.
    shading : {"clay", "zebra", "curvature", "normals", "xray", "draft", "thickness"}
        How surfaces are shaded.
    background : bool
        Paper behind the scene, or nothing.

    Returns
    -------
    (h, w, 4) uint8
        RGBA, sRGB, straight alpha.

    Raises
    ------
    UserError
        If the view has no such name, or the picture is too large.
    """
    return picture_and_walls(
        scene, view=view, camera=camera, palette=palette, size=size, scale=scale,
        shading=shading, background=background,
    )[0]  # fmt: skip


def picture_and_walls(
    scene: Scene,
    *,
    view: str = "three-quarter",
    camera: Camera | None = None,
    palette: Palette = LIGHT,
    size: tuple[int, int] = (1200, 900),
    scale: float = 1.0,
    shading: Shading = "clay",
    background: bool = True,
) -> tuple[NDArray[np.uint8], Walls | None]:
    """Render a `picture`, and say where the thinnest wall is.

    Parameters
    ----------
    scene, view, camera, palette, size, scale, shading, background
        As in `picture`.

    Returns
    -------
    (h, w, 4) uint8
        As `picture`.
    Walls or None
        The thinnest wall; None where nothing is closed, or another shading than "thickness" does
        not look for it.

    Raises
    ------
    UserError
        As in `picture`.
    """
    scene = without_handles(scene)
    if camera is None:
        camera = framed(scene, view, size)
    walls = None
    if shading == "thickness":
        shown = thickness_view(scene, palette)
        scene, walls = shown.scene, shown.thinnest
    image = render(
        scene, camera, palette, size=size, scale=scale, shading=shading, background=background
    )
    return image, walls


def framed(
    scene: Scene, view: str = "three-quarter", size: tuple[int, int] = (1200, 900)
) -> Camera:
    """Return the camera of a `picture`: a standard view that frames all but the handles.

    Raises
    ------
    UserError
        If the view has no such name.
    """
    return framing(without_handles(scene).points(), view, _page(size))


def own_or_framed(scene: Scene, own: Camera | None, size: tuple[int, int] = (1200, 900)) -> Camera:
    """Return a person's own view if it shows all of a `picture`, else the three-quarter view."""
    return page_view(without_handles(scene).points(), own, _page(size))


def _page(size: tuple[int, int]) -> tuple[float, float]:
    """Return a size that a camera takes; `render` refuses the others."""
    return max(size[0], 1), max(size[1], 1)


def thumbnail(
    scene: Scene, size: int = 256, palette: Palette = LIGHT, camera: Camera | None = None
) -> NDArray[np.uint8]:
    """Render a square picture of a scene in the three-quarter view, shape (size, size, 4)."""
    return picture(scene, camera=camera, palette=palette, size=(size, size))


def without_handles(scene: Scene) -> Scene:
    """Return a scene without handles; itself where it holds none."""
    if not any(isinstance(item, Handle) for _, item in scene.items()):
        return scene
    kept = []
    for layer in scene.layers:
        items = tuple(item for item in layer.items if not isinstance(item, Handle))
        if len(items) == len(layer.items):
            kept.append(layer)
        elif any(isinstance(item, Shaded) for item in items):
            kept.append(Layer(layer.name, items, layer.owner, layer.tool, layer.chosen))
    return Scene(tuple(kept))
