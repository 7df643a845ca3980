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
    return sum / PI;
  }
  // After Banks 1994: darker towards the skin; h is the height, 0..1.
  float selfShadow(float h) {
    return mix(table.self_shadow, 1.0, pow(clamp(h, 0.0, 1.0), table.self_shadow_exponent));
  }
`;
const vertex = (body) => /* glsl */ `#include <common>\n${shared}${body}`;
const fragment = vertex;

/** The bare skin: Lambertian, as dark as the innermost hair. */
export const skin = {
  vertexShader: vertex(/* glsl */ `
    in vec3 color;
    out vec3 shade;
    void main() {
      vec3 sum = vec3(0);
      for (int i = 0; i < LIGHTS; ++i) sum += lights[i].irradiance * max(0.0, dot(normal, lights[i].direction));
      shade = color * selfShadow(0.0) * sum / PI;
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
    in vec3 _fur, _fur_color;
    in vec2 uv1;
    out vec3 at, shade;
    void main() {
      float l = float(gl_InstanceID), bald = step(length(_fur), 0.0);
      vec3 p = position + _fur * (l + 0.5) / count;
      shade = _fur_color * hairLight(normalize(_fur + bald * normal), normalize(eye - p)) * selfShadow(l / max(1.0, count - 1.0));
      at = vec3(FUR_UV, l);
      gl_Position = bald > 0.0 ? vec4(0) : projectionMatrix * viewMatrix * vec4(p, 1);
    }`),
  fragmentShader: fragment(/* glsl */ `
    uniform sampler2DArray layers;
    in vec3 at, shade;
    out vec4 result;
    void main() {
      vec4 hair = texture(layers, at);
      if (hair.a < 1.0 / 255.0) discard;
      result = vec4(hair.rgb * shade, hair.a);
    }`),
};

/** Quads on edges: x of the corner runs along the edge, y from the skin to the tips. */
export const fins = {
  vertexShader: vertex(/* glsl */ `
    in vec3 positionA, positionB, furA, furB, colorA, colorB, normalA, normalB;
    in vec2 u;
    uniform int fade;
    uniform float threshold;
    out vec3 shade;
    out vec2 at;
    out float seen;
    void main() {
      float top = drawn / count;
      vec3 tip = mix(furA, furB, position.x);
      vec3 p = mix(positionA, positionB, position.x) + tip * top * position.y;
      // One look for the whole edge, so that fade does not vary over it.
      vec3 v = normalize(eye - 0.5 * (positionA + positionB));
      vec3 n = normalize(normalA + normalB + 1e-6 * tip);
      float a = dot(normalA, v), b = dot(normalB, v);
      float border = min(abs(a), abs(b));
      bool outline = a * b < 0.0 || border < threshold;
      float cosine = abs(dot(normalize(cross(positionB - positionA, n)), v));
      seen = fade == 1 ? float(outline) : max(0.0, 2.0 * cosine - 1.0);
      if (fade == 2) seen = a * b < 0.0 ? 1.0 : seen * clamp(1.0 - border / threshold, 0.0, 1.0);
      shade = mix(colorA, colorB, position.x) * hairLight(normalize(tip), normalize(eye - p)) * selfShadow(top * position.y);
      at = vec2(mix(u.x, u.y, position.x), top * position.y);
      gl_Position = seen > 0.0 && dot(tip, tip) > 0.0 ? projectionMatrix * viewMatrix * vec4(p, 1) : vec4(0);
    }`),
  fragmentShader: fragment(/* glsl */ `
    uniform sampler2DArray fin;
    in vec3 shade;
    in vec2 at;
    in float seen;
    out vec4 result;
    void main() {
      vec4 hair = texture(fin, vec3(at, 0));
      result = seen * vec4(hair.rgb * shade, hair.a);
    }`),
};
