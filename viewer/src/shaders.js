// SPDX-License-Identifier: Apache-2.0
// One vertex shader for surfaces of points (skin, wraps) and one for bones and muscles, which their carriers move; one
// fragment shader for all. Passes: 0 what is shown, 1 what is ghosted, 2 counting for the section.

const points = `
uniform highp sampler2D points, normals;
vec4 pointAt(uint i) { return texelFetch(points, ivec2(int(i % 256u), int(i / 256u)), 0); }
vec2 valueAt(vec4 point) { return point.w < 1e8 ? vec2(point.w, 1.0) : vec2(0.0); }
vec3 normalAt(uint i) { return texelFetch(normals, ivec2(int(i % 256u), int(i / 256u)), 0).xyz; }
`;

const head = `
precision highp float;
uniform mat4 viewMatrix, projectionMatrix;
uniform highp int pass;
out vec3 world, shadingNormal;
out vec2 value;  // of the field, and how much of the point has one
flat out int state;
`;

export const surfaceVertex = `${head}${points}
in uint point;
uniform float inset;
void main() {
  vec4 at = pointAt(point);
  shadingNormal = normalAt(point);
  world = at.xyz - inset * shadingNormal;
  value = valueAt(at);
  state = 1;
  gl_Position = projectionMatrix * viewMatrix * vec4(world, 1.0);
}`;

export const anatomyVertex = `${head}${points}
in vec3 position, normal, dual;
in uvec4 carriersA;
in uvec2 carriersB, motionAndPart;
in vec4 weightsA;
in vec2 weightsB;
in float share;
uniform highp sampler2D motions, parts;
uniform int onlyPart;

vec3 rotated(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }

void main() {
  int part = int(motionAndPart.y);
  state = int(texelFetch(parts, ivec2(part, 0), 0).r * 255.0 + 0.5);
  bool ghost = state == 2;
  if (state == 0 || (pass == 1) != ghost || (onlyPart >= 0 && part != onlyPart)) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  int motion = int(motionAndPart.x);
  vec4 q = texelFetch(motions, ivec2(2 * motion, 0), 0);
  vec3 t = texelFetch(motions, ivec2(2 * motion + 1, 0), 0).xyz;
  vec3 moved = rotated(q, position) + t;
  vec3 movedNormal = rotated(q, normal);
  world = moved;
  shadingNormal = movedNormal;
  value = vec2(0.0);
  if (share < 1.0) {
    vec4 a = pointAt(carriersA.x), b = pointAt(carriersA.y), c = pointAt(carriersA.z), d = pointAt(carriersA.w);
    vec4 e = pointAt(carriersB.x), f = pointAt(carriersB.y);
    vec3 carried = weightsA.x * a.xyz + weightsA.y * b.xyz + weightsA.z * c.xyz + weightsA.w * d.xyz
      + weightsB.x * e.xyz + weightsB.y * f.xyz;
    world = mix(carried, moved, share);
    value = weightsA.x * valueAt(a) + weightsA.y * valueAt(b) + weightsA.z * valueAt(c) + weightsA.w * valueAt(d)
      + weightsB.x * valueAt(e) + weightsB.y * valueAt(f);
    if (dual != vec3(0.0)) {
      vec3 u = b.xyz - a.xyz, v = c.xyz - a.xyz, w = d.xyz - a.xyz;
      shadingNormal = mix(dual.x * cross(v, w) + dual.y * cross(w, u) + dual.z * cross(u, v), movedNormal, share);
    }
  }
  gl_Position = projectionMatrix * viewMatrix * vec4(world, 1.0);
}`;

export const fragment = `
precision highp float;
in vec3 world, shadingNormal;
in vec2 value;
flat in int state;
uniform mat4 viewMatrix;
uniform vec3 cameraPosition;
uniform highp int pass;
uniform vec3 tissue, highlight;
uniform vec4 plane;      // shown where dot(plane.xyz, x) + plane.w >= 0
uniform float opacity, gloss;
uniform bool isAnatomy, byField;
uniform vec2 fieldRange;
uniform sampler2D ramp;
out vec4 colour;

vec3 srgb(vec3 c) { return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }
vec3 linear(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }

void main() {
  if (dot(plane.xyz, world) + plane.w < 0.0) discard;
  if (pass == 2) { colour = vec4(1.0); return; }
  vec3 toEye = normalize(cameraPosition - world);
  vec3 n = normalize(shadingNormal);
  if (!gl_FrontFacing) n = -n;
  vec3 base = tissue;
  if (byField) {
    float at = (value.x / max(value.y, 1e-6) - fieldRange.x) / (fieldRange.y - fieldRange.x);
    vec3 coloured = linear(texture(ramp, vec2(clamp(at, 0.0, 1.0), 0.5)).rgb);
    base = mix(linear(vec3(0.62)), coloured, clamp(value.y, 0.0, 1.0));
  }
  if (state == 3) base = mix(base, highlight, byField ? 0.35 : 0.8);
  // Lights that move with the camera, so that every view is lit: key from above left, fill from the right, sky.
  mat3 toWorld = transpose(mat3(viewMatrix));
  vec3 key = toWorld * normalize(vec3(-0.5, 0.75, 0.75)), fill = toWorld * normalize(vec3(0.9, 0.0, 0.5));
  float sky = 0.5 + 0.5 * n.y;
  float wrapped = max(0.0, (dot(n, key) + 0.25) / 1.25);
  vec3 light = mix(vec3(0.20, 0.19, 0.20), vec3(0.36, 0.38, 0.42), sky) + vec3(0.86, 0.83, 0.78) * wrapped
    + vec3(0.16, 0.18, 0.22) * max(0.0, dot(n, fill));
  float facing = clamp(dot(n, toEye), 0.0, 1.0);
  // Grazing surfaces are darker, as creases between parts are: it draws their outlines.
  light *= mix(0.62, 1.0, smoothstep(0.0, 0.55, facing));
  vec3 shown = base * light;
  vec3 halfway = normalize(key + toEye);
  shown += gloss * (byField ? 0.3 : 1.0) * pow(max(0.0, dot(n, halfway)), 38.0) * vec3(0.55);
  if (!gl_FrontFacing) shown *= 0.55;
  float alpha = opacity;
  if (pass == 1) {
    shown = mix(base, vec3(0.75), 0.6) * (0.5 + 0.5 * light);
    alpha = mix(0.22, 0.02, smoothstep(0.0, 0.9, facing));
  } else if (opacity < 1.0) {
    alpha = mix(min(1.0, opacity + 0.35), opacity, smoothstep(0.0, 0.7, facing));
  }
  colour = vec4(srgb(shown), alpha);
}`;

/** The filled cut: a large square in the plane, seen where the stencil counts an inside. */
export const capVertex = `
precision highp float;
in vec3 position;
uniform mat4 viewMatrix, projectionMatrix, placed;
out vec2 at;
void main() {
  at = position.xy;
  gl_Position = projectionMatrix * viewMatrix * placed * vec4(position, 1.0);
}`;

export const capFragment = `
precision highp float;
in vec2 at;
uniform vec3 tissue;
out vec4 colour;
vec3 srgb(vec3 c) { return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }
void main() { colour = vec4(srgb(tissue), 1.0); }`;
