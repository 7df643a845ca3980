// Dual scattering, [Zinke2008], from the rows of `response_table` that say what a hair scatters on and back. Twin: src/transport/dual.rs.
// Needs: shared/transport.

#import shared/angles
#import shared/constants

fn unit_area_gaussian(x: f32, variance: f32) -> f32 {
    return exp(-0.5 * x * x / variance) * inverseSqrt(TAU * variance);
}

// Light scattered more than once from l to v by a hair with the optical depth `tau` towards l, for an irradiance of 1; the cosine of
// incidence is in it. `row` says whose hair. [Zinke2008] eq. 5, 12 and 20
fn dual_scatter(row: i32, tint: vec3f, tangent: vec3f, l: vec3f, v: vec3f, tau: f32) -> vec3f {
    let theta_i = asin(inclination_sine(tangent, l));
    let theta_o = asin(inclination_sine(tangent, v));
    let theta_d = 0.5 * (theta_o - theta_i);
    let turn = theta_i + theta_o;
    let x = 0.5 * sin(theta_d) + 0.5;
    let density = table_head(2).xy;
    let direct = exp(-tau);
    var sum = vec3f(0.0);
    for (var c = 0u; c < 3u; c++) {
        let shares = response_entry(f32(row), tint[c], x);      // on, back, from behind, shift from behind
        let lobes = response_entry(f32(row + 1), tint[c], x);   // variances on, back, from behind; shift back
        // DEVIATION: the number of hairs on the way has a Poisson distribution here, of mean tau.
        let forward = density.x * (exp(-tau * (1.0 - shares.x)) - direct);
        let spread = max(tau * shares.x, 1.0) * lobes.x;
        let near = 2.0 * shares.z * unit_area_gaussian(turn - shares.w, lobes.z);
        let far = 2.0 * shares.z * unit_area_gaussian(turn - shares.w, lobes.z + spread);
        let around = shares.y * unit_area_gaussian(turn - lobes.w, lobes.y + spread);
        sum[c] = direct * density.y * near + forward * (around + PI * density.y * far);
    }
    let cos_d = cos(theta_d);
    return max(0.0, cos(theta_i)) * sum / (PI * max(cos_d * cos_d, 0.05));
}
