"""Items of the GL viewport: each draws one batch of one layer in one pass."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray
from OpenGL import GL
from pyqtgraph.opengl.GLGraphicsItem import GLGraphicsItem

from bozzetto.scene.renderer.lines_and_points import DASH, FAINT_OPACITY, FAINT_WIDTH, GAP
from bozzetto_app.canvas.viewport.opengl_shaders import ATTRIBUTES, compile_program
from bozzetto_app.canvas.viewport.opengl_textures import Textures

if TYPE_CHECKING:
    from bozzetto.scene.display_list import Image
    from bozzetto_app.canvas.viewport.opengl_buffers import Batch

__all__ = ["BatchItem", "Frame", "GlassItem", "LineItem", "PictureItem", "Programs", "SurfaceItem"]

HULL: Final = 1.1
"""How far the far side of a mesh is blown up to show as a contour line, pixels."""


class Frame:
    """Values that all items of one picture share."""

    def __init__(self) -> None:
        self.number = 0
        """Another one for each picture."""
        self.view: NDArray[np.float32] = np.eye(4, dtype=np.float32)
        self.projection: NDArray[np.float32] = np.eye(4, dtype=np.float32)
        self.size = (1.0, 1.0)
        self.pixels_per_mm = 1.0
        self.parallel = False
        self.bias = (1.0, 0.0)
        """How far lines come towards the eye: a factor on eye coordinates, and mm."""
        self.shading = 0
        self.ink = (0.0, 0.0, 0.0)
        self.contour = (0.0, 0.0, 0.0)


class Programs:
    """The compiled programs of one context, made when first used, and its pictures."""

    def __init__(self, *, core: bool) -> None:
        self._core = core
        self._programs: dict[str, int] = {}
        self._places: dict[tuple[int, str], int] = {}
        self._told: dict[str, int] = {}
        self.textures = Textures()

    def use(self, name: str, frame: Frame) -> int:
        """Make a program current; tell it about the view, once a picture."""
        program = self._programs.get(name)
        if program is None:
            program = self._programs[name] = compile_program(name, core=self._core)
        GL.glUseProgram(program)
        if self._told.get(name) == frame.number:
            return program
        self._told[name] = frame.number
        # Rows of numpy are columns of OpenGL: hence the transposition.
        GL.glUniformMatrix4fv(self.place(program, "u_view"), 1, GL.GL_TRUE, frame.view)
        GL.glUniformMatrix4fv(self.place(program, "u_projection"), 1, GL.GL_TRUE, frame.projection)
        if name in ("strip", "dot"):
            GL.glUniform2f(self.place(program, "u_bias"), *frame.bias)
        if name != "picture":
            GL.glUniform2f(self.place(program, "u_size"), *frame.size)
        return program

    def free(self) -> None:
        """Give programs and pictures back; the context must be current."""
        for program in self._programs.values():
            GL.glDeleteProgram(program)
        self._programs.clear()
        self._places.clear()
        self._told.clear()
        self.textures.free()

    def place(self, program: int, uniform: str) -> int:
        """Where a uniform lives."""
        key = (program, uniform)
        if key not in self._places:
            self._places[key] = GL.glGetUniformLocation(program, uniform)
        return self._places[key]


class BatchItem(GLGraphicsItem):  # type: ignore[misc]
    """A batch with its two buffers on the card.

    Parameters
    ----------
    program : str
    batch : Batch
    order : int
        Place among the passes of a picture; smaller ones are drawn first.
    """

    def __init__(self, program: str, batch: Batch, order: int) -> None:
        super().__init__()
        self.setDepthValue(order)
        self.program = program
        self._batch = batch
        self._buffers: tuple[int, int] | None = None

    def free(self) -> None:
        """Give the buffers back; the context must be current."""
        if self._buffers is not None:
            GL.glDeleteBuffers(2, np.array(self._buffers, np.uint32))
            self._buffers = None

    def forget(self) -> None:
        """Upload again: the context is another one."""
        self._buffers = None

    def paint(self) -> None:
        """Draw the batch; pyqtgraph calls this in the order of depth values."""
        if not len(self._batch.indices):
            return
        view = self.view()
        program = view.programs.use(self.program, view.frame)
        self._bind()
        try:
            self.passes(view.programs, program, view.frame)
        finally:
            for place in range(len(ATTRIBUTES[self.program])):
                GL.glDisableVertexAttribArray(place)
            GL.glBindBuffer(GL.GL_ARRAY_BUFFER, 0)
            GL.glBindBuffer(GL.GL_ELEMENT_ARRAY_BUFFER, 0)
            GL.glUseProgram(0)
            GL.glDepthMask(GL.GL_TRUE)
            GL.glDepthFunc(GL.GL_LESS)
            GL.glDisable(GL.GL_CULL_FACE)
            GL.glDisable(GL.GL_BLEND)
            GL.glDisable(GL.GL_POLYGON_OFFSET_FILL)

    def passes(self, programs: Programs, program: int, frame: Frame) -> None:
        """Set the state of each pass and draw it."""
        raise NotImplementedError

    def draw(self) -> None:
        """Draw all triangles with the state as it is."""
        GL.glDrawElements(GL.GL_TRIANGLES, len(self._batch.indices), GL.GL_UNSIGNED_INT, None)

    def _bind(self) -> None:
        batch = self._batch
        if self._buffers is None:
            vertices, indices = (int(name) for name in GL.glGenBuffers(2))
            self._buffers = vertices, indices
            GL.glBindBuffer(GL.GL_ARRAY_BUFFER, vertices)
            GL.glBufferData(
                GL.GL_ARRAY_BUFFER, batch.vertices.nbytes, batch.vertices, GL.GL_STATIC_DRAW
            )
            GL.glBindBuffer(GL.GL_ELEMENT_ARRAY_BUFFER, indices)
            GL.glBufferData(
                GL.GL_ELEMENT_ARRAY_BUFFER, batch.indices.nbytes, batch.indices, GL.GL_STATIC_DRAW
            )
        GL.glBindBuffer(GL.GL_ARRAY_BUFFER, self._buffers[0])
        GL.glBindBuffer(GL.GL_ELEMENT_ARRAY_BUFFER, self._buffers[1])
        stride, start = 4 * sum(batch.widths), 0
        for place, width in enumerate(batch.widths):
            GL.glEnableVertexAttribArray(place)
            GL.glVertexAttribPointer(
                place, width, GL.GL_FLOAT, GL.GL_FALSE, stride, ctypes.c_void_p(start)
            )
            start += 4 * width


def _blend() -> None:
    GL.glEnable(GL.GL_BLEND)
    GL.glBlendFuncSeparate(
        GL.GL_SRC_ALPHA, GL.GL_ONE_MINUS_SRC_ALPHA, GL.GL_ONE, GL.GL_ONE_MINUS_SRC_ALPHA
    )


def _shade(
    programs: Programs, program: int, frame: Frame, texture: NDArray[np.uint8] | None
) -> None:
    if texture is not None:
        GL.glActiveTexture(GL.GL_TEXTURE0)
        programs.textures.bind(texture)
        GL.glUniform1i(programs.place(program, "u_picture"), 0)
    GL.glUniform1i(programs.place(program, "u_shading"), frame.shading)
    GL.glUniform3f(programs.place(program, "u_ink"), *frame.ink)
    GL.glUniform1f(programs.place(program, "u_parallel"), float(frame.parallel))
    GL.glUniform1f(programs.place(program, "u_opacity"), 1.0)
    GL.glUniform1f(programs.place(program, "u_swell"), 0.0)


class _MeshItem(BatchItem):
    """Meshes, or one with a texture, (h, w, 4) RGBA."""

    def __init__(self, batch: Batch, texture: NDArray[np.uint8] | None, order: int) -> None:
        super().__init__("surface" if texture is None else "textured", batch, order)
        self.texture = texture


class SurfaceItem(_MeshItem):
    """Opaque meshes; pushed back a little so that lines on them are seen."""

    def passes(self, programs: Programs, program: int, frame: Frame) -> None:
        """Draw the surface, then its far side enlarged by a pixel, which leaves the contour."""
        _shade(programs, program, frame, self.texture)
        GL.glEnable(GL.GL_DEPTH_TEST)
        GL.glEnable(GL.GL_POLYGON_OFFSET_FILL)
        GL.glPolygonOffset(1.0, 1.0)
        self.draw()
        GL.glPolygonOffset(2.0, 4.0)
        GL.glUniform3f(programs.place(program, "u_ink"), *frame.contour)
        GL.glUniform1f(programs.place(program, "u_swell"), HULL)
        GL.glEnable(GL.GL_CULL_FACE)
        GL.glCullFace(GL.GL_FRONT)
        self.draw()
        GL.glCullFace(GL.GL_BACK)


class GlassItem(_MeshItem):
    """A translucent mesh: the far side first, then the near one."""

    def passes(self, programs: Programs, program: int, frame: Frame) -> None:
        """Back faces, then front faces; neither hides anything."""
        _shade(programs, program, frame, self.texture)
        _blend()
        GL.glEnable(GL.GL_DEPTH_TEST)
        GL.glDepthMask(GL.GL_FALSE)
        GL.glEnable(GL.GL_CULL_FACE)
        for side in (GL.GL_FRONT, GL.GL_BACK):
            GL.glCullFace(side)
            self.draw()


class LineItem(BatchItem):
    """Ribbons or discs: the parts behind surfaces faintly, then the visible ones."""

    def __init__(self, program: str, batch: Batch, order: int, hidden: str) -> None:
        super().__init__(program, batch, order)
        self._hidden = hidden

    def passes(self, programs: Programs, program: int, frame: Frame) -> None:
        """Draw the hidden parts without writing depth, then the visible ones."""
        _blend()
        GL.glDepthMask(GL.GL_FALSE)
        if self._hidden == "show":
            GL.glDisable(GL.GL_DEPTH_TEST)
            self._draw_lines(programs, program)
            GL.glEnable(GL.GL_DEPTH_TEST)
            return
        GL.glEnable(GL.GL_DEPTH_TEST)
        if self._hidden != "hide":
            GL.glDepthFunc(GL.GL_GREATER)
            if self._hidden == "dashed":
                dashes = frame.pixels_per_mm / (DASH + GAP)
                self._draw_lines(programs, program, 0.5, FAINT_WIDTH, dashes)
            else:
                self._draw_lines(programs, program, FAINT_OPACITY, FAINT_WIDTH)
        GL.glDepthFunc(GL.GL_LEQUAL)
        self._draw_lines(programs, program)

    def _draw_lines(
        self,
        programs: Programs,
        program: int,
        opacity: float = 1.0,
        width: float = 1.0,
        dashes: float = 0.0,
    ) -> None:
        GL.glUniform1f(programs.place(program, "u_opacity"), opacity)
        GL.glUniform1f(programs.place(program, "u_width"), width)
        if self.program == "strip":
            GL.glUniform1f(programs.place(program, "u_dash"), dashes)
        self.draw()


class PictureItem(BatchItem):
    """A picture; it hides nothing, since ink is drawn on it."""

    def __init__(self, batch: Batch, order: int, image: Image) -> None:
        super().__init__("picture", batch, order)
        self._image = image

    def passes(self, programs: Programs, program: int, frame: Frame) -> None:
        """One blended pass behind what stands in front of it."""
        GL.glActiveTexture(GL.GL_TEXTURE0)
        programs.textures.bind(self._image.pixels)
        _blend()
        GL.glEnable(GL.GL_DEPTH_TEST)
        GL.glDepthMask(GL.GL_FALSE)
        GL.glUniform1i(programs.place(program, "u_picture"), 0)
        GL.glUniform1f(programs.place(program, "u_opacity"), self._image.opacity)
        self.draw()
        GL.glBindTexture(GL.GL_TEXTURE_2D, 0)
