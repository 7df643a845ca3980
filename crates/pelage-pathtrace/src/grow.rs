//! Grows the strands of a world without a GPU: the guard hairs that the renderer draws, and the
//! undercoat's volume realised as hairs.

use super::guard;
use super::memory::gib;
pub use super::patch::Patch;
use super::patch::even_lambda;
use super::strands::{Hair, Strands};
use super::undercoat::Grower;
use glam::Vec4;
use pelage_core::{Error, Result, World};
use pelage_fur::groom;
use pelage_fur::groom::PackedGroom;
use pelage_fur::shell::Shell;
use pelage_fur::shell_prisms::shell_of;

/// What to grow.
#[derive(Debug, Clone, PartialEq)]
pub struct GrowOptions {
    /// Only hairs with their roots in this ball; all hairs without one.
    pub patch: Option<Patch>,
    /// Segments of an undercoat hair, 1..=64. Guard hairs have as many as the scene says.
    pub undercoat_segments: u32,
}

impl Default for GrowOptions {
    fn default() -> Self {
        Self { patch: None, undercoat_segments: 10 }
    }
}

impl GrowOptions {
    fn check(&self) -> Result<()> {
        if !(1..=64).contains(&self.undercoat_segments) {
            return Err(Error::Usage(format!(
                "found {} segments for an undercoat hair, expected 1 to 64",
                self.undercoat_segments
            )));
        }
        match self.patch {
            Some(p) if !(p.centre.is_finite() && p.radius.is_finite() && p.radius > 0.0) => {
                Err(Error::Usage(format!(
                    "found a patch of radius {} cm at {}, expected finite numbers and a radius above 0",
                    p.radius, p.centre
                )))
            }
            _ => Ok(()),
        }
    }
}

/// How many hairs [`grow`] will make, within a few per cent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Estimate {
    /// Guard hairs; there are fewer where a map thins them out.
    pub guard_hairs: u64,
    /// Undercoat hairs that have any segment.
    pub undercoat_hairs: u64,
    /// Segments of all hairs, including absent ones of the undercoat.
    pub segments: u64,
    /// Memory of points and hairs, bytes. While they grow, up to twice as much is in use.
    pub bytes: u64,
}

impl Estimate {
    /// Adds `hairs` of `segments` each.
    fn add(&mut self, hairs: u64, segments: u64) {
        let each = (segments + 1) * size_of::<Vec4>() as u64 + size_of::<Hair>() as u64;
        self.segments = self.segments.saturating_add(hairs.saturating_mul(segments));
        self.bytes = self.bytes.saturating_add(hairs.saturating_mul(each));
    }

    /// Checks that the hairs take at most `budget` bytes.
    ///
    /// # Errors
    /// [`Error::Usage`] with the numbers and what to do otherwise.
    pub fn check(&self, budget: u64) -> Result<()> {
        if self.bytes <= budget {
            return Ok(());
        }
        Err(Error::Usage(format!(
            "found {} guard hairs and {} undercoat hairs, which take about {:.2} GiB as strands, expected at most {:.2} GiB: \
             choose a patch, lower guard.density or undercoat.density, or allow more memory",
            self.guard_hairs,
            self.undercoat_hairs,
            gib(self.bytes),
            gib(budget)
        )))
    }
}

/// Estimates what [`grow`] will make, from areas, densities and a sample of the hairs; the time
/// does not depend on their number.
///
/// # Errors
/// [`Error::Usage`] for options out of range; as [`groom::pack`].
pub fn estimate(world: &World, options: &GrowOptions) -> Result<Estimate> {
    options.check()?;
    let packed = groom::pack(world)?;
    let shell = shell_of(world, &packed);
    let areas: Vec<f64> = (0..shell.prisms.len() as u32)
        .map(|prism| {
            let area = f64::from(world.skin.triangle_area(prism as usize));
            area * options.patch.map_or(1.0, |p| p.share(&shell, prism))
        })
        .collect();
    let area: f64 = areas.iter().sum();
    let mut estimate = Estimate::default();
    if groom::has_guard(&world.scene) {
        estimate.guard_hairs = (area * f64::from(groom::guard_density(&world.scene))).ceil() as u64;
        estimate.add(estimate.guard_hairs, u64::from(packed.groom.segments));
    }
    if groom::has_undercoat(&world.scene) {
        let grower = grower(world, &packed, &shell, options);
        let hairs = area * grower.candidate_density() * survivors(&grower, &areas, area);
        estimate.undercoat_hairs = hairs.ceil() as u64;
        estimate.add(estimate.undercoat_hairs, u64::from(options.undercoat_segments));
    }
    Ok(estimate)
}

/// Share of the undercoat's candidates that grow, from a sample that is uniform over the area.
fn survivors(grower: &Grower<'_>, areas: &[f64], area: f64) -> f64 {
    const SAMPLE: u32 = 2048;
    if area <= 0.0 {
        return 0.0;
    }
    let (mut prism, mut passed) = (0, 0.0);
    let mut grown = 0;
    for k in 0..SAMPLE {
        let wanted = (f64::from(k) + 0.5) / f64::from(SAMPLE) * area;
        while prism + 1 < areas.len() && passed + areas[prism] < wanted {
            passed += areas[prism];
            prism += 1;
        }
        let mut points = Vec::new();
        grown += u32::from(grower.hair_at(prism as u32, even_lambda(k), k, &mut points).is_some());
    }
    f64::from(grown) / f64::from(SAMPLE)
}

fn grower<'a>(world: &World, packed: &'a PackedGroom, shell: &'a Shell, options: &GrowOptions) -> Grower<'a> {
    Grower::new(world, packed, shell, options.undercoat_segments, options.patch)
}

/// Grows the hairs of every layer that the scene renders: guard hairs, then undercoat. The result
/// does not depend on the number of threads.
///
/// # Errors
/// [`Error::Usage`] for options out of range; as [`groom::pack`].
pub fn grow(world: &World, options: &GrowOptions) -> Result<Vec<Strands>> {
    options.check()?;
    let packed = groom::pack(world)?;
    let shell = shell_of(world, &packed);
    let mut layers = Vec::new();
    if groom::has_guard(&world.scene) {
        let (density, seed) = (groom::guard_density(&world.scene), world.scene.render.seed);
        layers.push(guard::grow(&shell, &packed, density, seed, options.patch.as_ref()));
    }
    if groom::has_undercoat(&world.scene) {
        layers.push(grower(world, &packed, &shell, options).grow());
    }
    Ok(layers)
}
