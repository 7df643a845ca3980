// Multiple scattering in the coat, from the tables of pelage-transport as textures. `field_table`:
// radiance in four zones, by cosine to a light and optical depth towards it. `sent_table`: radiance
// that the undercoat scatters towards the view and radiance that falls on guard hairs, by the same.
// `response_table`: scattering of single hairs, one kind per row. Each has a layer per albedo of
// the hairs; `sent_table` has one per albedo and cosine of the view. A matrix holds the four zones
// of one colour in a column. Twin: `lookup` of pelage-transport.
// Needs: field_table, sent_table, response_table (texture_2d_array<f32>), table_sampler (linear,
// clamped).

#import shared/angles
#import shared/arithmetic
#import shared/constants
#import shared/transmittance

// Model of multiple scattering, fixed when the kernel is compiled. 0: none or similarity.
override MULTIPLE: u32 = 0u;
const MULTIPLE_DUAL: u32 = 1u;
const MULTIPLE_TRANSPORT: u32 = 2u;

// Along the row: shares of the sphere, fluxes, weights of forward and backward scattering.
const ROW_HEAD: i32 = 0;
// Responses of guard hairs to light from above and from below: TILTS rows, by the angle between
// normal and hair, for each of TILTS azimuths.
const ROW_GUARD: i32 = 1;
const TILTS: i32 = 8;
const ROW_DUAL_UNDERCOAT: i32 = 65;  // two rows, by the sine of the difference angle
const ROW_DUAL_GUARD: i32 = 67;

// Texture coordinate of x (0..1) between the centres of the first and the last of `count` texels.
fn table_coordinate(x: f32, count: u32) -> f32 {
    return (clamp(x, 0.0, 1.0) * f32(count - 1u) + 0.5) / f32(count);
}

// The layer below an albedo, and the weight of the next one.
fn albedo_layers(albedo: f32) -> vec2f {
    let last = f32(textureNumLayers(response_table) - 1u);
    let at = clamp(1.0 - sqrt(max(1.0 - albedo, 0.0)), 0.0, 1.0) * last;
    return lower_entry(at, last);
}

// A table interpolated between layer `layer` and the next.
fn between_layers(table: texture_2d_array<f32>, at: vec2f, layer: i32, weight: f32) -> vec4f {
    return mix(textureSampleLevel(table, table_sampler, at, layer, 0.0),
        textureSampleLevel(table, table_sampler, at, layer + 1, 0.0), weight);
}

// Entry of a row for one albedo at x (0..1); fractional rows are interpolated.
fn response_entry(row: f32, albedo: f32, x: f32) -> vec4f {
    let size = textureDimensions(response_table);
    let at = vec2f(table_coordinate(x, size.x), (row + 0.5) / f32(size.y));
    let t = albedo_layers(albedo);
    return between_layers(response_table, at, i32(t.x), t.y);
}

// Entry k of the head row.
fn table_head(k: i32) -> vec4f {
    return textureLoad(response_table, vec2i(k, ROW_HEAD), 0, 0);
}

// Texture coordinates of the cosine to a light and the optical depth towards it. Each colour has
// a third of the table, because the skin below is coloured too.
fn light_coordinates(size: vec2u, tau: f32, mu: f32, color: u32) -> vec2f {
    let depth = table_coordinate(sqrt(tau / TAU_BLOCKED), size.y / 3u);
    return vec2f(table_coordinate(mu, size.x), (depth + f32(color)) / 3.0);
}

// Radiance in four zones for one colour.
fn field_entry(albedo: f32, at: vec2f) -> vec4f {
    let t = albedo_layers(albedo);
    return between_layers(field_table, at, i32(t.x), t.y);
}

// Scattered radiance at optical depth `tau` towards a light at cosine `mu` to the normal, for an
// irradiance of 1; a column per colour.
fn scattered_field(albedo: vec3f, tau: f32, mu: f32) -> mat3x4f {
    let size = textureDimensions(field_table);
    return mat3x4f(field_entry(albedo.r, light_coordinates(size, tau, mu, 0u)),
        field_entry(albedo.g, light_coordinates(size, tau, mu, 1u)),
        field_entry(albedo.b, light_coordinates(size, tau, mu, 2u)));
}

// Entry of `sent_table` for one colour. `at`: texture coordinates of light and depth; `view`: lower
// layer of the view and the weight of the upper one.
fn sent_entry(albedo: f32, at: vec2f, view: vec2f) -> vec3f {
    let t = albedo_layers(albedo);
    let views = f32(textureNumLayers(sent_table)) / f32(textureNumLayers(response_table));
    var sum = vec3f(0.0);
    for (var k = 0u; k < 2u; k++) {
        let layer = i32((t.x + f32(k)) * views + view.x);
        let of_layer = between_layers(sent_table, at, layer, view.y).xyz;
        sum += of_layer * select(t.y, 1.0 - t.y, k == 0u);
    }
    return sum;
}

// For an irradiance of 1 at optical depth `tau` towards a light at cosine `mu_light` to the normal,
// and a view direction at cosine `mu_view`; a row per colour. First column: radiance per extinction
// that the undercoat scatters towards the view, of light scattered before. The others: radiance
// that falls on guard hairs from above and from below.
fn sent_radiance(albedo: vec3f, tau: f32, mu_light: f32, mu_view: f32) -> mat3x3f {
    let size = textureDimensions(sent_table);
    let x = (0.5 * clamp(mu_view, -1.0, 1.0) + 0.5) * f32(size.x - 1u);
    let view = lower_entry(x, f32(size.x - 1u));
    return transpose(mat3x3f(sent_entry(albedo.r, light_coordinates(size, tau, mu_light, 0u), view),
        sent_entry(albedo.g, light_coordinates(size, tau, mu_light, 1u), view),
        sent_entry(albedo.b, light_coordinates(size, tau, mu_light, 2u), view)));
}

// Irradiance of the skin by scattered light.
fn field_irradiance(field: mat3x4f) -> vec3f {
    return TAU * (vec4f(table_head(1).xy, 0.0, 0.0) * field);
}

// Radiance that a guard hair scatters towards `view`, lit by radiance `above` from the hemisphere
// of `normal` and `below` from the opposite one.
fn guard_response(albedo: vec3f, tangent: vec3f, view: vec3f, normal: vec3f, above: vec3f, below: vec3f) -> vec3f {
    let sin_o = dot(tangent, view);
    let along = dot(tangent, normal);
    // A reversed hair exchanges light from above and from below.
    let side = select(-1.0, 1.0, along >= 0.0);
    let across = view - sin_o * tangent;
    let up = side * (normal - along * tangent);
    let cos_azimuth = cosine_between(across, up);
    let last = f32(TILTS - 1);
    let tilt = acos(min(abs(along), 1.0)) / FRAC_PI_2 * last;
    let azimuth = acos(clamp(cos_azimuth, -1.0, 1.0)) / PI * last;
    let lower = lower_entry(azimuth, last);
    let row = f32(ROW_GUARD) + lower.x * f32(TILTS) + tilt;
    var radiance = vec3f(0.0);
    for (var c = 0u; c < 3u; c++) {
        let entry = mix(response_entry(row, albedo[c], 0.5 * sin_o + 0.5),
            response_entry(row + f32(TILTS), albedo[c], 0.5 * sin_o + 0.5), lower.y);
        let light = select(vec2f(below[c], above[c]), vec2f(above[c], below[c]), side > 0.0);
        radiance[c] = dot(entry.xy, light);
    }
    return radiance;
}
