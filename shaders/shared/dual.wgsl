// Dual scattering, [Zinke2008], from tables that stand behind those of shared/transport: two entries for each [tint][sine of the
// inclination] of the undercoat's fibres, then of the guard hairs'. Twin: src/transport/dual.rs.
// Needs: transport (array<vec4f>), shared/transport.

const TABLE_DUAL: u32 = TABLE_GUARD + TABLE_TINTS * TABLE_COSINES;
const DUAL_COAT: u32 = 0u;
const DUAL_GUARD: u32 = 2u * TABLE_TINTS * TABLE_COSINES;

fn unit_area_gaussian(x: f32, variance: f32) -> f32 {
    return exp(-0.5 * x * x / variance) * inverseSqrt(6.2831853 * variance);
}

// Entry `which` (0, 1) at a place of the table.
fn dual_entry(layer: u32, tint: f32, at: TablePlace, which: u32) -> vec4f {
    let t = tint_place(tint);
    let i = TABLE_DUAL + layer + 2u * (t.index * TABLE_COSINES + at.index) + which;
    let low = mix(transport[i], transport[i + 2u], at.part);
    let high = mix(transport[i + 2u * TABLE_COSINES], transport[i + 2u * TABLE_COSINES + 2u], at.part);
    return mix(low, high, t.part);
}

// Light scattered more than once from l to v by a hair with the optical depth `tau` towards l, for an irradiance of 1; the cosine of
// incidence is in it. [Zinke2008] eq. 5, 12 and 20
fn dual_scatter(layer: u32, tint: vec3f, tangent: vec3f, l: vec3f, v: vec3f, tau: f32) -> vec3f {
    let theta_i = asin(clamp(dot(tangent, l), -1.0, 1.0));
    let theta_o = asin(clamp(dot(tangent, v), -1.0, 1.0));
    let theta_d = 0.5 * (theta_o - theta_i);
    let turn = theta_i + theta_o;
    let at = table_place(0.5 * sin(theta_d) + 0.5, TABLE_COSINES);
    let density = transport[2].xy;
    let direct = exp(-tau);
    var sum = vec3f(0.0);
    for (var c = 0u; c < 3u; c++) {
        let shares = dual_entry(layer, tint[c], at, 0u);    // on, back, from behind, shift from behind
        let lobes = dual_entry(layer, tint[c], at, 1u);     // variances on, back, from behind; shift back
        // DEVIATION: the number of hairs on the way has a Poisson distribution here, of mean tau.
        let forward = density.x * (exp(-tau * (1.0 - shares.x)) - direct);
        let spread = max(tau * shares.x, 1.0) * lobes.x;
        let near = 2.0 * shares.z * unit_area_gaussian(turn - shares.w, lobes.z);
        let far = 2.0 * shares.z * unit_area_gaussian(turn - shares.w, lobes.z + spread);
        let around = shares.y * unit_area_gaussian(turn - lobes.w, lobes.y + spread);
        sum[c] = direct * density.y * near + forward * (around + 3.1415927 * density.y * far);
    }
    let cos_d = cos(theta_d);
    return max(0.0, cos(theta_i)) * sum / (3.1415927 * max(cos_d * cos_d, 0.05));
}
