//! The scene's groom on a torus: guard hairs and undercoat.

use super::guard::GuardFur;
use super::means::SkinSamples;
use super::strand::{Hair, HairSource};
use super::undercoat::UndercoatFur;
use glam::Vec3;
use pelage_core::scene::FurLayers;
use pelage_core::{Error, Result, World};

/// Largest number of hairs of each kind per texel of a layer; if the patch has more, each
/// represents several.
const HAIRS_A_TEXEL: u32 = 8;

/// Fraction of the guard hairs' length x diameter below the default height; the tips of the longest
/// hairs are left out.
const WITHIN: f64 = 0.99;

/// Both layers of a groom, guard hairs first.
pub(super) struct HybridFur<'a> {
    guard: Option<GuardFur>,
    undercoat: Option<UndercoatFur<'a>>,
}

impl<'a> HybridFur<'a> {
    /// The fur of `world` on a torus of `patch` cm, as far as `render.fur` draws it.
    pub fn new(world: &'a World, patch: f32) -> Result<Self> {
        let scene = &world.scene;
        let means = SkinSamples::new(world);
        let seed = scene.render.seed;
        let texels = scene.bake.resolution.iter().fold(1u32, |n, r| n.saturating_mul(*r));
        let most = texels.saturating_mul(HAIRS_A_TEXEL).clamp(65_536, 1_000_000);
        let combed = Vec3::from(scene.guard.comb_direction).length_squared() > 0.0;
        let guard = (scene.render.fur != FurLayers::Implicit)
            .then(|| GuardFur::new(&means, patch, seed, most))
            .filter(|g| g.count() > 0);
        let undercoat = (scene.render.fur != FurLayers::Explicit)
            .then(|| UndercoatFur::new(&scene.undercoat, &means, patch, combed, seed, most))
            .filter(|c| c.count() > 0);
        if guard.is_none() && undercoat.is_none() {
            let message = "there is no hair to bake: guard hairs and undercoat have no density, no length or are not drawn (render.fur)";
            return Err(Error::fault("bake.source = \"hybrid\"", message));
        }
        Ok(Self { guard, undercoat })
    }

    /// Height that contains the undercoat and all but the tips of the guard hairs, cm.
    pub fn height(&self) -> f32 {
        let undercoat = self.undercoat.as_ref().map_or(0.0, |c| c.height);
        self.guard.as_ref().map_or(0.0, |g| g.height_of(WITHIN)).max(undercoat)
    }

    fn guards(&self) -> u32 {
        self.guard.as_ref().map_or(0, HairSource::count)
    }

    fn pick<T>(
        &self,
        i: u32,
        guard: impl Fn(&GuardFur, u32) -> T,
        undercoat: impl Fn(&UndercoatFur, u32) -> T,
    ) -> Option<T> {
        match (&self.guard, &self.undercoat) {
            (Some(g), _) if i < g.count() => Some(guard(g, i)),
            (_, Some(c)) => Some(undercoat(c, i - self.guards())),
            _ => None,
        }
    }
}

impl HairSource for HybridFur<'_> {
    fn count(&self) -> u32 {
        self.guards() + self.undercoat.as_ref().map_or(0, HairSource::count)
    }

    fn hair(&self, i: u32) -> Hair {
        let none = Hair { root: [0.0; 2], knots: Vec::new(), guard: false };
        self.pick(i, |g, k| g.hair(k), |c, k| c.hair(k)).unwrap_or(none)
    }

    fn root(&self, i: u32) -> [f32; 2] {
        self.pick(i, |g, k| g.root(k), |c, k| c.root(k)).unwrap_or_default()
    }
}
