//! Twin of `shaders/undercoat_march.wgsl`, `shared/march.wgsl` and `shared/phase.wgsl`: the march
//! through the undercoat and the fragments that it stores.
// [Andersen2016] sec. 3.2 and 3.3

use crate::twin::film::halves;
use crate::twin::lattice;
use crate::twin::lattice::unpack_albedo;
use glam::{Vec3, Vec4};
use pelage_fur::camera::FLAG_MARCH_JITTER;
use pelage_fur::fibre::Fibre;
use pelage_fur::layout::{Frame, FurParameters};
use pelage_fur::shell::{Located, Place};
use pelage_fur::undercoat::{Medium, Undercoat, color, extinction, scatter};

/// Length of a ray's first step, in steps.
// [Jimenez2014]
pub fn first_phase(frame: &Frame, xy: [u32; 2]) -> f32 {
    if frame.flags & FLAG_MARCH_JITTER == 0 {
        return 1.0;
    }
    let at = |k: usize| (frame.tile_origin[k] + xy[k] as i32 + 4096) as f32;
    let turn = 52.982_92 * (at(0) * 0.067_110_56 + at(1) * 0.005_837_15).fract();
    0.05 + 0.95 * (turn + (frame.seed & 1023) as f32 * 0.618_034).fract()
}

/// Inputs of a march.
#[derive(Clone, Copy)]
pub struct MarchInputs<'a> {
    /// Parameters of undercoat, lattice and lights.
    pub fur: &'a FurParameters,
    /// The undercoat's medium.
    pub undercoat: Undercoat<'a>,
    /// Light at the nodes of the lattice, the buffer `node_light`.
    pub source: &'a [[u32; 4]],
    /// The frame globals.
    pub frame: &'a Frame,
    /// Fibre model of the undercoat.
    pub undercoat_fibre: &'a Fibre,
}

/// A step of the march: a part of a ray with constant medium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Depth at which it begins, cm.
    pub z: f32,
    /// Depth at which it ends, cm.
    pub z_end: f32,
    /// Extinction per cm of depth.
    pub sigma: f32,
    /// Source radiance.
    pub radiance: Vec3,
    /// Place at which the medium was read.
    pub place: Place,
}

/// The steps of a ray (forward component 1) that enters the shell through `prism` at depth `z`,
/// until it leaves the shell, and whether the ray was lost. `phase`: length of the first step, in
/// steps.
pub fn steps(inputs: &MarchInputs<'_>, ray: Vec3, prism: u32, z: f32, phase: f32) -> (Vec<Step>, bool) {
    let fur = inputs.fur;
    let shell = inputs.undercoat.shell;
    let speed = ray.length();
    let view = -ray / speed;
    let mut place = Place { t: 1.0, ..shell.enter(prism) };
    let mut steps = Vec::new();
    let mut z = z;
    let mut dz = fur.undercoat.step / speed * phase;
    loop {
        let z_mid = z + 0.5 * dz;
        let x = Vec3::from(inputs.frame.eye) + z_mid * ray;
        let found = shell.locate(&mut place, x, ray, if steps.is_empty() { 4 } else { 2 });
        if found != Located::Inside {
            return (steps, found == Located::Lost);
        }
        let (t, slope) = (place.t, place.dt_dz);
        let mut z_end = z + dz;
        let mut last = false;
        // By rounding, the start of a descending ray may lie slightly above the top.
        let starting = t > 1.0 && slope <= 0.0 && t <= 1.0 - slope * dz;
        if (t > 1.0 && !starting) || t < 0.0 {
            let beyond = if t > 1.0 { t - 1.0 } else { t };
            z_end = z_mid - beyond / slope;
            if beyond * slope <= 0.0 || z_end <= z {
                return (steps, false);
            }
            place.t = t.clamp(0.0, 1.0);
            last = true;
        } else if slope > 0.0 && t + 0.5 * dz * slope > 1.0 {
            z_end = z_mid + (1.0 - t) / slope;
            last = true;
        }
        let medium = inputs.undercoat.at(&place);
        let (radiance, density) = source_radiance(inputs, &place, medium, view);
        let sigma = extinction(&fur.undercoat, medium, view) * density * speed;
        steps.push(Step { z, z_end, sigma, radiance, place });
        if last {
            return (steps, false);
        }
        z = z_end;
        dz = fur.undercoat.step / speed;
    }
}

/// Light at a place, interpolated between the nodes of the lattice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lookup {
    /// Scattered radiance per extinction, of all lights except the key lights and of multiple
    /// scattering; to be multiplied by [`color`].
    pub ambient: Vec3,
    /// Optical depths towards the two key lights.
    pub tau: [f32; 2],
    /// Single-scattering albedo.
    pub albedo: Vec3,
    /// Density of the undercoat on the skin below, relative to that in `fur.undercoat.extinction`.
    pub density: f32,
}

/// Interpolates the light at the nodes; the ambient radiance by its logarithm.
pub fn look_up(inputs: &MarchInputs<'_>, place: &Place) -> Lookup {
    let fur = inputs.fur;
    let cell = lattice::cell(fur, place);
    let (mut ambient, mut tau, mut albedo) = (Vec4::ZERO, [0f32; 2], Vec3::ZERO);
    for (k, level) in (0..3).flat_map(|k| [(k, 0), (k, 1)]) {
        let part = if level == 0 { 1.0 - cell.fraction } else { cell.fraction };
        let w = cell.weights[k] * part;
        let words = inputs.source[lattice::node_index(fur, cell.columns[k], cell.level + level) as usize];
        let [r, g] = halves(words[0]);
        let [b, density] = halves(words[1]);
        ambient += w * Vec4::new(r, g, b, density);
        tau.iter_mut().zip(halves(words[2])).for_each(|(sum, tau)| *sum += w * tau);
        albedo += w * unpack_albedo(words[3]);
    }
    let ambient_rgb = Vec3::from(ambient.truncate().to_array().map(f32::exp2));
    Lookup { ambient: ambient_rgb, tau, albedo, density: ambient.w }
}

/// Radiance that the medium scatters towards the unit direction `view` per extinction, and the
/// density factor of the skin below.
pub fn source_radiance(inputs: &MarchInputs<'_>, place: &Place, m: Medium, view: Vec3) -> (Vec3, f32) {
    let fur = inputs.fur;
    let found = look_up(inputs, place);
    let mut sum = found.ambient;
    for j in 0..fur.lights.keys as usize {
        let l = Vec4::from(fur.lights.key_direction[j]).truncate();
        let through = (-found.tau[j] * (1.0 - fur.undercoat.forward_scattering * found.albedo)).exp();
        let scattered = scatter(inputs.undercoat_fibre, m.tangent, l, view, found.albedo);
        sum += Vec4::from(fur.lights.key_irradiance[j]).truncate() * through * scattered;
    }
    (sum * color(inputs.undercoat_fibre, found.albedo), found.density)
}

/// A fragment of the undercoat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fragment {
    /// Depth, cm.
    pub z: f32,
    /// Premultiplied radiance and opacity.
    pub color: Vec4,
}

/// Fragments that a ray with `entries` (depth, prism; in order) stores in front of the skin at
/// depth `z_base`: one shell fragment per entry, or `fur.undercoat.virtual_fragments` of equal
/// opacity. An interval shared by two entries counts for the first.
pub fn fragments(
    inputs: &MarchInputs<'_>,
    ray: Vec3,
    phase: f32,
    entries: &[(f32, u32)],
    z_base: f32,
) -> Vec<Fragment> {
    let fur = inputs.fur;
    let mut fragments = Vec::new();
    let mut consumed = 0f32;
    for (z_entry, prism) in entries {
        let (steps, _) = steps(inputs, ray, *prism, *z_entry, phase);
        // Parts of the steps that no earlier entry has counted.
        let mut pieces: Vec<(f32, f32, f32, Vec3)> = Vec::new();
        let mut opaque = 0f32;
        let mut reached = *z_entry;
        for s in &steps {
            if (-opaque).exp() <= fur.undercoat.opacity_cut || reached >= z_base {
                break;
            }
            let (from, to) = (s.z.max(consumed), s.z_end.min(z_base));
            reached = s.z_end;
            if to > from {
                pieces.push((from, to, s.sigma, s.radiance));
                opaque += s.sigma * (to - from);
            }
        }
        consumed = consumed.max(reached);
        let n = fur.undercoat.virtual_fragments;
        if n == 0 {
            let whole = blend(&pieces);
            if whole.w > 0.0 {
                fragments.push(Fragment { z: *z_entry, color: whole });
            }
            continue;
        }
        fragments.extend(split(&pieces, n));
    }
    fragments
}

/// Composites pieces (from, to, extinction, radiance) front to back.
// [Max1995]
fn blend(pieces: &[(f32, f32, f32, Vec3)]) -> Vec4 {
    pieces.iter().fold(Vec4::ZERO, |sum, (from, to, sigma, radiance)| {
        let part = 1.0 - (-sigma * (to - from)).exp();
        sum + (1.0 - sum.w) * part * radiance.extend(1.0)
    })
}

/// Splits the pieces where the transmittance of the entry is 1 - k / n. The depth of a fragment is
/// that at which half of its opacity is reached.
// DEVIATION: equal opacities; the paper joins a fixed number of steps. [Andersen2016] sec. 3.3
fn split(pieces: &[(f32, f32, f32, Vec3)], n: u32) -> Vec<Fragment> {
    let mut fragments = Vec::new();
    let mut rest: Vec<_> = pieces.iter().rev().copied().collect();
    for k in 0..n {
        let through = |j: f32| -(1.0 - j / n as f32).ln();
        // Optical depth of this fragment, and to its middle.
        let (depth, middle) =
            (through(k as f32 + 1.0) - through(k as f32), through(k as f32 + 0.5) - through(k as f32));
        let mut taken = Vec::new();
        let mut sum = 0f32;
        let mut z_middle = None;
        while let Some((from, to, sigma, radiance)) = rest.pop() {
            let whole = sigma * (to - from);
            if z_middle.is_none() && sum + whole > middle {
                z_middle = Some(from + (middle - sum) / sigma);
            }
            if sum + whole > depth {
                let cut = from + (depth - sum) / sigma;
                taken.push((from, cut, sigma, radiance));
                rest.push((cut, to, sigma, radiance));
                break;
            }
            sum += whole;
            taken.push((from, to, sigma, radiance));
        }
        let color = blend(&taken);
        if let Some(first) = taken.first().filter(|_| color.w > 0.0) {
            fragments.push(Fragment { z: z_middle.unwrap_or(first.0), color });
        }
    }
    fragments
}
