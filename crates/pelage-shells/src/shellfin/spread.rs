//! The same fur in more and thinner layers than were baked.

use crate::bake::{FurTextures, LayerSummary, Manifest, Texture};
use rayon::prelude::*;

/// `textures` as `layers` layers of the same total height. Each new layer holds the slices of the
/// old ones that lie in its slab: a slice of a part of a layer's thickness has that part of its
/// optical depth, so its transmittance is raised to that power. So the fur looks the same along the
/// normal, and seen at a slant its hairs are divided less.
///
/// Layers that are opaque stay so, however thin.
pub fn spread(textures: &FurTextures, layers: u32) -> FurTextures {
    let old = textures.layers.len() as f64;
    let slices = |layer: u32| {
        let edge = |l: u32| f64::from(l) * old / f64::from(layers);
        let (from, to) = (edge(layer), edge(layer + 1));
        let last = (to.ceil() as usize).min(textures.layers.len());
        (from as usize..last)
            .map(move |k| (k, ((to.min(k as f64 + 1.0) - from.max(k as f64)) as f32).clamp(0.0, 1.0)))
            .filter(|(_, part)| *part > 1e-6)
            .collect::<Vec<_>>()
    };
    let of = |parts: &[Texture]| -> Vec<Texture> {
        if parts.is_empty() {
            return Vec::new();
        }
        (0..layers).into_par_iter().map(|l| composite(parts, &textures.layers, &slices(l))).collect()
    };
    let manifest = &textures.manifest;
    let summary = (0..layers).map(|l| summary(&manifest.summary, &slices(l))).collect();
    FurTextures {
        layers: of(&textures.layers),
        guard: of(&textures.guard),
        fin: textures.fin.clone(),
        fin_guard: textures.fin_guard.clone(),
        manifest: Manifest { layers, spacing: manifest.height / layers as f32, summary, ..manifest.clone() },
    }
}

/// The slices of `parts`, innermost first, each seen through those of the whole `layers` above it.
// [PorterDuff1984] over
fn composite(parts: &[Texture], layers: &[Texture], slices: &[(usize, f32)]) -> Texture {
    let [first, ..] = slices else { return Texture::default() };
    let mut texels = vec![[0.0f32; 4]; parts[first.0].texels.len()];
    for (layer, part) in slices {
        for (texel, (own, whole)) in
            texels.iter_mut().zip(parts[*layer].texels.iter().zip(&layers[*layer].texels))
        {
            let coverage = 1.0 - (1.0 - whole[3]).max(0.0).powf(*part);
            let factor = if whole[3] > 1e-6 { coverage / whole[3] } else { *part };
            (0..4).for_each(|k| texel[k] = own[k] * factor + (1.0 - coverage) * texel[k]);
        }
    }
    Texture { texels, ..parts[first.0] }
}

fn summary(all: &[LayerSummary], slices: &[(usize, f32)]) -> LayerSummary {
    let (mut depth, mut through, mut color) = (0.0, 1.0, [0.0f32; 3]);
    for (layer, part) in slices {
        let Some(of) = all.get(*layer) else { continue };
        depth += of.optical_depth * part;
        through *= (1.0 - of.coverage).max(0.0).powf(*part);
        (0..3).for_each(|k| color[k] += of.color[k] * part);
    }
    let parts: f32 = slices.iter().map(|(_, part)| part).sum();
    LayerSummary { coverage: 1.0 - through, optical_depth: depth, color: color.map(|c| c / parts.max(1e-6)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two layers of one texel, with guard hair in half of the outer one.
    fn two() -> FurTextures {
        let texture = |texel: [f32; 4]| Texture { width: 1, height: 1, texels: vec![texel] };
        let summary =
            |coverage: f32| LayerSummary { coverage, optical_depth: -(1.0 - coverage).ln(), color: [0.5; 3] };
        FurTextures {
            layers: vec![texture([0.3, 0.2, 0.1, 0.6]), texture([0.2, 0.2, 0.2, 0.4])],
            guard: vec![texture([0.0; 4]), texture([0.1, 0.1, 0.1, 0.2])],
            fin: Texture::default(),
            fin_guard: Texture::default(),
            manifest: Manifest {
                version: 1,
                generator: String::new(),
                source: pelage_core::scene::BakeSource::Hybrid,
                seed: 0,
                layers: 2,
                resolution: [1; 2],
                fin_resolution: [4; 2],
                patch: [1.0; 2],
                fin_length: 1.0,
                fin_depth: 0.1,
                height: 1.2,
                spacing: 0.6,
                summary: vec![summary(0.6), summary(0.4)],
            },
        }
    }

    /// All layers over each other: the layers themselves, or the guard hairs' part.
    fn seen(textures: &FurTextures, parts: &[Texture]) -> [f32; 4] {
        let mut sum = [0.0f32; 4];
        for (own, whole) in parts.iter().zip(&textures.layers) {
            let through = 1.0 - whole.texels[0][3];
            (0..4).for_each(|k| sum[k] = own.texels[0][k] + through * sum[k]);
        }
        sum
    }

    #[test]
    fn more_layers_look_the_same_along_the_normal() {
        let two = two();
        for n in [3, 6, 7] {
            let many = spread(&two, n);
            assert_eq!((many.layers.len(), many.guard.len()), (n as usize, n as usize));
            assert_eq!((many.manifest.layers, many.manifest.height), (n, 1.2));
            assert!((many.manifest.spacing * n as f32 - 1.2).abs() < 1e-6);
            let pairs = [(&two.layers, &many.layers), (&two.guard, &many.guard)];
            for (before, after) in pairs {
                let (a, b) = (seen(&two, before), seen(&many, after));
                assert!((0..4).all(|k| (a[k] - b[k]).abs() < 1e-5), "{n}: {a:?} {b:?}");
            }
            let depth = |t: &FurTextures| t.manifest.summary.iter().map(|s| s.optical_depth).sum::<f32>();
            assert!((depth(&two) - depth(&many)).abs() < 1e-5);
        }
        // Each of six layers is a third of one of the two.
        let six = spread(&two, 6);
        assert!((six.layers[0].texels[0][3] - (1.0 - 0.4f32.cbrt())).abs() < 1e-6);
        assert_eq!(six.layers[0], six.layers[2]);
        assert_ne!(six.layers[2], six.layers[3]);
    }
}
