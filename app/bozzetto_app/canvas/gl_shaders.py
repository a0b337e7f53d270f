"""The shader programs of the GL viewport, for old and for core profiles alike."""

from __future__ import annotations

from typing import Final

from OpenGL import GL
from OpenGL.GL import shaders

__all__ = ["ATTRIBUTES", "compile_program"]

OLD_VERTEX: Final = "#version 120\n#define IN attribute\n#define OUT varying\n"
OLD_FRAGMENT: Final = (
    "#version 120\n#define IN varying\n#define COLOR gl_FragColor\n#define TEXTURE texture2D\n"
)
CORE_VERTEX: Final = "#version 330 core\n#define IN in\n#define OUT out\n"
CORE_FRAGMENT: Final = (
    "#version 330 core\n#define IN in\nout vec4 f_color;\n#define COLOR f_color\n"
    "#define TEXTURE texture\n"
)

ATTRIBUTES: Final = {
    "surface": ("a_place", "a_normal", "a_color"),
    "strip": ("a_before", "a_place", "a_after", "a_shape", "a_color"),
    "dot": ("a_place", "a_shape", "a_color"),
    "picture": ("a_place", "a_texel"),
}
"""Names of each program's vertex attributes; their positions are their locations."""

SURFACE_VERTEX: Final = """
uniform mat4 u_view; uniform mat4 u_projection;
IN vec3 a_place; IN vec3 a_normal; IN vec4 a_color;
OUT vec3 v_normal; OUT vec3 v_seen; OUT vec4 v_color;
void main() {
    vec4 seen = u_view * vec4(a_place, 1.0);
    v_seen = seen.xyz; v_normal = mat3(u_view) * a_normal; v_color = a_color;
    gl_Position = u_projection * seen;
}
"""

STRIP_VERTEX: Final = """
uniform mat4 u_view; uniform mat4 u_projection; uniform vec2 u_size;
IN vec3 a_before; IN vec3 a_place; IN vec3 a_after; IN vec3 a_shape; IN vec4 a_color;
OUT vec2 v_across; OUT float v_along; OUT vec4 v_color;
vec2 on_sheet(vec4 clip) { return clip.xy / max(clip.w, 1e-6) * 0.5 * u_size; }
vec2 heading(vec2 from, vec2 to) {
    vec2 step = to - from;
    float length_ = length(step);
    return length_ > 1e-4 ? step / length_ : vec2(0.0);
}
void main() {
    mat4 both = u_projection * u_view;
    vec4 place = both * vec4(a_place, 1.0);
    vec2 here = on_sheet(place);
    vec2 came = heading(on_sheet(both * vec4(a_before, 1.0)), here);
    vec2 goes = heading(here, on_sheet(both * vec4(a_after, 1.0)));
    if (came == vec2(0.0)) came = goes;
    if (goes == vec2(0.0)) goes = came;
    vec2 middle = came + goes;
    middle = length(middle) > 1e-3 ? normalize(middle) : came;
    vec2 side = vec2(-middle.y, middle.x);
    float mitre = clamp(abs(dot(side, vec2(-goes.y, goes.x))), 0.5, 1.0);
    float half_ = 0.5 * a_shape.y + 0.75;
    vec2 offset = side * (a_shape.x * half_ / mitre);
    v_across = vec2(a_shape.x * half_, 0.5 * a_shape.y);
    v_along = a_shape.z;
    v_color = a_color;
    place.xy += offset / (0.5 * u_size) * place.w;
    place.z -= %(LINE_BIAS)s * place.w;
    gl_Position = place;
}
"""

STRIP_FRAGMENT: Final = """
uniform float u_opacity; uniform float u_dash;
IN vec2 v_across; IN float v_along; IN vec4 v_color;
void main() {
    float cover = clamp(v_across.y + 0.5 - abs(v_across.x), 0.0, 1.0);
    cover *= min(2.0 * v_across.y, 1.0);
    if (u_dash > 0.0 && fract(v_along * u_dash) > 0.5) discard;
    COLOR = vec4(v_color.rgb, v_color.a * u_opacity * cover);
}
"""

DOT_VERTEX: Final = """
uniform mat4 u_view; uniform mat4 u_projection; uniform vec2 u_size;
IN vec3 a_place; IN vec3 a_shape; IN vec4 a_color;
OUT vec3 v_corner; OUT vec4 v_color;
void main() {
    vec4 place = u_projection * u_view * vec4(a_place, 1.0);
    float reach = 0.5 * a_shape.z + 0.75;
    v_corner = vec3(a_shape.xy * reach, 0.5 * a_shape.z);
    v_color = a_color;
    place.xy += a_shape.xy * reach / (0.5 * u_size) * place.w;
    place.z -= %(DOT_BIAS)s * place.w;
    gl_Position = place;
}
"""

DOT_FRAGMENT: Final = """
uniform float u_opacity;
IN vec3 v_corner; IN vec4 v_color;
void main() {
    float cover = clamp(v_corner.z + 0.5 - length(v_corner.xy), 0.0, 1.0);
    if (cover <= 0.0) discard;
    COLOR = vec4(v_color.rgb, v_color.a * u_opacity * cover);
}
"""

PICTURE_VERTEX: Final = """
uniform mat4 u_view; uniform mat4 u_projection;
IN vec3 a_place; IN vec2 a_texel;
OUT vec2 v_texel;
void main() {
    v_texel = a_texel;
    gl_Position = u_projection * u_view * vec4(a_place, 1.0);
}
"""

PICTURE_FRAGMENT: Final = """
uniform sampler2D u_picture; uniform float u_opacity;
IN vec2 v_texel;
void main() {
    vec4 texel = TEXTURE(u_picture, v_texel);
    if (texel.a * u_opacity < 0.004) discard;
    COLOR = vec4(texel.rgb, texel.a * u_opacity);
}
"""
