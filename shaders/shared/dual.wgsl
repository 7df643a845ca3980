// Dual scattering, [Zinke2008], from the rows of `response_table` that hold what a hair scatters
// forward and backward. Twin: `dual` of pelage-transport.
// Needs: response_table (texture_2d_array<f32>), table_sampler; shared/transport.

#import shared/angles
#import shared/constants

fn unit_area_gaussian(x: f32, variance: f32) -> f32 {
    return exp(-0.5 * x * x / variance) * inverseSqrt(TAU * variance);
}

// Radiance of multiple scattering from l towards v at a hair with optical depth `tau` towards l,
// for an irradiance of 1, cosine of incidence included. `row`: first of the hair's two rows in
// `response_table`. [Zinke2008] eq. 5, 12 and 20
fn dual_scatter(row: i32, albedo: vec3f, tangent: vec3f, l: vec3f, v: vec3f, tau: f32) -> vec3f {
    let theta_i = asin(inclination_sine(tangent, l));
    let theta_o = asin(inclination_sine(tangent, v));
    let theta_d = 0.5 * (theta_o - theta_i);
    let turn = theta_i + theta_o;
    let x = 0.5 * sin(theta_d) + 0.5;
    let density = table_head(2).xy;
    let direct = exp(-tau);
    var sum = vec3f(0.0);
    for (var c = 0u; c < 3u; c++) {
        // Forward, backward, from behind; shift from behind.
        let shares = response_entry(f32(row), albedo[c], x);
        // Variances forward, backward, from behind; shift backward.
        let lobes = response_entry(f32(row + 1), albedo[c], x);
        // DEVIATION: the number of hairs along the path has a Poisson distribution of mean tau.
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
