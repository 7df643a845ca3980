//! Tables of the light scattered in the medulla, from a Monte Carlo simulation of our own, cached
//! in the user's cache folder.

use crate::fibre::lobes::choose;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::f32::consts::{PI, TAU};
use std::path::{Path, PathBuf};

/// Rows by |sin θ_o|: even steps from 0 to 1.
const THETAS: usize = 8;
/// Rows by offset: even steps from 0 to 1 of the medulla's radius.
const OFFSETS: usize = 16;
/// Azimuths around the full circle.
const AROUND: usize = 72;
/// Values of sin θ_i, even steps from −1 to 1.
const ALONG: usize = 65;
/// Simulated paths per row.
const PATHS: u32 = 48_000;

/// Parameters on which the tables depend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium {
    /// Scattering coefficient, per radius of the medulla.
    pub scattering: f32,
    /// Mean cosine g of the Henyey–Greenstein phase function.
    pub anisotropy: f32,
    /// Index of refraction of the hair.
    pub ior: f32,
}

/// Directional densities of scattered light, and the mean path length of scattered paths.
// [Yan2017]: C_N, C_M and D
#[derive(Debug, Clone, PartialEq)]
pub struct ScatterTable {
    /// Density over the azimuth relative to the direction of entry,
    /// `[inclination][offset][azimuth]`.
    around: Vec<f32>,
    /// Density over the sine of θ_i, `[inclination][sine]`.
    along: Vec<f32>,
    /// Mean path length in units of the medulla's radius, `[inclination][offset]`.
    path_length: Vec<f32>,
}

/// The lower of the two rows to interpolate between, and the weight of the upper; `x` in 0..1.
fn rows(x: f32, count: usize) -> (usize, f32) {
    let x = x.clamp(0.0, 1.0) * (count - 1) as f32;
    let row = (x as usize).min(count - 2);
    (row, x - row as f32)
}

impl ScatterTable {
    const WORDS: usize = THETAS * (OFFSETS * (AROUND + 1) + ALONG);

    /// The tables of `medium`: read from the cache in `folder`, or simulated and then stored there
    /// if possible. A file that is damaged or has other parameters is replaced.
    // [FIPS180-4] for the checksum
    pub fn cached(medium: Medium, folder: Option<&Path>) -> Self {
        let Some(folder) = folder else { return Self::simulate(medium) };
        let key = [medium.scattering, medium.anisotropy, medium.ior].map(f32::to_bits);
        let name = format!("medulla-1-{:08x}{:08x}{:08x}.bin", key[0], key[1], key[2]);
        let path = folder.join(name);
        let head: Vec<u8> =
            b"PELAGEM1".iter().copied().chain(key.iter().flat_map(|k| k.to_le_bytes())).collect();
        if let Some(table) = std::fs::read(&path).ok().and_then(|bytes| Self::unpack(&bytes, &head)) {
            return table;
        }
        let table = Self::simulate(medium);
        let mut bytes = head;
        for x in table.around.iter().chain(&table.along).chain(&table.path_length) {
            bytes.extend(x.to_le_bytes());
        }
        let sum = Sha256::digest(&bytes);
        bytes.extend_from_slice(&sum);
        let stored =
            std::fs::create_dir_all(folder).map_err(|e| pelage_core::Error::io(folder, e)).and_then(|()| {
                pelage_core::files::write_atomically(&path, |file| {
                    Ok(std::io::Write::write_all(file, &bytes)?)
                })
            });
        if let Err(error) = stored {
            tracing::debug!("the medulla's table could not be cached: {error}");
        }
        table
    }

    fn unpack(bytes: &[u8], head: &[u8]) -> Option<Self> {
        let rest = bytes.strip_prefix(head)?;
        let (words, sum) = rest.split_at_checked(4 * Self::WORDS)?;
        if Sha256::digest(&bytes[..head.len() + words.len()]).as_slice() != sum {
            return None;
        }
        let all: Vec<f32> = words.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        let (around, rest) = all.split_at(THETAS * OFFSETS * AROUND);
        let (along, path_length) = rest.split_at(THETAS * ALONG);
        Some(Self { around: around.to_vec(), along: along.to_vec(), path_length: path_length.to_vec() })
    }

    /// Simulates paths that are scattered at least once. Every row has its own random numbers, so
    /// that the result is reproducible.
    pub fn simulate(medium: Medium) -> Self {
        let cells: Vec<Cell> = (0..THETAS * OFFSETS)
            .into_par_iter()
            .map(|i| simulate_cell(medium, i / OFFSETS, i % OFFSETS))
            .collect();
        let mut table = Self { around: Vec::new(), along: Vec::new(), path_length: Vec::new() };
        for rows in cells.chunks(OFFSETS) {
            let mut along = vec![0.0; ALONG];
            let mut whole = 0.0;
            for cell in rows {
                table.around.extend(cell.around.iter().map(|n| n / PATHS as f32 * AROUND as f32 / TAU));
                table.path_length.push(cell.path_length / PATHS as f32);
                whole += cell.probability;
                // Rows are weighted by their probability of scattering.
                along.iter_mut().zip(&cell.along).for_each(|(sum, n)| *sum += cell.probability * n);
            }
            let step = 2.0 / (ALONG - 1) as f32;
            table.along.extend(along.iter().enumerate().map(|(k, n)| {
                let area = if k == 0 || k == ALONG - 1 { 0.5 * step } else { step };
                n / (PATHS as f32 * whole.max(1e-9) * area)
            }));
        }
        table
    }

    fn node(theta: usize, offset: usize) -> usize {
        theta * OFFSETS + offset
    }

    /// Density of the azimuth `psi` relative to the direction of entry, for a sine of θ_o and an
    /// offset in −1..1.
    pub fn around(&self, sin_o: f32, offset: f32, psi: f32) -> f32 {
        let psi = if offset < 0.0 { -psi } else { psi };
        let ((t, tw), (k, kw)) = (rows(sin_o.abs(), THETAS), rows(offset.abs(), OFFSETS));
        let x = (psi / TAU + 1.0) * AROUND as f32;
        let (cell, f) = (x.floor() as usize, x.fract());
        let at = |t: usize, k: usize| {
            let row = &self.around[Self::node(t, k) * AROUND..][..AROUND];
            row[cell % AROUND] * (1.0 - f) + row[(cell + 1) % AROUND] * f
        };
        (1.0 - tw) * ((1.0 - kw) * at(t, k) + kw * at(t, k + 1))
            + tw * ((1.0 - kw) * at(t + 1, k) + kw * at(t + 1, k + 1))
    }

    /// Samples an azimuth from [`ScatterTable::around`].
    pub fn sample_around(&self, sin_o: f32, offset: f32, u: [f32; 2]) -> f32 {
        let ((t, tw), (k, kw)) = (rows(sin_o.abs(), THETAS), rows(offset.abs(), OFFSETS));
        let (t_next, rest) = choose(&[1.0 - tw, tw], u[0]);
        let (k_next, _) = choose(&[1.0 - kw, kw], rest);
        let row = &self.around[Self::node(t + t_next, k + k_next) * AROUND..][..AROUND];
        let (cell, rest) = choose(row, u[1]);
        let psi = (cell as f32 + tent(rest)) * TAU / AROUND as f32;
        if offset < 0.0 { -psi } else { psi }
    }

    /// Density of the sine of θ_i for a sine of θ_o.
    pub fn along(&self, sin_o: f32, sin_i: f32) -> f32 {
        let sin_i = if sin_o < 0.0 { -sin_i } else { sin_i };
        let ((t, tw), (k, kw)) = (rows(sin_o.abs(), THETAS), rows(0.5 * sin_i + 0.5, ALONG));
        let at = |t: usize| {
            let row = &self.along[t * ALONG..][..ALONG];
            row[k] * (1.0 - kw) + row[k + 1] * kw
        };
        at(t) * (1.0 - tw) + at(t + 1) * tw
    }

    /// Samples a sine from [`ScatterTable::along`].
    pub fn sample_along(&self, sin_o: f32, u: [f32; 2]) -> f32 {
        let (t, tw) = rows(sin_o.abs(), THETAS);
        let (next, rest) = choose(&[1.0 - tw, tw], u[0]);
        let row = &self.along[(t + next) * ALONG..][..ALONG];
        let ends = [0, ALONG - 1];
        let weights: [f32; ALONG] =
            std::array::from_fn(|k| if ends.contains(&k) { 0.5 * row[k] } else { row[k] });
        let (k, _) = choose(&weights, rest);
        let offset = tent(u[1]);
        let at = match k {
            0 => offset.abs(),
            k if k == ends[1] => k as f32 - offset.abs(),
            k => k as f32 + offset,
        };
        let sin = (at / (ALONG - 1) as f32 * 2.0 - 1.0).clamp(-1.0, 1.0);
        if sin_o < 0.0 { -sin } else { sin }
    }

    /// Mean path length in the medulla, in units of its radius.
    pub fn path_length(&self, sin_o: f32, offset: f32) -> f32 {
        let ((t, tw), (k, kw)) = (rows(sin_o.abs(), THETAS), rows(offset.abs(), OFFSETS));
        let at = |t: usize| {
            self.path_length[Self::node(t, k)] * (1.0 - kw) + self.path_length[Self::node(t, k + 1)] * kw
        };
        at(t) * (1.0 - tw) + at(t + 1) * tw
    }
}

/// The user's cache folder: `$XDG_CACHE_HOME/pelage` or `~/.cache/pelage`.
pub fn cache_folder() -> Option<PathBuf> {
    let absolute = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
    let base = absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")))?;
    Some(base.join("pelage"))
}

/// Samples the triangular density on −1..1.
fn tent(u: f32) -> f32 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).max(0.0).sqrt() }
}

/// Counts of one row. Each exit is shared linearly by the two nearest cells.
struct Cell {
    around: Vec<f32>,
    along: Vec<f32>,
    path_length: f32,
    /// Probability that a pass is scattered.
    probability: f32,
}

struct Random(u64);

impl Random {
    /// Uniform in [0, 1) by splitmix64.
    // [Steele2014]
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// Internal reflections after which a path is let out.
const MOST_BOUNCES: u32 = 200;

fn simulate_cell(medium: Medium, theta: usize, offset: usize) -> Cell {
    let mut random = Random((theta * OFFSETS + offset) as u64 + 1);
    let sigma = medium.scattering.max(1e-4);
    let axial = -(theta as f32 / (THETAS - 1) as f32) / medium.ior;
    let across = (1.0 - axial * axial).sqrt();
    let h = (offset as f32 / (OFFSETS - 1) as f32).min(0.999);
    let half = (1.0 - h * h).sqrt();
    let chord = 2.0 * half / across;
    let probability = -(-sigma * chord).exp_m1();
    let mut cell = Cell { around: vec![0.0; AROUND], along: vec![0.0; ALONG], path_length: 0.0, probability };
    for _ in 0..PATHS {
        // Position across the fibre; direction: axial component, then the two across.
        let mut p = [-half, h];
        let mut d = [axial, across, 0.0];
        let mut free = (-(-random.next() * probability).ln_1p() / sigma).min(0.9999 * chord);
        let mut bounces = 0;
        loop {
            // Distance to the surface.
            let a = d[1] * d[1] + d[2] * d[2];
            let b = p[0] * d[1] + p[1] * d[2];
            let c = p[0] * p[0] + p[1] * p[1] - 1.0;
            let out = ((b * b - a * c).max(0.0).sqrt() - b) / a.max(1e-9);
            if free < out {
                cell.path_length += free;
                p = [p[0] + free * d[1], p[1] + free * d[2]];
                d = turn(d, medium.anisotropy, [random.next(), random.next()]);
                free = -(1.0 - random.next()).ln() / sigma;
                continue;
            }
            cell.path_length += out;
            p = [p[0] + out * d[1], p[1] + out * d[2]];
            let sin = medium.ior * d[0];
            bounces += 1;
            if sin.abs() <= 1.0 || bounces > MOST_BOUNCES {
                share(&mut cell.along, (0.5 * sin.clamp(-1.0, 1.0) + 0.5) * (ALONG - 1) as f32, false);
                let psi = d[2].atan2(d[1]) / TAU + 1.0;
                share(&mut cell.around, psi * AROUND as f32, true);
                break;
            }
            // DEVIATION: [Yan2017] lets light leave at any inclination; beyond the critical angle
            // it is reflected and guided within the hair.
            free -= out;
            let normal = p[0] * d[1] + p[1] * d[2];
            d = [d[0], d[1] - 2.0 * normal * p[0], d[2] - 2.0 * normal * p[1]];
            p = p.map(|x| 0.9999 * x);
        }
    }
    cell
}

/// Adds 1 at position `x`, shared linearly by the two nearest cells.
fn share(cells: &mut [f32], x: f32, wraps: bool) {
    let (k, f) = (x.floor() as usize, x.fract());
    let at = |k: usize| if wraps { k % cells.len() } else { k.min(cells.len() - 1) };
    let (low, high) = (at(k), at(k + 1));
    cells[low] += 1.0 - f;
    cells[high] += f;
}

/// Direction `d`, deflected by an angle sampled from the Henyey–Greenstein phase function.
// [HenyeyGreenstein1941], [Pharr2023]
fn turn(d: [f32; 3], g: f32, u: [f32; 2]) -> [f32; 3] {
    let cos = if g.abs() < 1e-3 {
        1.0 - 2.0 * u[0]
    } else {
        let s = (1.0 - g * g) / (1.0 + g - 2.0 * g * u[0]);
        ((1.0 + g * g - s * s) / (2.0 * g)).clamp(-1.0, 1.0)
    };
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (y, x) = (2.0 * PI * u[1]).sin_cos();
    let w = glam::Vec3::from(d);
    let (a, b) = w.any_orthonormal_pair();
    (sin * x * a + sin * y * b + cos * w).normalize().into()
}
