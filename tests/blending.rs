//! Blending of undercoat, guard hairs and skin in the image.

use crate::common::worlds::{RGB, RGBA, ball, differing, largest, plane, render, rmse};
use pelage_core::World;
use pelage_core::scene::{Blend, FurLayers, LightLookup, Scene, Storage};
use pelage_core::stats::Stats;

fn blended(
    blend: Blend,
    virtual_fragments: u32,
    edit: impl FnOnce(&mut Scene),
) -> (pelage_core::film::Film, Stats) {
    let frame = render(&ball(|s| {
        s.render.blend = blend;
        s.render.virtual_fragments = virtual_fragments;
        edit(s);
    }));
    (frame.film, frame.stats)
}

/// Root of the mean square of the colours of covered pixels.
fn strength(film: &pelage_core::film::Film) -> f64 {
    rmse(film, &pelage_core::film::Film::from_premultiplied(film.width, film.height, &[]), &RGB)
}

#[test]
fn virtual_fragments_converge_to_exact_blending() {
    // Bright enough that an error shows: the fur's brightest places are near 1.
    let bright =
        |s: &mut Scene| s.lights.iter_mut().for_each(|l| l.irradiance = l.irradiance.map(|e| 6.0 * e));
    let exact = blended(Blend::Exact, 1, bright).0;
    let errors = [1, 4, 16, 64].map(|n| rmse(&blended(Blend::Virtual, n, bright).0, &exact, &RGBA));
    let simplified = rmse(&blended(Blend::Simplified, 1, bright).0, &exact, &RGBA);
    println!(
        "virtual to exact, 1 4 16 64 fragments: {errors:.6?}; simplified: {simplified:.6}; rms {:.4}",
        strength(&exact)
    );
    assert!(errors.windows(2).all(|e| e[1] < e[0]), "not falling: {errors:?}");
    assert!(errors[3] < 0.002, "{errors:?}");
    assert!(errors[0] > 0.002, "one virtual fragment is as good as 64: nothing was tested");
}

#[test]
fn blends_agree_where_no_strand_is() {
    let bare = |s: &mut Scene| s.render.fur = FurLayers::Implicit;
    let exact = blended(Blend::Exact, 1, bare).0;
    for (blend, n) in [(Blend::Simplified, 1), (Blend::Virtual, 1), (Blend::Virtual, 30)] {
        let (film, stats) = blended(blend, n, bare);
        let most = largest(&film, &exact, &["R", "G", "B", "A", "transmittance.Y"]);
        println!("{blend:?} {n}: largest difference {most:.6}, {} rays lost", stats.rays_lost);
        assert!(most < 1e-3, "{blend:?} {n}: {most}");
    }
}

#[test]
fn contributions_add_up() {
    for blend in [Blend::Exact, Blend::Virtual, Blend::Simplified] {
        let film = blended(blend, 8, |_| ()).0;
        for c in RGB {
            let [guard, coat, base] =
                ["guard", "undercoat", "base"].map(|part| plane(&film, &format!("{part}.{c}")).to_vec());
            let mut seen = [false; 3];
            for (i, all) in plane(&film, c).iter().enumerate() {
                let sum = guard[i] + coat[i] + base[i];
                assert!((sum - all).abs() <= 1e-6 * all.abs().max(1.0), "{blend:?} {c} {i}: {sum} {all}");
                [guard[i], coat[i], base[i]].iter().zip(&mut seen).for_each(|(v, s)| *s |= *v > 1e-3);
            }
            assert_eq!(seen, [true; 3], "{blend:?}: a layer is nowhere seen");
        }
        for (a, t) in plane(&film, "A").iter().zip(plane(&film, "transmittance.Y")) {
            assert!((a + t - 1.0).abs() < 1e-6 && (-1e-6..=1.0 + 1e-6).contains(a), "{blend:?}: {a} {t}");
        }
    }
}

/// White fur scatters all light that it extinguishes: into any direction at most E / pi^2 of each
/// light (Kajiya-Kay, sine of 1), the white skin E / pi.
#[test]
fn white_undercoat_stays_below_its_bound() {
    let white = |forward: f32| {
        move |s: &mut Scene| {
            s.render.fur = FurLayers::Implicit;
            s.undercoat.color_root = [1.0; 3].into();
            s.undercoat.color_tip = [1.0; 3].into();
            s.undercoat.forward_scattering = forward;
            s.base.color = [0.0; 3].into();
            for light in &mut s.lights {
                light.irradiance = [1.0; 3];
            }
        }
    };
    let most =
        |film: &pelage_core::film::Film| RGB.map(|c| plane(film, c).iter().fold(0f32, |a, b| a.max(*b)));
    let bound = 2.0 / (std::f32::consts::PI * std::f32::consts::PI);
    for forward in [0.0, 1.0] {
        let found = most(&blended(Blend::Exact, 1, white(forward)).0);
        println!("forward scattering {forward}: brightest {found:.4?} of at most {bound:.4}");
        // Halves round by 2^-11.
        assert!(found.iter().all(|v| *v <= bound * 1.001), "{found:?} is more than {bound}");
        assert!(found.iter().all(|v| *v > 0.2 * bound), "{found:?}: too dark to test the bound");
    }
    // Twice the diffuse weight is not physical, and exceeds the bound.
    let film = blended(Blend::Exact, 1, |s| {
        white(1.0)(s);
        s.undercoat.fibre.diffuse = Some(2.0);
    })
    .0;
    assert!(most(&film)[0] > bound);
}

/// Light adds up: an image under two lights is the sum of the images under each, and twice the
/// light is twice the image.
#[test]
fn light_is_linear() {
    // The two brightest lights are key lights with their own lookups. A third is folded into the
    // logarithm of the radiance at each lattice node, with the skin's normal as the hairs' tangent.
    // Alone it is a key light too, so that the sum also measures the error of folding.
    let third = pelage_core::scene::DirectionalLight { direction: [0.1, 0.3, 0.9], irradiance: [0.5; 3] };
    let under = |lights: Vec<usize>, factor: f32| {
        blended(Blend::Exact, 1, |s| {
            s.lights.push(third.clone());
            for (i, light) in s.lights.iter_mut().enumerate() {
                let on = if lights.contains(&i) { factor } else { 0.0 };
                light.irradiance = light.irradiance.map(|e| e * on);
            }
        })
        .0
    };
    let all = under(vec![0, 1, 2], 1.0);
    let double = under(vec![0, 1, 2], 2.0);
    let parts: Vec<_> = [0, 1, 2].map(|i| under(vec![i], 1.0)).into();
    let (mut sum_error, mut double_error, mut mean) = (0f64, 0f64, 0f64);
    for c in RGB {
        for i in 0..all.pixels() {
            let one = plane(&all, c)[i];
            let sum: f32 = parts.iter().map(|p| plane(p, c)[i]).sum();
            sum_error += f64::from(one - sum).powi(2);
            double_error += f64::from(plane(&double, c)[i] - 2.0 * one).powi(2);
            mean += f64::from(one).powi(2);
        }
    }
    let relative = [sum_error, double_error].map(|e| (e / mean).sqrt());
    println!("relative RMSE of sum and double: {relative:.6?}");
    assert!(relative[0] < 0.02 && relative[1] < 0.001, "{relative:?}");
}

#[test]
fn stored_and_evaluated_densities_make_the_same_image() {
    let kept = |storage: Storage| move |s: &mut Scene| s.undercoat.storage = storage;
    let (stored, a) = blended(Blend::Exact, 1, kept(Storage::Stored));
    let (evaluated, b) = blended(Blend::Exact, 1, kept(Storage::Evaluated));
    assert_eq!((a.storage.as_str(), b.storage.as_str()), ("stored", "evaluated"));
    // An evaluated medium is rounded as if it were stored.
    let found = differing(&stored, &evaluated);
    assert!(found.is_empty(), "plane, pixels, most, first: {found:?}");
    let finer = |s: &mut Scene| s.undercoat.layers *= 2;
    assert!(
        !differing(&stored, &blended(Blend::Exact, 1, finer).0).is_empty(),
        "densities do not show at all"
    );
}

/// The optical-depth lattice replaces a march towards the light at every step. Undercoat alone,
/// since the nested march sees no guard hairs.
#[test]
fn the_lattice_approximates_the_nested_march() {
    let lit = |light: LightLookup, density: f32| {
        let edit = move |s: &mut Scene| {
            s.render.fur = FurLayers::Implicit;
            s.render.light = light;
            s.undercoat.density = density.into();
        };
        let film = blended(Blend::Exact, 1, edit).0;
        RGB.iter().flat_map(|c| plane(&film, c)).map(|v| f64::from(*v)).sum::<f64>()
    };
    let nested = lit(LightLookup::Nested, 12_000.0);
    let ratio = lit(LightLookup::Lattice, 12_000.0) / nested;
    // The same comparison must detect light that passes through a fifth of the fur.
    let thin = lit(LightLookup::Lattice, 2_400.0) / nested;
    println!("light by the lattice against the nested march: {ratio:.4}; through thin fur: {thin:.4}");
    assert!((ratio - 1.0).abs() < 0.06, "{ratio}");
    assert!((thin - 1.0).abs() > 0.06, "{thin}");
}

#[test]
fn no_fragment_is_dropped() {
    // Three segments and small lists: tiles overflow and are cut.
    let dense = |memory: u64| {
        move |s: &mut Scene| {
            s.render.memory = memory;
            s.guard.density = 600.0.into();
            s.guard.segments = 3;
        }
    };
    let (_, roomy) = blended(Blend::Virtual, 40, dense(1 << 30));
    let (_, tight) = blended(Blend::Virtual, 40, dense(20 << 20));
    assert_eq!((roomy.fragments_dropped, tight.fragments_dropped), (0, 0));
    assert_eq!(roomy.tiles_retried, 0);
    assert!(tight.tiles_retried > 0);
    assert_eq!(roomy.fragments, tight.fragments);
    assert!(
        tight.gpu_peak_bytes <= tight.memory_budget_bytes,
        "{} of {}",
        tight.gpu_peak_bytes,
        tight.memory_budget_bytes
    );
}

/// A pelt so small in the picture that a sample has hundreds of fragments: the adapter may end the
/// loops that read them, and the tile is then resolved once more from sorted lists.
#[test]
fn lists_of_hundreds_of_fragments_are_read_to_their_end() {
    if crate::common::gpu::open().is_none() {
        return;
    }
    let path = crate::common::root().join("scenes/cylinder.toml");
    let at = |spp: u32| {
        let set = ["film.width=16", "film.height=10", "film.filter=box", "render.fur=explicit"];
        let mut set: Vec<String> = set.map(String::from).to_vec();
        set.push(format!("film.spp={spp}"));
        let (scene, assets) = Scene::load(&path, &set).expect("a scene");
        render(&World::load(scene, &assets).expect("a world"))
    };
    let (coarse, fine) = (at(1), at(16));
    assert!(coarse.stats.fragments_max > 500, "{}", coarse.stats.fragments_max);
    for stats in [&coarse.stats, &fine.stats] {
        assert_eq!((stats.fragments_unread, stats.rays_cut), (0, 0));
    }
    let read: f32 = plane(&coarse.film, "fragments.Y").iter().sum();
    assert_eq!(read as u64, coarse.stats.fragments);
    // Over the scene's background, so that the noise of the coverage counts for less.
    let mean = |film: &pelage_core::film::Film| {
        let (red, alpha) = (plane(film, "R"), plane(film, "A"));
        red.iter().zip(alpha).map(|(r, a)| r + 0.5 * (1.0 - a)).sum::<f32>() / 160.0
    };
    let (a, b) = (mean(&coarse.film), mean(&fine.film));
    println!("{} fragments, mean red {a} at 1 sample, {b} at 16", coarse.stats.fragments);
    assert!((a / b - 1.0).abs() < 0.03, "{a} {b}");
}

#[test]
fn hundreds_of_virtual_fragments_converge_too() {
    let exact = blended(Blend::Exact, 1, |_| ()).0;
    let (many, stats) = blended(Blend::Virtual, 600, |_| ());
    let error = rmse(&many, &exact, &RGBA);
    println!("600 virtual fragments: {error:.6}, longest list {}", stats.fragments_max);
    assert!(error < 0.002 && stats.fragments_max > 600, "{error}");
    assert_eq!((stats.fragments_unread, stats.rays_cut), (0, 0));
}
