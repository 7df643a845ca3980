// Scattering by single hairs: L_o = sum_j E_j f cos(theta_i), theta being the inclination from the
// plane normal to the tangent. The model is an argument that is known when a kernel is compiled.
// Far fields of models that depend on the offset across the fibre are read from a table
// (`fibre::table` of pelage-fur): R, TT, TRT and the rest by azimuth, inclination of the view and
// absorption.
// Needs: far_texel(i), a texel of the buffer that holds the tables.

#import shared/angles
#import shared/arithmetic
#import shared/constants

struct Fibre {
    intensity: vec3f,       // Sadeghi: R, TT, TRT
    diffuse: f32,
    shift: vec3f,           // Sadeghi: radians
    azimuth_tt: f32,        // radians
    width: vec3f,           // Sadeghi: radians
    glint: f32,
    glint_width: f32,       // radians
    specular: f32,
    specular_exponent: f32,
    divisor: f32,           // absorption = (log(colour) / divisor)^2; 0: `absorption` holds
    absorption: vec3f,      // per radius
    table_base: u32,        // first texel of the table
    variance: vec4f,        // longitudinal, of R, TT, TRT and the rest
    turn_sin: vec4f,        // of the shift of theta_o per lobe; with a medulla, R: of the tilt
    turn_cos: vec4f,
    table_size: vec3u,      // azimuths, inclinations, layers
    padding: u32,
}

const MODEL_KAJIYA_KAY: u32 = 0u;
const MODEL_SADEGHI: u32 = 1u;
const MODEL_SADEGHI_NORMALISED: u32 = 2u;
const MODEL_CHIANG: u32 = 3u;
const MODEL_MEDULLA: u32 = 4u;

// Mean azimuth of the glints, radians.
const MEAN_GLINT: f32 = 0.6544985;

// Gaussian of unit height.
fn unit_gaussian(x: f32, width: f32) -> f32 {
    return exp(-0.5 * x * x / (width * width));
}

// Radiance from `l` towards `v` (both point away from the hair) per irradiance and colour. The
// diffuse term is lossless at 1/pi^2 with the sine of the incidence; the specular term lies on the
// mirror cone T.V = -T.L. [KajiyaKay1989]
fn kajiya_kay(diffuse: f32, specular: f32, exponent: f32, tangent: vec3f, l: vec3f, v: vec3f) -> f32 {
    let dot_l = dot(tangent, l);
    let sin_l = complement(dot_l);
    var value = diffuse * FRAC_1_PI_SQUARED * sin_l;
    if specular > 0.0 {
        let dot_v = dot(tangent, v);
        let mirror = sin_l * complement(dot_v) - dot_l * dot_v;
        value += specular * pow(max(mirror, 0.0), exponent) * FRAC_1_TAU;
    }
    return value;
}

// I0(x) e^-x for x >= 0: the modified Bessel function of the first kind, scaled.
// [AbramowitzStegun1964] 9.8.1 and 9.8.2
fn bessel_i0e(x: f32) -> f32 {
    let t = x / 3.75;
    let s = t * t;
    let low = (1.0 + s * (3.5156229 + s * (3.0899424 + s * (1.2067492 + s * (0.2659732 + s * (0.0360768
        + s * 0.0045813)))))) * exp(-min(x, 4.0));
    let r = 3.75 / max(x, 3.75);
    let high = (0.39894228 + r * (0.01328592 + r * (0.00225319 + r * (-0.00157565 + r * (0.00916281
        + r * (-0.02057706 + r * (0.02635537 + r * (-0.01647633 + r * 0.00392377)))))))) * inverseSqrt(max(x, 3.75));
    return select(high, low, x < 3.75);
}

// Longitudinal scattering function of variance v; `i` and `o`: sine and cosine of the inclinations.
// [DEon2011]
fn longitudinal(i: vec2f, o: vec2f, v: f32) -> f32 {
    let product = i.y * o.y;
    return exp((product - i.x * o.x - 1.0) / v) * bessel_i0e(product / v) / (v * (1.0 - exp(-2.0 / v)));
}

// Sine and cosine of the inclination of the view direction, shifted for a lobe.
fn turned(fibre: Fibre, lobe: u32, o: vec2f) -> vec2f {
    let s = fibre.turn_sin[lobe];
    let c = fibre.turn_cos[lobe];
    return vec2f(o.x * c + o.y * s, abs(o.y * c - o.x * s));
}

// A layer of the table, bilinearly at `at`, in texels.
fn far_value(fibre: Fibre, layer: u32, at: vec2f) -> vec4f {
    let i = min(vec2u(at), fibre.table_size.xy - 2u);
    let f = at - vec2f(i);
    let first = fibre.table_base + (layer * fibre.table_size.y + i.y) * fibre.table_size.x + i.x;
    let next = first + fibre.table_size.x;
    return mix_bilinear(far_texel(first), far_texel(first + 1u), far_texel(next), far_texel(next + 1u), f);
}

// Albedos of Sadeghi's lobes R, TT, TRT at inclination `theta`, from the table.
fn lobe_albedo(fibre: Fibre, theta: f32) -> vec3f {
    let x = (theta * FRAC_1_PI + 0.5) * f32(fibre.table_size.x - 1u);
    let i = min(u32(max(x, 0.0)), fibre.table_size.x - 2u);
    return mix(far_texel(fibre.table_base + i), far_texel(fibre.table_base + i + 1u), x - f32(i)).xyz;
}

// Far field averaged over the offset across the fibre: azimuthal functions from the table,
// longitudinal ones evaluated. `i`, `o`: sine and cosine of the inclinations. [Chiang2016],
// [Yan2017]
fn scatter_table(model: u32, fibre: Fibre, i: vec2f, o: vec2f, phi: f32, tint: vec3f) -> vec3f {
    let size = vec2f(fibre.table_size.xy) - 1.0;
    let medulla = model == MODEL_MEDULLA;
    let layers = fibre.table_size.z - select(0u, 1u, medulla);
    let y = asin(min(abs(o.x), 1.0)) * FRAC_2_PI * size.y;
    let at = vec2f(phi * FRAC_1_PI * size.x, y);
    var m = vec4f(0.0, longitudinal(i, turned(fibre, 1u, o), fibre.variance.y),
        longitudinal(i, turned(fibre, 2u, o), fibre.variance.z), 0.0);
    if medulla {
        // R lies on the cone of the tilted surface.
        let cos_half = cos(0.5 * phi);
        let u = cos_half * fibre.turn_cos.x * o.y + fibre.turn_sin.x * o.x;
        let sin_r = clamp(o.x - 2.0 * fibre.turn_sin.x * u, -1.0, 1.0);
        let variance_r = max(fibre.variance.x * cos_half * cos_half, 1e-4);
        m.x = longitudinal(i, vec2f(sin_r, sqrt(1.0 - sin_r * sin_r)), variance_r);
        let x = select(i.x, -i.x, o.x < 0.0) * 0.5 + 0.5;
        m.w = far_value(fibre, layers, vec2f(x * size.x, y)).x;
    } else {
        m.x = longitudinal(i, turned(fibre, 0u, o), fibre.variance.x);
        m.w = longitudinal(i, o, fibre.variance.w);
    }
    var sigma = fibre.absorption;
    if fibre.divisor > 0.0 {
        let quotient = log(clamp(tint, vec3f(1e-3), vec3f(1.0))) / fibre.divisor;
        sigma = quotient * quotient;
    }
    // The table's layers are spaced by the transmittance over a path of one diameter.
    let through = exp(-2.0 * sigma) * f32(layers - 1u);
    var color = vec3f(0.0);
    for (var c = 0u; c < 3u; c++) {
        let layer = min(u32(through[c]), layers - 2u);
        let low = far_value(fibre, layer, at);
        let high = far_value(fibre, layer + 1u, at);
        color[c] = dot(mix(low, high, through[c] - f32(layer)), m);
    }
    return color;
}

// Radiance from `l` towards `v` (unit, both point away from the hair) per irradiance, cos(theta_i)
// included. `tint`: colour of the hair; `glint_angle`: azimuth of the strand's glints, radians.
fn scatter_fibre(model: u32, fibre: Fibre, tangent: vec3f, l: vec3f, v: vec3f, tint: vec3f, glint_angle: f32) -> vec3f {
    if model == MODEL_KAJIYA_KAY {
        return kajiya_kay(fibre.diffuse, fibre.specular, fibre.specular_exponent, tangent, l, v) * tint;
    }
    let sin_i = inclination_sine(tangent, l);
    let sin_o = inclination_sine(tangent, v);
    let lp = l - sin_i * tangent;
    let vp = v - sin_o * tangent;
    let cos_phi = clamp(cosine_between(lp, vp), -1.0, 1.0);
    let phi = acos(cos_phi);
    let cos_i = complement(sin_i);
    if model >= MODEL_CHIANG {
        let cos_o = complement(sin_o);
        return scatter_table(model, fibre, vec2f(sin_i, cos_i), vec2f(sin_o, cos_o), phi, tint);
    }
    // Single scattering R, TT, TRT plus the Kajiya-Kay diffuse term. [Sadeghi2010]
    let theta_i = asin(sin_i);
    let theta_o = asin(sin_o);
    let half_sum = 0.5 * (theta_i + theta_o);
    let cos_d = cos(0.5 * (theta_o - theta_i));
    let m_r = unit_gaussian(half_sum - fibre.shift.x, fibre.width.x);
    let m_tt = unit_gaussian(half_sum - fibre.shift.y, fibre.width.y);
    let m_trt = unit_gaussian(half_sum - fibre.shift.z, fibre.width.z);
    let n_r = cos(0.5 * phi);
    let n_tt = unit_gaussian(PI - phi, fibre.azimuth_tt);
    let n_g = fibre.glint * unit_gaussian(glint_angle - phi, fibre.glint_width);
    let single = fibre.intensity.x * m_r * n_r
        + fibre.intensity.y * m_tt * n_tt * tint
        + fibre.intensity.z * m_trt * (n_r + n_g) * tint * tint;
    let scattered = cos_i * (single / max(cos_d * cos_d, 0.05) + fibre.diffuse * FRAC_1_PI_SQUARED * tint);
    if model == MODEL_SADEGHI_NORMALISED {
        let of_i = lobe_albedo(fibre, theta_i);
        let of_o = lobe_albedo(fibre, theta_o);
        let albedo_i = of_i.x + tint * (of_i.y + fibre.diffuse + tint * of_i.z);
        let albedo_o = of_o.x + tint * (of_o.y + fibre.diffuse + tint * of_o.z);
        return scattered / max(max(albedo_i, albedo_o), vec3f(1.0));
    }
    return scattered;
}
