//! Twin of `shaders/hair_roots.wgsl`: hair roots, distributed by area and thinned by a density map.
// [VanGelderWilhelms1997]

use crate::layout::Root;
use crate::parameters::{Maps, Parameter, skin_point};
use crate::random::{even_barycentric, hash2, r2, random};
use crate::shell::Shell;
use glam::{Vec2, Vec3};

/// Candidates of a part of a triangle, which one invocation of the pass draws. Each part has its
/// own seed for places and thinning.
pub const PART: u32 = 16384;

/// Generates the roots of a skin.
#[derive(Clone, Copy)]
pub struct Roots<'a> {
    /// The prism shell over the skin.
    pub shell: &'a Shell,
    /// Groom and maps.
    pub maps: Maps<'a>,
    /// Largest density, hairs/cm².
    pub density: f32,
    /// Seed of the rendering.
    pub seed: u32,
}

impl Roots<'_> {
    /// Expected number of candidates on a triangle: its area times the largest density.
    pub fn expected(&self, prism: u32) -> f32 {
        let place = self.shell.enter(prism);
        0.5 * place.e1.cross(place.e2).length() * self.density
    }

    /// Number of candidates on a triangle before thinning, [`Roots::expected`] on average.
    pub fn candidates(&self, prism: u32) -> u32 {
        (self.expected(prism) + random(hash2(self.seed, prism), 0)) as u32
    }

    /// Seed of the part of the k-th candidate. The first part has that of the triangle.
    fn part_seed(&self, prism: u32, k: u32) -> u32 {
        let seed = hash2(self.seed, prism);
        if k < PART { seed } else { hash2(!seed, k / PART) }
    }

    /// Barycentric coordinates of the k-th candidate, evenly distributed over the triangle.
    // [Roberts2018], [Turk1990]
    pub fn candidate(&self, prism: u32, k: u32) -> Vec3 {
        let seed = self.part_seed(prism, k);
        let start = Vec2::new(random(seed, 1), random(seed, 2));
        even_barycentric(r2(start, k % PART))
    }

    /// Whether the k-th candidate survives thinning by the density map.
    pub fn grows(&self, prism: u32, k: u32) -> bool {
        let at = skin_point(self.shell, prism, self.candidate(prism, k));
        let wanted = self.maps.scalar(Parameter::GuardDensity, &at);
        random(self.part_seed(prism, k), 3 + k % PART) * self.density < wanted
    }

    /// The roots on a triangle.
    pub fn of(&self, prism: u32) -> Vec<Root> {
        (0..self.candidates(prism))
            .filter(|k| self.grows(prism, *k))
            .map(|k| {
                let lambda = self.candidate(prism, k);
                let seed = hash2(hash2(self.seed, prism), 0x10000 + k);
                Root { prism, seed, lambda: [lambda.y, lambda.z] }
            })
            .collect()
    }
}
