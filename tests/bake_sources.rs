//! The sources of textures: the contribution of one hair, the opacity of the fur, and independence
//! of where the torus is cut.

use crate::common::{gpu, on_threads, worlds};
use glam::Vec3;
use pelage_core::scene::{BakeSource, DotProfile, Scene, Shape};
use pelage_fur::random::random;
use pelage_shells::bake::{self, Block, FurTextures, Hair, Keep, Knot, Texture, fin, voxelise};

const BLOCK: Block = Block { patch: [1.0, 1.0], height: 0.5, layers: 8, resolution: [64, 32] };

/// A hair of two knots, `lean` its tip's offset.
fn hair(root: [f32; 2], lean: [f32; 2], height: f32, diameter: f32) -> Hair {
    let knot = |s: f32| Knot {
        offset: Vec3::new(lean[0] * s, lean[1] * s, height * s),
        diameter,
        opacity: 1.0,
        color: Vec3::new(0.5, 0.25, s),
    };
    Hair { root, knots: vec![knot(0.0), knot(1.0)], guard: false }
}

/// Hairs of all kinds, their roots on a grid fine enough that whole texels can be added without
/// rounding.
fn thicket(count: u32, shift: [f32; 2]) -> Vec<Hair> {
    (0..count)
        .map(|i| {
            let root = [0, 1].map(|k| (random(i, k as u32) * 4096.0).floor() / 4096.0 + shift[k]);
            let lean = [random(i, 2) - 0.5, random(i, 3) - 0.5];
            let mut hair = hair(root, lean, 0.2 + 0.4 * random(i, 4), 0.002 + 0.02 * random(i, 5));
            hair.guard = i % 3 == 0;
            hair
        })
        .collect()
}

/// Sum of a function of all texels' coverage.
fn sum(textures: &[Texture], f: impl Fn(f64) -> f64) -> f64 {
    textures.iter().flat_map(|t| &t.texels).map(|t| f(f64::from(t[3]))).sum()
}

fn baked(edit: impl FnOnce(&mut Scene)) -> FurTextures {
    let world = worlds::world(|scene| {
        scene.mesh.shape = Some(Shape::Sphere);
        scene.bake.resolution = [64; 2];
        scene.bake.fin_resolution = [128, 32];
        edit(scene);
    });
    bake::bake(&world).expect("textures")
}

/// A groom without structure, for which the opacity is known.
fn plain(scene: &mut Scene) {
    scene.undercoat.density = 8000.0.into();
    scene.undercoat.diameter = [14.0, 7.0];
    scene.undercoat.height = 0.4.into();
    scene.undercoat.noise_contrast = 0.0;
    scene.undercoat.height_variation = 0.0;
    scene.guard.density = 300.0.into();
    scene.guard.diameter = [40.0; 3];
    scene.guard.length = 0.8.into();
    scene.guard.length_variation = 0.0;
    scene.guard.spread = 0.0;
    scene.guard.frizz = 0.0.into();
    scene.guard.clump = 0.0.into();
    scene.bake.height = Some(0.8);
}

#[test]
fn one_hair_shows_its_length_times_its_diameter() {
    let texel = 1.0 / (64.0 * 32.0);
    // Upright, leaning over the border, thinner and thicker than a texel.
    for (lean, diameter) in [([0.0, 0.0], 0.004), ([0.7, 0.4], 0.004), ([0.0, 0.0], 0.05), ([0.3, 0.0], 0.02)]
    {
        let one = vec![hair([0.97, 0.02], lean, 0.5, diameter)];
        let shown = one[0].area();
        let depth = voxelise(&one, &BLOCK, Keep::Depth, false);
        let found = sum(&depth.layers, |a| -(1.0 - a).ln()) * texel;
        assert!((found / shown - 1.0).abs() < 1e-3, "depth {found}, hair {shown}");
        assert!((depth.optical_depth.iter().sum::<f64>() / shown - 1.0).abs() < 1e-3);
        let coverage = voxelise(&one, &BLOCK, Keep::Coverage, false);
        let found = sum(&coverage.layers, |a| a) * texel;
        assert!((found / shown - 1.0).abs() < 2e-3, "coverage {found}, hair {shown}");
        // The two differ where a hair covers few texels deeply.
        assert!(sum(&depth.layers, |a| a) < sum(&coverage.layers, |a| a));
        let side = fin(&one, &BLOCK, [256, 32], 1.0, false).0;
        let found = sum(&[side], |a| a) * BLOCK.patch[0] as f64 * BLOCK.height as f64 / (256.0 * 32.0);
        assert!((found / shown - 1.0).abs() < 2e-3, "fin {found}, hair {shown}");
    }
    // What lies above the block is counted.
    let tall = vec![hair([0.5, 0.5], [0.0; 2], 1.0, 0.004)];
    let half = voxelise(&tall, &BLOCK, Keep::Depth, false);
    assert!(
        (half.above - 0.002).abs() < 1e-6 && (half.optical_depth.iter().sum::<f64>() - 0.002).abs() < 1e-5
    );
}

#[test]
fn roots_moved_by_whole_texels_roll_the_layers_bit_by_bit() {
    let (dx, dy) = (23usize, 9usize);
    let there = thicket(150, [0.0; 2]);
    let moved = thicket(150, [dx as f32 / 64.0, dy as f32 / 32.0]);
    let rolled = |t: &Texture, dx: usize, dy: usize| {
        let (w, h) = (t.width as usize, t.height as usize);
        let texel = |i: usize| t.texels[(i / w + h - dy) % h * w + (i % w + w - dx) % w];
        (0..w * h).map(texel).collect::<Vec<_>>()
    };
    for keep in [Keep::Depth, Keep::Coverage] {
        let (a, b) = (voxelise(&there, &BLOCK, keep, true), voxelise(&moved, &BLOCK, keep, true));
        for (a, b) in a.layers.iter().chain(&a.guard).zip(b.layers.iter().chain(&b.guard)) {
            assert!(rolled(a, dx, dy) == b.texels, "{keep:?}");
            assert!(rolled(a, dx + 1, dy) != b.texels);
        }
    }
    // A fin is rolled along u; a whole turn along v changes nothing.
    let moved = thicket(150, [dx as f32 / 64.0, 3.0]);
    let side = |hairs: &Vec<Hair>| fin(hairs, &BLOCK, [64, 16], 0.4, true);
    let (a, b) = (side(&there), side(&moved));
    assert!(rolled(&a.0, dx, 0) == b.0.texels && rolled(&a.1, dx, 0) == b.1.texels);
}

/// Mean step from a column to the next one, and over the border; the same for rows.
fn steps(t: &Texture) -> [(f32, f32); 2] {
    let (w, h) = (t.width as usize, t.height as usize);
    let at = |x: usize, y: usize| t.texels[y % h * w + x % w];
    let step = |a: [f32; 4], b: [f32; 4]| (0..4).map(|k| (a[k] - b[k]).abs()).sum::<f32>();
    let columns = |x| (0..h).map(|y| step(at(x, y), at(x + 1, y))).sum::<f32>() / h as f32;
    let rows = |y| (0..w).map(|x| step(at(x, y), at(x, y + 1))).sum::<f32>() / w as f32;
    [
        ((0..w - 1).map(columns).fold(0.0, f32::max), columns(w - 1)),
        ((0..h - 1).map(rows).fold(0.0, f32::max), rows(h - 1)),
    ]
}

#[test]
fn no_source_has_a_seam_where_its_torus_is_cut() {
    for source in [BakeSource::Hybrid, BakeSource::Particles, BakeSource::Dots] {
        let textures = baked(|scene| {
            scene.bake.source = source;
            scene.bake.particles.clump = 0.8;
            scene.guard.clump = 0.8.into();
        });
        for layer in &textures.layers[..12] {
            for (inside, border) in steps(layer) {
                assert!(
                    border <= inside * 1.15 + 1e-4,
                    "{source:?}: {border} over the border, {inside} inside"
                );
            }
        }
        let (inside, border) = steps(&textures.fin)[0];
        assert!(border <= inside * 1.15 + 1e-4, "{source:?}: fin {border} over the border, {inside} inside");
    }
    // A layer that does not wrap is detected.
    let ramp = Texture { width: 16, height: 4, texels: (0..64).map(|i| [(i % 16) as f32; 4]).collect() };
    let (inside, border) = steps(&ramp)[0];
    assert!(border > 2.0 * inside);
}

#[test]
fn the_number_of_threads_does_not_matter() {
    for source in [BakeSource::Hybrid, BakeSource::Particles, BakeSource::Dots] {
        let bake = |threads| on_threads(threads, || baked(|scene| scene.bake.source = source));
        assert!(bake(1) == bake(3), "{source:?}");
    }
    assert!(
        baked(|s| s.bake.source = BakeSource::Dots)
            != baked(|s| (s.bake.source, s.render.seed) = (BakeSource::Dots, 1))
    );
}

#[test]
fn layers_have_the_optical_depth_of_the_groom() {
    let textures = baked(plain);
    // Hairs of the undercoat end as the volume's do: 1 - smoothstep(0.75, 1.02, t); they grow
    // thinner towards t = 1.
    let coat = |t: f64| {
        let x = ((t - 0.75) / 0.27).clamp(0.0, 1.0);
        8000.0 * 14e-4 * (1.0 - x * x * (3.0 - 2.0 * x)) * (1.0 - 0.5 * t)
    };
    let wanted: f64 =
        0.4 * (0..1000).map(|i| coat((i as f64 + 0.5) / 1000.0) / 1000.0).sum::<f64>() + 300.0 * 40e-4 * 0.8;
    let found: f64 = textures.manifest.summary.iter().map(|l| f64::from(l.optical_depth)).sum();
    assert!((found / wanted - 1.0).abs() < 0.01, "{found}, wanted {wanted}");
    // In the middle of the undercoat the layers have the density of the volume.
    let middle = textures.manifest.summary[4];
    let wanted = (coat(0.5 * 9.0 / 8.0) + 300.0 * 40e-4) * 0.05;
    assert!((f64::from(middle.optical_depth) / wanted - 1.0).abs() < 0.02, "{middle:?}, wanted {wanted}");
}

#[test]
fn stacks_of_layers_follow_beer_and_lambert() {
    for (resolution, layers) in [(64, 16), (128, 16), (64, 4)] {
        let textures = baked(|scene| {
            plain(scene);
            scene.bake.resolution = [resolution; 2];
            scene.bake.layers = layers;
        });
        let (mut through, mut depth) = (1.0, 0.0);
        for layer in textures.manifest.summary.iter().rev() {
            through *= 1.0 - f64::from(layer.coverage);
            depth += f64::from(layer.optical_depth);
            let wanted = (-depth).exp();
            assert!(
                (through - wanted).abs() < 0.01,
                "{resolution} {layers}: {through}, wanted {wanted} ({layer:?})"
            );
        }
        assert!(depth > 4.0, "{depth}");
    }
}

#[test]
fn guard_hairs_keep_their_share() {
    let textures = baked(plain);
    let alone = baked(|scene| {
        plain(scene);
        scene.undercoat.density = 0.0.into();
    });
    // Above the undercoat there are guard hairs only, and they are the same.
    for l in 10..16 {
        assert!(
            textures.layers[l] == textures.guard[l] && alone.layers[l] == textures.layers[l],
            "layer {l}"
        );
    }
    for (all, guard) in textures.layers.iter().zip(&textures.guard) {
        for (a, g) in all.texels.iter().zip(&guard.texels) {
            assert!((0..4).all(|k| g[k] <= a[k] + 1e-6), "{g:?} of {a:?}");
            assert!(a[3] <= 1.0 && a[..3].iter().all(|c| *c <= a[3] + 1e-6), "{a:?} is not premultiplied");
        }
    }
    assert!(textures.fin.texels.iter().zip(&textures.fin_guard.texels).all(|(a, g)| g[3] <= a[3] + 1e-6));
    assert!(
        sum(&textures.guard[..4], |a| a) > 0.0
            && sum(&textures.guard[..4], |a| a) < sum(&textures.layers[..4], |a| a)
    );
}

#[test]
fn the_height_holds_all_but_the_tips() {
    let height = |edit: fn(&mut Scene)| {
        baked(|scene| {
            plain(scene);
            scene.bake.height = None;
            edit(scene);
        })
        .manifest
        .height
    };
    // Straight guard hairs of one thickness: 99 % of their length.
    let guard = height(|_| ());
    assert!((guard - 0.792).abs() < 0.002, "{guard}");
    let coat = height(|scene| scene.guard.length = 0.3.into());
    assert_eq!(coat, 0.4);
    let tapered = height(|scene| scene.guard.diameter = [40.0, 40.0, 1.0]);
    assert!(tapered < guard, "{tapered}");
}

#[test]
fn maps_count_at_their_mean() {
    let depth = |value: &str| {
        let text = format!(
            "[mesh]\nshape = 'plane'\n[undercoat]\ndensity = {value}\nnoise_contrast = 0\n[guard]\ndensity = 0\n[bake]\nlayers = 2"
        );
        let textures = bake::bake(&gpu::world(&text)).expect("textures");
        textures.manifest.summary.iter().map(|l| l.optical_depth).sum::<f32>()
    };
    // The plane's vertices are white.
    let constant = depth("6000");
    let mapped = depth("{ map = 'vertex_color', value = 4000, offset = 2000 }");
    assert!((mapped / constant - 1.0).abs() < 1e-3, "{mapped} {constant}");
}

#[test]
fn dots_are_fewer_the_higher_they_lie_and_keep_their_place() {
    let textures = |profile, size| {
        baked(|scene| {
            scene.bake.source = BakeSource::Dots;
            scene.bake.layers = 5;
            scene.bake.resolution = [256; 2];
            scene.bake.dots.base = 800;
            scene.bake.dots.tip = 100;
            scene.bake.dots.profile = profile;
            scene.bake.dots.size = size;
            scene.bake.dots.root_brightness = 1.0;
        })
    };
    let count = |t: &Texture| t.texels.iter().filter(|t| t[3] > 0.0).count();
    for (profile, wanted) in [
        (DotProfile::Linear, [800, 625, 450, 275, 100]),
        (DotProfile::Power2, [800, 494, 275, 144, 100]),
        (DotProfile::Power3, [800, 395, 188, 111, 100]),
        (DotProfile::Mixed, [800, 446, 286, 188, 100]),
    ] {
        let textures = textures(profile, 1);
        for (layer, wanted) in textures.layers.iter().zip(wanted) {
            // Two dots may share a texel.
            assert!(
                count(layer) <= wanted && count(layer) + 12 > wanted,
                "{profile:?}: {} {wanted}",
                count(layer)
            );
        }
        for pair in textures.layers.windows(2) {
            let mut pairs = pair[0].texels.iter().zip(&pair[1].texels);
            assert!(pairs.all(|(below, above)| above[3] == 0.0 || above == below), "{profile:?}");
        }
    }
    let large = textures(DotProfile::Linear, 3);
    assert!(count(&large.layers[4]) > 850 && count(&large.layers[4]) <= 900);
    assert!(sum(&[large.fin], |a| a) > 0.0);
}

#[test]
fn errors_say_what_cannot_be_baked() {
    let fault = |edit: fn(&mut Scene)| {
        let world = worlds::world(|scene| {
            scene.mesh.shape = Some(Shape::Sphere);
            edit(scene);
        });
        let error = bake::bake(&world).expect_err("a fault");
        assert_eq!(error.exit_code(), 3, "{error}");
        error.to_string()
    };
    let bald = fault(|s| {
        s.guard.density = 0.0.into();
        s.undercoat.height = 0.0.into();
    });
    assert!(bald.contains("no hair"), "{bald}");
    let layers = fault(|s| s.bake.layers = 0);
    assert!(layers.contains("bake.layers") && layers.contains("found 0"), "{layers}");
    let huge = fault(|s| (s.bake.layers, s.bake.resolution) = (128, [4096; 2]));
    assert!(huge.contains("at most"), "{huge}");
    let thin = fault(|s| s.bake.resolution = [4, 3]);
    assert!(thin.contains("4 x 3"), "{thin}");
    let flat = fault(|s| s.bake.height = Some(0.0));
    assert!(flat.contains("bake.height"), "{flat}");
    let nowhere = fault(|s| s.bake.patch = Some(f32::NAN));
    assert!(nowhere.contains("bake.patch"), "{nowhere}");
}
