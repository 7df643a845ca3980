//! `hair_roots` against its CPU twin, and the statistics of the roots.

use crate::common::gpu::{self, Fixture, image, jittered_grid, scaled, world_on};
use glam::Vec3;
use pelage_fur::hair_roots::Roots;
use pelage_fur::layout::Root;
use pelage_fur::parameters::{Parameter, skin_point};
use pelage_fur::random::{hash2, random};

/// A bumpy grid of 8 x 8 cm with guard hairs.
fn hairy(density: &str, seed: u32) -> pelage_core::World {
    let scene = format!(
        "[guard]\ndensity = {density}\nlength = 0.1\nsegments = 1\n[render]\nfur = \"explicit\"\nseed = {seed}\n"
    );
    // Half of the map is bald.
    let map = image("density.png", false, 32, |u, _| [(2.0 * u - 1.0).clamp(0.0, 1.0); 4]);
    world_on(&scene, Some(scaled(jittered_grid(8, 0.2), 1.0, 8.0)), vec![map])
}

fn twin(fixture: &Fixture) -> Roots<'_> {
    let density = fixture.world.scene.guard.density.max();
    Roots { shell: &fixture.shell, maps: fixture.maps(), density, seed: fixture.world.scene.render.seed }
}

/// Whether rounding may change the number of candidates of a triangle, or whether one is kept.
fn ambiguous(roots: &Roots<'_>, prism: u32) -> bool {
    let seed = hash2(roots.seed, prism);
    let number = roots.expected(prism) + random(seed, 0);
    let near_whole = (number - number.round()).abs() < 1e-3;
    let near_threshold = (0..roots.candidates(prism)).any(|k| {
        let at = skin_point(roots.shell, prism, roots.candidate(prism, k));
        let wanted = roots.maps.scalar(Parameter::GuardDensity, &at);
        (random(seed, 3 + k) * roots.density - wanted).abs() < 1e-3 * roots.density
    });
    near_whole || near_threshold
}

#[test]
fn roots_are_those_of_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    for (density, seed) in [("37.3", 0), ("37.3", 9), ("{ map = \"density.png\", value = 60 }", 3)] {
        let fixture = Fixture::new(gpu, hairy(density, seed));
        let found: Vec<Root> = fixture.read("roots", fixture.strands());
        assert!(found.windows(2).all(|w| w[0].prism <= w[1].prism), "roots stand by triangle");
        let roots = twin(&fixture);
        let mut skipped = 0;
        for prism in 0..fixture.prepared.triangles {
            let found: Vec<&Root> = found.iter().filter(|r| r.prism == prism).collect();
            let wanted = roots.of(prism);
            let seeds = |r: &[&Root]| r.iter().map(|r| r.seed).collect::<Vec<_>>();
            if ambiguous(&roots, prism) && seeds(&found) != seeds(&wanted.iter().collect::<Vec<_>>()) {
                skipped += 1;
                continue;
            }
            assert_eq!(found.len(), wanted.len(), "{density}, triangle {prism}");
            for (a, b) in found.iter().zip(&wanted) {
                assert_eq!((a.prism, a.seed), (b.prism, b.seed), "{density}, triangle {prism}");
                let d = [0, 1].map(|k| (a.lambda[k] - b.lambda[k]).abs());
                assert!(d[0].max(d[1]) < 1e-4, "{density}, triangle {prism}: {a:?} {b:?}");
            }
        }
        assert!(skipped <= fixture.prepared.triangles / 50, "{skipped} triangles skipped");
    }
}

#[test]
fn as_many_roots_as_area_times_density() {
    let Some(gpu) = gpu::open() else { return };
    let (mut found, mut expected, mut variance) = (0.0, 0.0, 0.0);
    for seed in 0..4 {
        let fixture = Fixture::new(gpu, hairy("3.7", seed));
        let roots = twin(&fixture);
        found += fixture.strands() as f64;
        for x in (0..fixture.prepared.triangles).map(|p| f64::from(roots.expected(p))) {
            expected += x;
            variance += x.fract() * (1.0 - x.fract());
        }
        let area = fixture.world.skin.area() * 3.7;
        assert!((area - expected / f64::from(seed + 1)).abs() < 1e-3 * area);
    }
    let sigma = f64::sqrt(variance);
    assert!((found - expected).abs() < 3.0 * sigma, "{found} roots, {expected} expected, sigma {sigma}");
    // Rounding the number of each triangle down instead would be detected.
    assert!(0.25 * 4.0 * 128.0 > 3.0 * sigma);
}

#[test]
fn thinning_follows_the_map() {
    let Some(gpu) = gpu::open() else { return };
    let fixture = Fixture::new(gpu, hairy("{ map = \"density.png\", value = 200 }", 1));
    let found: Vec<Root> = fixture.read("roots", fixture.strands());
    let u = |r: &Root| {
        let [l1, l2] = r.lambda;
        skin_point(&fixture.shell, r.prism, Vec3::new(1.0 - l1 - l2, l1, l2)).uv.x
    };
    assert!(!found.iter().any(|r| u(r) < 0.45 && u(r) > 0.05), "roots where the map is bald");
    // The density rises evenly from the middle on: three quarters of the hairs are in the last
    // quarter.
    let part = |low: f32, high: f32| found.iter().filter(|r| (low..high).contains(&u(r))).count() as f32;
    let share = part(0.75, 0.95) / part(0.55, 0.95);
    close_to(share, (0.9f32.powi(2) - 0.5f32.powi(2)) / (0.9f32.powi(2) - 0.1f32.powi(2)), 0.04);
}

#[track_caller]
fn close_to(a: f32, b: f32, tolerance: f32) {
    assert!((a - b).abs() < tolerance, "{a} is not {b}");
}

/// Chi-square of points over the 64 subelements of their triangles.
fn chi_square(lambdas: &[Vec3]) -> f64 {
    let mut bins = [0.0f64; 64];
    lambdas.iter().for_each(|l| bins[pelage_fur::shell::subelement(*l, 3) as usize] += 1.0);
    let mean = lambdas.len() as f64 / 64.0;
    bins.iter().map(|n| (n - mean).powi(2) / mean).sum()
}

#[test]
fn roots_are_uniform_in_their_triangles() {
    let Some(gpu) = gpu::open() else { return };
    let fixture = Fixture::new(gpu, hairy("150", 5));
    let found: Vec<Root> = fixture.read("roots", fixture.strands());
    let lambdas: Vec<Vec3> =
        found.iter().map(|r| Vec3::new(1.0 - r.lambda[0] - r.lambda[1], r.lambda[0], r.lambda[1])).collect();
    assert!(lambdas.iter().all(|l| l.min_element() > -1e-6));
    // 63 degrees of freedom: 0.1% of random points exceed 103; the recurrence is more even than
    // random points.
    assert!(chi_square(&lambdas) < 103.0, "{}", chi_square(&lambdas));
    // Without the square root points gather at corner 0.
    let gathered: Vec<Vec3> = lambdas
        .iter()
        .map(|l| {
            let r = 1.0 - l.x;
            Vec3::new(1.0 - r * r, l.y * r, l.z * r)
        })
        .collect();
    assert!(chi_square(&gathered) > 1000.0);
}

/// Two triangles with more candidates than a loop of a shader may have rounds, and than there are
/// random numbers below those of the roots' seeds.
#[test]
fn roots_of_large_triangles_differ_from_each_other() {
    let Some(gpu) = gpu::open() else { return };
    let scene =
        "[guard]\ndensity = 2500\nlength = 0.1\nsegments = 1\n[render]\nfur = \"explicit\"\nseed = 2\n";
    let fixture =
        Fixture::new(gpu, world_on(scene, Some(scaled(jittered_grid(1, 0.0), 8.0, 8.0)), Vec::new()));
    let found: Vec<Root> = fixture.read("roots", fixture.strands());
    let roots = twin(&fixture);
    for prism in 0..2 {
        let found: Vec<&Root> = found.iter().filter(|r| r.prism == prism).collect();
        let wanted = roots.of(prism);
        assert!((found.len() as f64 - 80_000.0).abs() <= 1.0, "{} roots", found.len());
        assert_eq!(found.len(), wanted.len());
        let same = found.iter().zip(&wanted).filter(|(a, b)| {
            let d = [0, 1].map(|k| (a.lambda[k] - b.lambda[k]).abs());
            a.seed == b.seed && d[0].max(d[1]) < 0.01
        });
        // Places next to an edge of the unit square may wrap.
        assert!(same.count() * 1000 > 999 * found.len(), "the twin has other roots");
        let seeds: std::collections::HashSet<u32> = found.iter().map(|r| r.seed).collect();
        assert_eq!(seeds.len(), found.len(), "two roots have the same seed");
        let places: std::collections::HashSet<[u32; 2]> =
            found.iter().map(|r| r.lambda.map(f32::to_bits)).collect();
        // In f32, a few of the sequence's multiples coincide.
        assert!(places.len() * 1000 > 980 * found.len(), "{} places of {}", places.len(), found.len());
        // Thinning does not repeat the seeds of other roots.
        let thinning = |k: u32| random(hash2(roots.seed, prism), 3 + k);
        let of_seeds: std::collections::HashSet<u32> = found.iter().map(|r| r.seed >> 8).collect();
        let repeated = (0..16_384).filter(|k| of_seeds.contains(&((thinning(*k) * 16_777_216.0) as u32)));
        // 80,000 of 2^24 values are those of a seed by chance.
        assert!(repeated.count() < 16_384 / 50);
    }
}
