// GLSL of the skin, the shells and the fins.

const shared = /* glsl */ `
  precision highp sampler2DArray;
  struct Light { vec3 direction, irradiance; };
  struct Table { float ambient, diffuse, diffuse_exponent, specular, specular_exponent, self_shadow, self_shadow_exponent; };
  uniform Light lights[LIGHTS];
  uniform Table table;
  uniform vec3 eye;
  uniform float count, drawn;
  // Lengyel et al. 2001: hair with tangent t seen from v, reflected per irradiance.
  vec3 hairLight(vec3 t, vec3 v) {
    vec3 sum = vec3(0);
    for (int i = 0; i < LIGHTS; ++i) {
      float u = dot(t, lights[i].direction), w = dot(t, normalize(lights[i].direction + v));
      sum += lights[i].irradiance * (table.ambient
        + table.diffuse * pow(max(0.0, 1.0 - u * u), 0.5 * table.diffuse_exponent)
        + table.specular * pow(max(0.0, 1.0 - w * w), 0.5 * table.specular_exponent));
    }
    return sum;
  }
  // The hair at height h, relative to the skin: a Bezier curve from zero.
  vec3 along(vec3 a, vec3 b, vec3 c, float h) { return h * (3.0 * (1.0 - h) * ((1.0 - h) * a + h * b) + h * h * c); }
  vec3 tangent(vec3 a, vec3 b, vec3 c, float h) {
    return normalize(along(a, b, c, h + 0.02) - along(a, b, c, max(h - 0.02, 0.0)));
  }
  // After Banks 1994: darker towards the skin; h is the height, 0..1.
  float selfShadow(float h) {
    return mix(table.self_shadow, 1.0, pow(clamp(h, 0.0, 1.0), table.self_shadow_exponent));
  }
`;
const vertex = (body) => /* glsl */ `#include <common>\n${shared}${body}`;
const fragment = vertex;

/** The bare skin: Lambertian. */
export const skin = {
  vertexShader: vertex(/* glsl */ `
    in vec3 color;
    out vec3 shade;
    void main() {
      vec3 sum = vec3(0);
      for (int i = 0; i < LIGHTS; ++i) sum += lights[i].irradiance * max(0.0, dot(normal, lights[i].direction));
      shade = color * sum / PI;
      gl_Position = projectionMatrix * viewMatrix * vec4(position, 1);
    }`),
  fragmentShader: fragment(/* glsl */ `
    in vec3 shade;
    out vec4 result;
    void main() { result = vec4(shade, 1); }`),
};

/** All shells in one call: instances are drawn in order, the innermost first. */
export const shells = {
  vertexShader: vertex(/* glsl */ `
    in vec3 _fur, _fur_1, _fur_2, _fur_color, _fur_normal;
    in vec2 uv1, stray;
    in vec4 mean, lean; // Of the layer: colour and coverage; what leans less than hair, if it does.
    out vec3 at, shade, hair, coat, up, look;
    flat out vec4 fog;
    flat out vec2 strays;
    void main() {
      float h = (float(gl_InstanceID) + 0.5) / count;
      bool bald = dot(_fur, _fur) == 0.0;
      vec3 p = position + along(_fur_1, _fur_2, _fur, h);
      hair = bald ? normal : tangent(_fur_1, _fur_2, _fur, h);
      up = _fur_normal;
      coat = lean.w > 0.0 ? normalize(up + lean.xyz) : hair;
      look = eye - p;
      shade = _fur_color * hairLight(hair, normalize(look)) * selfShadow(h);
      at = vec3(FUR_UV, gl_InstanceID);
      fog = mean;
      strays = stray;
      gl_Position = bald ? vec4(0) : projectionMatrix * viewMatrix * vec4(p, 1);
    }`),
  fragmentShader: fragment(/* glsl */ `
    uniform sampler2DArray layers;
    uniform bool slanted, edge;
    uniform float guard_variance;
    in vec3 at, shade, hair, coat, up, look;
    flat in vec4 fog;
    flat in vec2 strays;
    out vec4 result;
    // Mean sine of the angle between a look and hairs that spread about a direction.
    float sine(vec3 hairs, vec3 v, float variance) {
      float c = dot(normalize(hairs), v);
      return sqrt(max(0.0, 1.0 - mix(c * c, 1.0, variance) / (1.0 + 2.0 * variance)));
    }
    void main() {
      result = texture(layers, at) * vec4(shade, 1);
      if (slanted) {
        // A slanting look takes a longer way through the layer; along the hairs it meets fewer of them. What the layer lets through on the
        // average is taken to that power: less covers evenly less, more is fog of the layer's mean colour.
        vec3 v = normalize(look);
        float facing = abs(dot(normalize(up), v)), through = 1.0 - min(fog.a, 0.9999);
        float way = mix(sine(coat, v, strays.x), sine(hair, v, guard_variance), strays.y) / max(facing, 0.08);
        if (way <= 1.0) result *= (1.0 - pow(through, way)) / max(fog.a, 1e-6);
        else result += (1.0 - result.a) * (1.0 - pow(through, way - 1.0)) * vec4(fog.rgb * shade, 1);
        // Where a shell is seen from its edge, as a line, the fins take over.
        if (edge) result *= smoothstep(0.0, 0.35, facing);
      }
      if (result.a < 0.002) discard;
    }`),
};

/** Strips on edges: x of a corner runs along the edge, y from the skin to the tips. */
export const fins = {
  vertexShader: vertex(/* glsl */ `
    in vec3 positionA, positionB, furA, furB, fur1A, fur1B, fur2A, fur2B, normalA, normalB, across;
    in vec4 colorA, colorB; // u in w
    uniform int fade;
    uniform float threshold;
    out vec3 shade;
    out vec2 at;
    out float seen;
    void main() {
      // One look for the whole edge, so that the fade does not vary over it.
      vec3 v = normalize(eye - 0.5 * (positionA + positionB));
      float a = dot(normalA, v), b = dot(normalB, v), nearest = min(abs(a), abs(b));
      bool outline = a * b < 0.0;
      seen = fade == 0 ? max(0.0, 2.0 * abs(dot(across, v)) - 1.0)
        : fade == 1 ? float(outline || nearest < threshold)
        : outline ? 1.0 : clamp(2.0 - 2.0 * nearest / max(threshold, 1e-4), 0.0, 1.0);
      bool second = position.x > 0.5;
      vec3 h1 = second ? fur1B : fur1A, h2 = second ? fur2B : fur2A, h3 = second ? furB : furA;
      float h = position.y * drawn / count;
      bool bald = dot(h3, h3) == 0.0;
      vec3 x = (second ? positionB : positionA) + along(h1, h2, h3, h);
      vec3 hair = bald ? v : tangent(h1, h2, h3, h);
      vec4 color = second ? colorB : colorA;
      shade = color.rgb * hairLight(hair, normalize(eye - x)) * selfShadow(h);
      at = vec2(color.w, h);
      gl_Position = seen > 0.0 ? projectionMatrix * viewMatrix * vec4(x, 1) : vec4(0);
    }`),
  fragmentShader: fragment(/* glsl */ `
    uniform sampler2DArray fin;
    in vec3 shade;
    in vec2 at;
    in float seen;
    out vec4 result;
    void main() {
      vec4 texel = texture(fin, vec3(at, 0));
      result = seen * vec4(texel.rgb * shade, texel.a);
    }`),
};
