"""The shader programs of the GL viewport, for old and for core profiles alike."""

from __future__ import annotations

from typing import Final

import numpy as np
from OpenGL import GL
from OpenGL.GL import shaders

from bozzetto.scene.renderer import highlights, zebra
from bozzetto.scene.renderer import shading as matter
from bozzetto.scene.renderer.lines_and_points import DASH, GAP
from bozzetto.scene.renderer.surfaces import XRAY_INK, XRAY_LEAST, XRAY_MOST

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
    "surface": ("a_place", "a_normal", "a_matter", "a_color"),
    "textured": ("a_place", "a_normal", "a_matter", "a_color", "a_texel"),
    "strip": ("a_before", "a_place", "a_after", "a_shape", "a_color"),
    "dot": ("a_place", "a_shape", "a_color"),
    "picture": ("a_place", "a_texel"),
}
"""Names of each program's vertex attributes; their positions are their locations."""

TEXTURED: Final = "#define TEXTURED\n"
"""Head of the surface's program with a picture on it."""

SURFACE_VERTEX: Final = """
uniform mat4 u_view; uniform mat4 u_projection;
uniform vec2 u_size; uniform float u_swell;
IN vec3 a_place; IN vec3 a_normal; IN vec2 a_matter; IN vec4 a_color;
OUT vec3 v_normal; OUT vec3 v_seen; OUT vec4 v_color; OUT vec2 v_matter;
#ifdef TEXTURED
IN vec2 a_texel; OUT vec2 v_texel;
#endif
void main() {
#ifdef TEXTURED
    v_texel = a_texel;
#endif
    vec4 seen = u_view * vec4(a_place, 1.0);
    v_seen = seen.xyz;
    v_normal = mat3(u_view) * a_normal;
    v_matter = a_matter;
    v_color = a_color;
    gl_Position = u_projection * seen;
    float reach = length(v_normal.xy);
    if (u_swell > 0.0 && reach > 1e-4)
        gl_Position.xy += v_normal.xy / reach * u_swell / (0.5 * u_size) * gl_Position.w;
}
"""

SURFACE_FRAGMENT: Final = """
uniform int u_shading; uniform float u_swell; uniform vec3 u_ink; uniform float u_parallel;
uniform float u_opacity; uniform mat4 u_view;
IN vec3 v_normal; IN vec3 v_seen; IN vec4 v_color; IN vec2 v_matter;
#ifdef TEXTURED
uniform sampler2D u_picture; IN vec2 v_texel;
#endif
float integral(float height) {
    float whole = floor(height);
    return 0.5 * whole + min(height - whole, 0.5);
}
vec3 stripes(vec3 base, vec3 normal, vec3 sight) {
    float climb = (reflect(-sight, normal) * mat3(u_view)).z;
    float height = asin(clamp(climb, -1.0, 1.0)) * %(TUBES_PART)s;
    float width = max(fwidth(height), %(SOFTNESS)s);
    float middle = height + 0.25;
    float light = (integral(middle + 0.5 * width) - integral(middle - 0.5 * width)) / width;
    return mix(mix(vec3(%(BLACK)s), vec3(%(WHITE)s), light), base, %(TINT)s);
}
vec3 ramp(vec3 base, float light, vec3 share) {
    vec3 shadow = base * share;
    vec3 dark = shadow + (base - shadow) * pow(clamp(light, 0.0, 1.0), 1.15);
    vec3 bright = base + (1.0 - base) * 0.55;
    float over = clamp((light - 0.86) / (%(BRIGHTEST)s - 0.86), 0.0, 1.0);
    return dark + (bright - dark) * over * over;
}
float within(float sine, float half_) {
    return smoothstep(-%(SOFT)s, %(SOFT)s, half_ - abs(sine));
}
vec3 mirrored(vec3 base, vec3 normal, float facing, vec4 sheen) {
    vec3 way = vec3(2.0 * normal.z * normal.xy, 2.0 * normal.z * normal.z - 1.0);
    float lamp = within(dot(way, vec3(%(ALONG)s)), %(HALF_LENGTH)s);
    lamp *= within(dot(way, vec3(%(OVER)s)), %(HALF_HEIGHT)s);
    if (dot(way, vec3(%(LAMP)s)) <= 0.0) lamp = 0.0;
    float light = clamp(sheen.y * lamp + sheen.z * pow(1.0 - facing, 5.0), 0.0, 1.0);
    return mix(base * sheen.x, mix(vec3(1.0), base, sheen.w), light);
}
void main() {
    if (u_swell > 0.0) { COLOR = vec4(u_ink, u_opacity); return; }
    vec3 normal = length(v_normal) > 0.0 ? normalize(v_normal) : vec3(0.0, 0.0, 1.0);
    bool inside = !gl_FrontFacing;
    if (inside) normal = -normal;
    vec3 sight = u_parallel > 0.5 ? vec3(0.0, 0.0, 1.0) : normalize(-v_seen);
    float facing = clamp(dot(normal, sight), 0.0, 1.0);
    float light = max(dot(normal, vec3(%(KEY)s)) + %(WRAP)s, 0.0) * %(KEY_PART)s;
    light += %(SKY_SHARE)s * (0.72 + 0.28 * normal.y);
    float grazing = (1.0 - facing) * (1.0 - facing);
    light += %(RIM_SHARE)s * grazing * grazing;
    if (inside) light *= %(INSIDE)s;
    vec3 base = v_color.rgb;
#ifdef TEXTURED
    vec4 texel = TEXTURE(u_picture, v_texel);
    base = (1.0 - texel.a) * base + texel.rgb;
#endif
    vec3 color;
    if (u_shading == 3) {
        color = 0.5 * normal + 0.5;
    } else if (v_matter.y > 0.5 && v_matter.y < 1.5) {
        color = stripes(base, normal, sight) * ramp(vec3(1.0), light, vec3(%(SHADOW)s));
    } else if (v_matter.x > 0.5) {
        color = base * ramp(vec3(1.0), light, vec3(%(HOLLOW_SHADOW)s));
    } else {
        color = ramp(base, light, vec3(%(HOLLOW_SHADOW)s));
    }
    if (v_matter.y > 1.5 && u_shading == 0 && !inside) {
        vec4 sheen = vec4(%(GLOSS)s);
        if (v_matter.y > 2.5) sheen = vec4(%(RUBBER)s);
        if (v_matter.y > 3.5) sheen = vec4(%(METAL)s);
        color = mirrored(color, normal, facing, sheen);
    }
    float opacity = v_color.a * u_opacity;
    if (u_shading == 4) {
        color = mix(color, u_ink, %(XRAY_INK)s);
        opacity *= mix(%(XRAY_LEAST)s, %(XRAY_MOST)s, grazing);
    }
    COLOR = vec4(color, opacity);
}
"""

STRIP_VERTEX: Final = """
uniform mat4 u_view; uniform mat4 u_projection; uniform vec2 u_size; uniform vec2 u_bias;
uniform float u_width;
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
    float width = u_width * a_shape.y;
    float half_ = 0.5 * width + 0.75;
    vec2 offset = side * (a_shape.x * half_ / mitre);
    v_across = vec2(a_shape.x * half_, 0.5 * width);
    v_along = a_shape.z;
    v_color = a_color;
    vec4 seen = u_view * vec4(a_place, 1.0);
    seen.xyz = seen.xyz * u_bias.x + vec3(0.0, 0.0, u_bias.y);
    gl_Position = u_projection * seen;
    gl_Position.xy += offset / (0.5 * u_size) * gl_Position.w;
}
"""

STRIP_FRAGMENT: Final = """
uniform float u_opacity; uniform float u_dash;
IN vec2 v_across; IN float v_along; IN vec4 v_color;
void main() {
    float cover = clamp(v_across.y + 0.5 - abs(v_across.x), 0.0, 1.0);
    cover *= min(2.0 * v_across.y, 1.0);
    if (u_dash > 0.0 && fract(v_along * u_dash) > %(DASH_SHARE)s) discard;
    COLOR = vec4(v_color.rgb, v_color.a * u_opacity * cover);
}
"""

DOT_VERTEX: Final = """
uniform mat4 u_view; uniform mat4 u_projection; uniform vec2 u_size; uniform vec2 u_bias;
uniform float u_width;
IN vec3 a_place; IN vec3 a_shape; IN vec4 a_color;
OUT vec3 v_corner; OUT vec4 v_color;
void main() {
    vec4 seen = u_view * vec4(a_place, 1.0);
    seen.xyz = seen.xyz * u_bias.x + vec3(0.0, 0.0, u_bias.y);
    vec4 place = u_projection * seen;
    float radius = 0.5 * u_width * a_shape.z;
    float reach = radius + 0.75;
    v_corner = vec3(a_shape.xy * reach, radius);
    v_color = a_color;
    place.xy += a_shape.xy * reach / (0.5 * u_size) * place.w;
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
    COLOR = vec4(texel.rgb / texel.a, texel.a * u_opacity);
}
"""

HOLLOW_SHADOW: Final = (0.36, 0.33, 0.33)
"""Share of a colour that is left without light. Less than in the software renderer, which darkens
hollows; what is mirrored is darkened by neither."""

# The software renderer's light, so that both viewports look alike.
LIGHT: Final = {
    "BRIGHTEST": matter.BRIGHTEST,
    "KEY": ", ".join(str(float(v)) for v in matter.KEY / np.linalg.norm(matter.KEY)),
    "WRAP": matter.WRAP,
    "KEY_PART": matter.KEY_SHARE / (1.0 + matter.WRAP),
    "SHADOW": ", ".join(map(str, matter.SHADOW)),
    "HOLLOW_SHADOW": ", ".join(map(str, HOLLOW_SHADOW)),
    "SKY_SHARE": matter.SKY_SHARE,
    "RIM_SHARE": matter.RIM_SHARE,
    "INSIDE": matter.INSIDE,
    "XRAY_INK": XRAY_INK,
    "XRAY_LEAST": XRAY_LEAST,
    "XRAY_MOST": XRAY_MOST,
    "TUBES_PART": zebra.TUBES / np.pi,
    "SOFTNESS": zebra.SOFTNESS,
    "WHITE": ", ".join(str(part / 255.0) for part in zebra.WHITE),
    "BLACK": ", ".join(str(part / 255.0) for part in zebra.BLACK),
    "TINT": zebra.TINT,
    "SOFT": highlights.SOFT,
    "HALF_LENGTH": highlights.HALF_LENGTH,
    "HALF_HEIGHT": highlights.HALF_HEIGHT,
    **{name: ", ".join(map(str, row)) for name, row in highlights.lamp_frame().items()},
    **{name.upper(): ", ".join(map(str, sheen)) for name, sheen in highlights.SHEENS.items()},
}

_SOURCES: Final = {
    "surface": (SURFACE_VERTEX, SURFACE_FRAGMENT % LIGHT),
    "textured": (TEXTURED + SURFACE_VERTEX, TEXTURED + SURFACE_FRAGMENT % LIGHT),
    "strip": (STRIP_VERTEX, STRIP_FRAGMENT % {"DASH_SHARE": DASH / (DASH + GAP)}),
    "dot": (DOT_VERTEX, DOT_FRAGMENT),
    "picture": (PICTURE_VERTEX, PICTURE_FRAGMENT),
}


def compile_program(name: str, *, core: bool) -> int:
    """Compile one of the programs in the current context.

    Parameters
    ----------
    name : str
        A key of `ATTRIBUTES`.
    core : bool
        Whether the context has a core profile (GLSL 3.30), else GLSL 1.20.
    """
    vertex, fragment = _SOURCES[name]
    heads = (CORE_VERTEX, CORE_FRAGMENT) if core else (OLD_VERTEX, OLD_FRAGMENT)
    program = GL.glCreateProgram()
    for head, body, kind in (
        (heads[0], vertex, GL.GL_VERTEX_SHADER),
        (heads[1], fragment, GL.GL_FRAGMENT_SHADER),
    ):
        GL.glAttachShader(program, shaders.compileShader([head, body], kind))
    for place, attribute in enumerate(ATTRIBUTES[name]):
        GL.glBindAttribLocation(program, place, attribute)
    GL.glLinkProgram(program)
    if GL.glGetProgramiv(program, GL.GL_LINK_STATUS) != GL.GL_TRUE:
        raise RuntimeError(GL.glGetProgramInfoLog(program))
    return int(program)
