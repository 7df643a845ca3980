// The material of objects: metallic-roughness with a clear coat, index of refraction 1.5.
// [GLTF2] appendix B, KHR_materials_clearcoat

#import shared/constants

struct Material {
    color: vec3f,     // base colour
    roughness: f32,
    metallic: f32,
    clearcoat: f32,
    clearcoat_roughness: f32,
}

const DIELECTRIC: f32 = 0.04;     // reflectance at normal incidence
// Mean of 1 minus the reflectance of a dielectric, weighted by the cosine.
const ENTERING: f32 = 1.0 - (DIELECTRIC + (1.0 - DIELECTRIC) / 21.0);
const LEAST_ALPHA: f32 = 0.01;    // about the width of the sun's disc: directional lights are points
const LEAST_COSINE: f32 = 1e-3;   // towards the viewer

// Width of a GGX lobe for light from within `spread` (radians of the half vector).
fn lobe_width(roughness: f32, spread: f32) -> f32 {
    let alpha = max(roughness * roughness, LEAST_ALPHA);
    return min(sqrt(alpha * alpha + spread * spread), 1.0);
}

fn grazing(cosine: f32) -> f32 {
    let x = clamp(1.0 - cosine, 0.0, 1.0);
    return x * x * x * x * x;
}

fn dielectric(cosine: f32) -> f32 {
    return DIELECTRIC + (1.0 - DIELECTRIC) * grazing(cosine);
}

// Density of half vectors times masking and shadowing over 4 nl nv.
fn ggx_lobe(nh: f32, nl: f32, nv: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let d = nh * nh * (a2 - 1.0) + 1.0;
    let l = nv * sqrt(nl * nl * (1.0 - a2) + a2);
    let v = nl * sqrt(nv * nv * (1.0 - a2) + a2);
    return a2 / max(PI * d * d, 1e-20) * 0.5 / max(l + v, 1e-10);
}

// Scattering from l to v, 1/sr, without the cosine of incidence. `n`, `v`, `l`: unit, leaving the
// surface.
fn scatter_material(m: Material, n: vec3f, v: vec3f, l: vec3f, spread: f32) -> vec3f {
    let nl = dot(n, l);
    let nv = max(dot(n, v), LEAST_COSINE);
    if nl <= 0.0 {
        return vec3f(0.0);
    }
    let sum = v + l;
    let h = select(n, normalize(sum), dot(sum, sum) > 1e-12);
    let nh = clamp(dot(n, h), 0.0, 1.0);
    let vh = clamp(dot(v, h), 0.0, 1.0);
    let f0 = mix(vec3f(DIELECTRIC), m.color, m.metallic);
    let fresnel = f0 + (1.0 - f0) * grazing(vh);
    let specular = fresnel * ggx_lobe(nh, nl, nv, lobe_width(m.roughness, spread));
    // Light that enters and leaves: coupled to the reflection, so that no energy is made.
    let inside = (1.0 - dielectric(nl)) * (1.0 - dielectric(nv)) / (ENTERING * PI);
    let diffuse = m.color * ((1.0 - m.metallic) * inside);
    let coat = ggx_lobe(nh, nl, nv, lobe_width(m.clearcoat_roughness, spread));
    return mix(diffuse + specular, vec3f(coat), m.clearcoat * dielectric(nv));
}
