// Multiple scattering in the coat, from the table `transport` of src/transport.rs: shares and fluxes of the four zones, weights of what
// comes from above and below; then the fields, the undercoat's responses and the guard hairs' responses. A matrix holds the four zones
// of one colour in a column.
// Needs: transport (array<vec4f>).

const TABLE_TINTS: u32 = 10u;
const TABLE_DEPTHS: u32 = 20u;
const TABLE_COSINES: u32 = 16u;
const TABLE_FIELD: u32 = 3u;
const TABLE_RESPONSE: u32 = TABLE_FIELD + TABLE_TINTS * TABLE_DEPTHS * TABLE_COSINES;
const TABLE_GUARD: u32 = TABLE_RESPONSE + TABLE_TINTS * TABLE_COSINES;

// Place in a table of `count` entries: the entry below and the weight of the next.
struct TablePlace {
    index: u32,
    part: f32,
}

fn table_place(x: f32, count: u32) -> TablePlace {
    let scaled = clamp(x, 0.0, 1.0) * f32(count - 1u);
    let index = min(u32(scaled), count - 2u);
    return TablePlace(index, scaled - f32(index));
}

fn tint_place(tint: f32) -> TablePlace {
    return table_place(1.0 - sqrt(max(1.0 - tint, 0.0)), TABLE_TINTS);
}

// Entry of a table [tint][cosine] for one colour.
fn table_entry(base: u32, tint: f32, at: TablePlace) -> vec4f {
    let t = tint_place(tint);
    let i = base + t.index * TABLE_COSINES + at.index;
    let low = mix(transport[i], transport[i + 1u], at.part);
    let high = mix(transport[i + TABLE_COSINES], transport[i + TABLE_COSINES + 1u], at.part);
    return mix(low, high, t.part);
}

fn field_entry(tint: f32, depth: TablePlace, light: TablePlace) -> vec4f {
    let t = tint_place(tint);
    var sides = array<vec4f, 2>();
    for (var k = 0u; k < 2u; k++) {
        let i = TABLE_FIELD + ((t.index + k) * TABLE_DEPTHS + depth.index) * TABLE_COSINES + light.index;
        let low = mix(transport[i], transport[i + 1u], light.part);
        let high = mix(transport[i + TABLE_COSINES], transport[i + TABLE_COSINES + 1u], light.part);
        sides[k] = mix(low, high, depth.part);
    }
    return mix(sides[0], sides[1], t.part);
}

// Scattered radiance at an optical depth `tau` towards a light of cosine `mu` to the normal, for an irradiance of 1.
fn scattered_field(tint: vec3f, tau: f32, mu: f32) -> mat3x4f {
    let depth = table_place(sqrt(tau / TAU_BLOCKED), TABLE_DEPTHS);
    let light = table_place(mu, TABLE_COSINES);
    return mat3x4f(field_entry(tint.r, depth, light), field_entry(tint.g, depth, light), field_entry(tint.b, depth, light));
}

// Radiance that undercoat sends to a view of cosine `mu` to the normal, by its extinction.
fn coat_response(tint: vec3f, mu: f32, field: mat3x4f) -> vec3f {
    let view = table_place(0.5 * mu + 0.5, TABLE_COSINES);
    return vec3f(dot(table_entry(TABLE_RESPONSE, tint.r, view), field[0]), dot(table_entry(TABLE_RESPONSE, tint.g, view), field[1]),
        dot(table_entry(TABLE_RESPONSE, tint.b, view), field[2]));
}

// Mean radiance of a field.
fn field_mean(field: mat3x4f) -> vec3f {
    return transport[0] * field;
}

// Slope of a field's radiance over the cosine to the normal.
fn field_slope(field: mat3x4f) -> vec3f {
    return 1.5 * (transport[1] * field);
}

// What falls on the skin.
fn field_irradiance(field: mat3x4f) -> vec3f {
    return 6.2831853 * (vec4f(transport[1].xy, 0.0, 0.0) * field);
}

// Radiance that a guard hair sends to `view` where the field has this mean, and this slope along `normal`.
fn guard_response(tint: vec3f, tangent: vec3f, view: vec3f, normal: vec3f, mean: vec3f, slope: vec3f) -> vec3f {
    let sin_o = dot(tangent, view);
    let across = normalize(view - sin_o * tangent + 1e-6 * normal);
    let at = table_place(0.5 * sin_o + 0.5, TABLE_COSINES);
    let axis = vec4f(0.0, dot(tangent, normal), dot(across, normal), 0.0);
    var radiance = vec3f(0.0);
    for (var c = 0u; c < 3u; c++) {
        let entry = table_entry(TABLE_GUARD, tint[c], at);
        radiance[c] = max(0.0, entry.x * mean[c] + dot(entry, axis) * slope[c]);
    }
    return radiance;
}
