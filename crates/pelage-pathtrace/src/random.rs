//! Random numbers of a sample, which depend on pixel, sample and dimension alone.

use pelage_fur::random::{hash2, random};

/// Sets of four numbers of a sample that come from the Sobol sequence; later sets are independent
/// random numbers.
const SOBOL_SETS: u32 = 24;

/// The numbers of one sample, four at a time.
///
/// Each half of the samples consists of the points of an Owen-scrambled Sobol sequence of its own:
/// the halves are independent of each other, and each is evenly spread.
// [Burley2020]
#[derive(Debug, Clone, Copy)]
pub struct Numbers {
    seed: u32,
    index: u32,
    set: u32,
}

impl Numbers {
    /// The numbers of sample `index` of a pixel. Even samples are the first half, odd ones the
    /// second.
    pub fn new(seed: u32, pixel: u32, index: u32) -> Self {
        // The sequence has 2^16 points; then another begins.
        let sequence = (index & 1) | ((index >> 17) << 1);
        Self { seed: hash2(hash2(seed, pixel), sequence), index: (index >> 1) & 0xffff, set: 0 }
    }

    /// The next four numbers, in 0..1.
    #[inline]
    pub fn four(&mut self) -> [f32; 4] {
        let set = self.set;
        self.set += 1;
        if set < SOBOL_SETS {
            return sobol_burley::sample_4d(self.index, set, self.seed);
        }
        let seed = hash2(self.seed, self.index);
        [0, 1, 2, 3].map(|k| random(seed, 4 * set + k))
    }

    /// A random word for decisions along a ray.
    #[inline]
    pub fn word(&self) -> u32 {
        hash2(hash2(self.seed, !self.index), self.set)
    }
}
