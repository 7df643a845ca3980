// Scattering of guard hairs. L_o = sum_j E_j f cos(theta_i); theta is the inclination from the plane normal to the tangent.

struct Fibre {
    intensity: vec3f,  // R, TT, TRT
    diffuse: f32,
    shift: vec3f,      // radians
    azimuth_tt: f32,   // radians
    width: vec3f,      // radians
    glint: f32,
    glint_width: f32,  // radians
}

// Gaussian of unit height.
fn unit_gaussian(x: f32, width: f32) -> f32 {
    return exp(-0.5 * x * x / (width * width));
}

// Single scattering R, TT, TRT of Sadeghi et al. 2010 plus the Kajiya-Kay diffuse term; times cos(theta_i).
// `glint_angle` is the strand's own, radians. [Sadeghi2010]
fn scatter_fibre(fibre: Fibre, tangent: vec3f, l: vec3f, v: vec3f, tint: vec3f, glint_angle: f32) -> vec3f {
    let sin_i = clamp(dot(tangent, l), -1.0, 1.0);
    let sin_o = clamp(dot(tangent, v), -1.0, 1.0);
    let theta_i = asin(sin_i);
    let theta_o = asin(sin_o);
    let half_sum = 0.5 * (theta_i + theta_o);
    let cos_d = cos(0.5 * (theta_o - theta_i));
    let lp = l - sin_i * tangent;
    let vp = v - sin_o * tangent;
    let cos_phi = clamp(dot(lp, vp) * inverseSqrt(max(dot(lp, lp) * dot(vp, vp), 1e-12)), -1.0, 1.0);
    let phi = acos(cos_phi);
    let m_r = unit_gaussian(half_sum - fibre.shift.x, fibre.width.x);
    let m_tt = unit_gaussian(half_sum - fibre.shift.y, fibre.width.y);
    let m_trt = unit_gaussian(half_sum - fibre.shift.z, fibre.width.z);
    let n_r = cos(0.5 * phi);
    let n_tt = unit_gaussian(3.1415927 - phi, fibre.azimuth_tt);
    let n_g = fibre.glint * unit_gaussian(glint_angle - phi, fibre.glint_width);
    let single = fibre.intensity.x * m_r * n_r
        + fibre.intensity.y * m_tt * n_tt * tint
        + fibre.intensity.z * m_trt * (n_r + n_g) * tint * tint;
    let cos_i = sqrt(max(0.0, 1.0 - sin_i * sin_i));
    return cos_i * (single / max(cos_d * cos_d, 0.05) + fibre.diffuse * 0.10132118 * tint);
}
