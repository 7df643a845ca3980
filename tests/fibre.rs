//! The fibre models: energy, reciprocity, sampling. Random numbers have fixed seeds.

use glam::Vec3;
use pelage_fur::fibre::medulla::Parts;
use pelage_fur::fibre::medulla::scatter::{Medium, ScatterTable};
use pelage_fur::fibre::{
    Absorption, Albedos, Angles, Chiang, FarTable, Fibre, Hit, KajiyaKay, Medulla, Sadeghi, offsets,
};
use pelage_fur::random::random;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::LazyLock;

fn direction(theta: f64, phi: f64) -> Vec3 {
    Vec3::new(theta.sin() as f32, (theta.cos() * phi.cos()) as f32, (theta.cos() * phi.sin()) as f32)
}

fn hit(tint: Vec3, h: f32) -> Hit {
    Hit { tint, glint_angle: 0.6, h }
}

fn sadeghi() -> Sadeghi {
    Sadeghi {
        intensity: [0.08, 0.5, 0.06],
        shift: [-7.5f32, 3.75, 11.25].map(f32::to_radians),
        width: [7.5f32, 6.0, 15.0].map(f32::to_radians),
        azimuth_tt: 20f32.to_radians(),
        glint: 0.3,
        glint_width: 8f32.to_radians(),
        diffuse: 0.7,
        albedo: None,
    }
}

fn bright_sadeghi() -> Sadeghi {
    Sadeghi { intensity: [0.4, 0.9, 0.3], ..sadeghi() }
}

fn chiang(roughness: f32) -> Fibre {
    Fibre::Chiang(Chiang::new([roughness; 2], 2f32.to_radians(), 1.55, None))
}

fn parts() -> Parts {
    Parts {
        ior: 1.49,
        tilt: 2.64f32.to_radians(),
        layers: 0.68,
        absorption: Absorption::by_color(0.3),
        radius: 0.86,
        scattering: 3.15,
        medulla_absorption: 0.0,
        anisotropy: 0.79,
        width: [9.45f32, 17.63].map(f32::to_radians),
    }
}

fn medulla(edit: impl Fn(&mut Parts)) -> Fibre {
    let mut parts = parts();
    edit(&mut parts);
    Fibre::Medulla(Medulla::new(parts, None))
}

/// Models with their names, and whether they are lossless.
static MODELS: LazyLock<Vec<(String, Fibre, bool)>> = LazyLock::new(|| {
    let mut all = vec![
        ("kajiya_kay".into(), Fibre::KajiyaKay(KajiyaKay::new(1.0, 0.0, 12.0)), true),
        ("kajiya_kay with highlight".into(), Fibre::KajiyaKay(KajiyaKay::new(0.6, 0.4, 12.0)), false),
        ("sadeghi".into(), Fibre::Sadeghi(sadeghi()), false),
        ("sadeghi_normalised".into(), Fibre::Sadeghi(bright_sadeghi().normalised()), false),
    ];
    for roughness in [0.1, 0.3, 0.6, 1.0] {
        all.push((format!("chiang {roughness}"), chiang(roughness), true));
    }
    all.push(("medulla".into(), medulla(|_| ()), true));
    all.push((
        "medulla, thin".into(),
        medulla(|p| (p.radius, p.anisotropy, p.layers) = (0.4, 0.3, 1.5)),
        true,
    ));
    all.push(("medulla, none".into(), medulla(|p| p.radius = 0.0), true));
    all
});

const THETAS: [f64; 5] = [0.0, 30.0, -55.0, 75.0, 85.0];

/// Integral over the light's directions of what `f` gives for angles; midpoints in theta and phi.
fn integrate(theta_o: f64, [rows, columns]: [u32; 2], f: impl Fn(&Angles) -> Vec3) -> [f64; 3] {
    let o = [theta_o.sin() as f32, theta_o.cos() as f32];
    let (dt, dp) = (PI / f64::from(rows), TAU / f64::from(columns));
    let mut sum = [0f64; 3];
    for r in 0..rows {
        let theta = (f64::from(r) + 0.5) * dt - FRAC_PI_2;
        let i = [theta.sin() as f32, theta.cos() as f32];
        for c in 0..columns {
            let phi = ((f64::from(c) + 0.5) * dp - PI) as f32;
            let value = f(&Angles { i, o, phi });
            (0..3).for_each(|k| sum[k] += f64::from(value[k]) * theta.cos() * dt * dp);
        }
    }
    sum
}

fn uniform(i: u32, seed: u32) -> [f32; 4] {
    [0, 1, 2, 3].map(|k| random(i.wrapping_mul(0x9e37_79b9) ^ seed, k))
}

#[test]
fn white_furnace() {
    for (name, model, lossless) in MODELS.iter() {
        for degrees in THETAS {
            let mut worst = 0f64;
            for h in [-0.9f32, 0.0, 0.55] {
                let hit = hit(Vec3::ONE, h);
                let found = integrate(degrees.to_radians(), [768, 256], |a| model.scatter(&hit, a))[0];
                worst = worst.max((found - 1.0).abs());
                if *lossless {
                    assert!((found - 1.0).abs() < 1e-3, "{name} at {degrees}, h {h}: {found}");
                } else if !name.starts_with("sadeghi") || name.ends_with("normalised") {
                    assert!(found < 1.001, "{name} at {degrees}: {found}");
                } else {
                    println!("{name} at {degrees}: {found:.4}");
                }
                if !model.is_near_field() {
                    break;
                }
            }
            println!("{name} at {degrees}: differs from 1 by {worst:.6}");
        }
    }
}

#[test]
fn normalisation_is_needed_and_costs_nothing_else() {
    let plain = Fibre::Sadeghi(bright_sadeghi());
    let mut most = 0f64;
    for degrees in THETAS {
        let whole = |m: &Fibre| {
            integrate(degrees.to_radians(), [512, 256], |a| m.scatter(&hit(Vec3::ONE, 0.0), a))[0]
        };
        most = most.max(whole(&plain));
    }
    assert!(most > 1.3, "the test's hair must create energy: {most}");
    // A hair that creates no energy is not changed.
    let (plain, normal) = (Fibre::Sadeghi(sadeghi()), Fibre::Sadeghi(sadeghi().normalised()));
    let tint = Vec3::splat(0.05);
    for degrees in [0.0, 30.0] {
        let whole =
            |m: &Fibre| integrate(f64::to_radians(degrees), [512, 256], |a| m.scatter(&hit(tint, 0.0), a))[0];
        let (a, b) = (whole(&plain), whole(&normal));
        assert!(a < 1.0 && (a - b).abs() < 1e-6, "{a} {b}");
    }
}

#[test]
fn white_furnace_by_samples() {
    for (name, model, lossless) in MODELS.iter() {
        for degrees in THETAS {
            let wo = direction(f64::to_radians(degrees), 0.4);
            let n = 100_000u32;
            let (mut sum, mut largest) = (0f64, 0f32);
            for i in 0..n {
                let h = 1.9 * random(i, 77) - 0.95;
                if let Some(s) = model.sample(&hit(Vec3::ONE, h), wo, uniform(i, 1)) {
                    sum += f64::from(s.weight.x);
                    largest = largest.max(s.weight.x);
                    assert!((s.direction.length() - 1.0).abs() < 1e-4 && s.weight.is_finite());
                }
            }
            let mean = sum / f64::from(n);
            println!("{name} at {degrees}: {mean:.4}, largest weight {largest:.2}");
            assert!(!*lossless || (mean - 1.0).abs() < 0.01, "{name} at {degrees}: {mean}");
            assert!(largest < 12.0, "{name} at {degrees}: a weight of {largest}");
        }
    }
}

#[test]
fn samples_have_the_mean_of_the_quadrature() {
    let tint = Vec3::new(0.7, 0.4, 0.2);
    for (name, model, _) in MODELS.iter() {
        for (degrees, h) in [(20.0, 0.3f32), (-60.0, -0.8), (80.0, 0.6)] {
            let hit = hit(tint, h);
            let wo = direction(f64::to_radians(degrees), -1.0);
            let n = 100_000u32;
            let mut sum = [0f64; 3];
            let mut square = 0f64;
            for i in 0..n {
                let w = model.sample(&hit, wo, uniform(i, 2)).map_or(Vec3::ZERO, |s| s.weight);
                (0..3).for_each(|k| sum[k] += f64::from(w[k]) / f64::from(n));
                square += f64::from(w.x * w.x) / f64::from(n);
            }
            let wanted = integrate(f64::to_radians(degrees), [1024, 512], |a| model.scatter(&hit, a));
            let error = ((square - sum[0] * sum[0]).max(0.0) / f64::from(n)).sqrt();
            for k in 0..3 {
                let off = (sum[k] - wanted[k]).abs();
                assert!(off < 4.0 * error + 2e-3, "{name} at {degrees}, h {h}: {sum:?} {wanted:?}");
            }
        }
    }
}

#[test]
fn densities_integrate_to_one() {
    for (name, model, _) in MODELS.iter() {
        for degrees in THETAS {
            let hit = hit(Vec3::new(0.8, 0.5, 0.3), 0.4);
            let wo = direction(f64::to_radians(degrees), 0.0);
            let whole = integrate(f64::to_radians(degrees), [2048, 512], |a| {
                let wi = Vec3::new(a.i[0], a.i[1] * a.phi.cos(), a.i[1] * a.phi.sin());
                Vec3::splat(model.pdf(&hit, wi, wo))
            })[0];
            assert!((whole - 1.0).abs() < 3e-3, "{name} at {degrees}: {whole}");
        }
    }
}

/// Chi square of samples of `model` against the density of `other`, in standard deviations above
/// its mean.
fn chi_square(model: &Fibre, other: &Fibre, degrees: f64, h: f32) -> f64 {
    const ROWS: usize = 16;
    const COLUMNS: usize = 16;
    let hit = hit(Vec3::new(0.8, 0.5, 0.3), h);
    let wo = direction(degrees.to_radians(), 0.0);
    let n = 60_000u32;
    let mut counts = vec![0f64; ROWS * COLUMNS];
    for i in 0..n {
        let Some(s) = model.sample(&hit, wo, uniform(i, 3)) else { continue };
        let row = ((f64::from(s.direction.x) + 1.0) * 0.5 * ROWS as f64) as usize;
        let phi = f64::from(s.direction.z).atan2(f64::from(s.direction.y));
        let column = ((phi / TAU + 0.5) * COLUMNS as f64) as usize;
        counts[row.min(ROWS - 1) * COLUMNS + column.min(COLUMNS - 1)] += 1.0;
    }
    // Bins of equal steps of sine and azimuth, each integrated by midpoints in theta.
    let mut expected = vec![0f64; ROWS * COLUMNS];
    let sub = 48;
    for row in 0..ROWS {
        let edge = |r: usize| (r as f64 / ROWS as f64 * 2.0 - 1.0).asin();
        let (low, high) = (edge(row), edge(row + 1));
        for t in 0..sub {
            let theta = low + (high - low) * (f64::from(t) + 0.5) / f64::from(sub);
            for column in 0..COLUMNS {
                for p in 0..16 {
                    let phi = ((column as f64 + (f64::from(p) + 0.5) / 16.0) / COLUMNS as f64 - 0.5) * TAU;
                    expected[row * COLUMNS + column] +=
                        f64::from(other.pdf(&hit, direction(theta, phi), wo)) * theta.cos() * (high - low)
                            / f64::from(sub)
                            * TAU
                            / (COLUMNS * 16) as f64
                            * f64::from(n);
                }
            }
        }
    }
    // Bins with few expected samples are merged.
    let (mut sum, mut bins, mut rest) = (0.0, 0, [0.0; 2]);
    for (c, e) in counts.iter().zip(&expected) {
        if *e < 10.0 {
            rest = [rest[0] + c, rest[1] + e];
        } else {
            sum += (c - e).powi(2) / e;
            bins += 1;
        }
    }
    if rest[1] > 10.0 {
        sum += (rest[0] - rest[1]).powi(2) / rest[1];
        bins += 1;
    }
    let freedom = f64::from(bins - 1);
    (sum - freedom) / (2.0 * freedom).sqrt()
}

#[test]
fn samples_follow_their_density() {
    for (name, model, _) in MODELS.iter() {
        for (degrees, h) in [(10.0, 0.2f32), (-50.0, -0.7), (78.0, 0.5)] {
            let above = chi_square(model, model, degrees, h);
            println!("{name} at {degrees}: chi square {above:.2} deviations above its mean");
            assert!(above < 4.5, "{name} at {degrees}: {above}");
        }
    }
}

#[test]
fn a_slightly_wrong_density_is_noticed() {
    let off = |tilt: f32| Fibre::Chiang(Chiang::new([0.3; 2], tilt.to_radians(), 1.55, None));
    assert!(chi_square(&off(2.0), &off(2.5), 10.0, 0.2) > 5.0);
    let wider = Fibre::Sadeghi(Sadeghi { width: [7.5f32, 7.5, 15.0].map(f32::to_radians), ..sadeghi() });
    assert!(chi_square(&Fibre::Sadeghi(sadeghi()), &wider, 10.0, 0.0) > 5.0);
    let sharp = |exponent: f32| Fibre::KajiyaKay(KajiyaKay::new(0.6, 0.4, exponent));
    assert!(chi_square(&sharp(12.0), &sharp(24.0), 10.0, 0.0) > 5.0);
}

/// Largest relative difference when light and view direction are exchanged.
fn exchange(model: &Fibre) -> f32 {
    let tint = Vec3::new(0.3, 0.6, 0.9);
    let mut worst = 0f32;
    for i in 0..500 {
        let [a, b, c, d] = uniform(i, 5).map(f64::from);
        let (l, v) = (direction(1.4 * (2.0 * a - 1.0), 6.2 * b), direction(1.4 * (2.0 * c - 1.0), 6.2 * d));
        let there = model.far_field(&hit(tint, 0.0), l, v);
        let back = model.far_field(&hit(tint, 0.0), v, l);
        worst = worst.max((there - back).abs().max_element() / (1e-2 + there.max_element()));
    }
    worst
}

#[test]
fn light_and_view_can_be_exchanged_where_models_are_reciprocal() {
    for (name, model, _) in MODELS.iter() {
        let worst = exchange(model);
        println!("{name}: {worst:.5}");
        let reciprocal = name == "kajiya_kay" || name.starts_with("sadeghi");
        assert!(!reciprocal || worst < 1e-3, "{name}: {worst}");
    }
    // The highlight of Kajiya and Kay is symmetric only as a product with the cosine: it is not
    // reciprocal.
    assert!(exchange(&Fibre::KajiyaKay(KajiyaKay::new(0.6, 0.4, 12.0))) > 0.01);
}

#[test]
fn constants_of_chiang() {
    let at = |b: f32| Chiang::new([b; 2], 0.0, 1.55, None);
    assert!((at(0.3).variance[0] - 0.084_611).abs() < 1e-5);
    assert!((at(0.1).variance[0] - 0.006_515_7).abs() < 1e-6);
    assert!((at(0.3).scale - 0.117_160).abs() < 1e-5);
    assert!((at(0.1).scale - 0.024_089).abs() < 1e-5);
    assert_eq!(at(0.3).variance[1] * 16.0, at(0.3).variance[2]);
    // Absorption from colour, by the published fit: the square is of the whole quotient.
    let sigma = at(0.3).absorption.of(Vec3::new(1.0, 0.5, 0.1));
    let wanted = |c: f64| {
        let b = 0.3f64;
        let d =
            5.969 - 0.215 * b + 2.532 * b.powi(2) - 10.73 * b.powi(3) + 5.574 * b.powi(4) + 0.245 * b.powi(5);
        (c.ln() / d).powi(2)
    };
    for (found, c) in sigma.to_array().into_iter().zip([1.0, 0.5, 0.1]) {
        assert!((f64::from(found) - wanted(c)).abs() < 1e-6);
    }
}

#[test]
fn lobes_of_chiang_leave_where_a_smooth_fibre_sends_them() {
    // For h = 0: R on the near side, rotated by twice the tilt; TT on the opposite side.
    let model = Fibre::Chiang(Chiang::new([0.1; 2], 2f32.to_radians(), 1.55, None));
    let hit = hit(Vec3::ONE, 0.0);
    let wo = direction(0.3, 0.0);
    let brightest = |phi: f64| {
        (0..2000)
            .map(|k| (f64::from(k) / 2000.0 - 0.5) * PI)
            .max_by(|a, b| {
                let at = |t: f64| model.evaluate(&hit, direction(t, phi), wo).x * t.cos() as f32;
                at(*a).total_cmp(&at(*b))
            })
            .unwrap()
            .to_degrees()
    };
    let mirror = -f64::to_degrees(0.3);
    assert!((brightest(PI) - (mirror - 2.0)).abs() < 0.4, "TT {}", brightest(PI));
    // R off to the side, where TRT is dim: h = 0.5 sends it to -60 degrees.
    let hit = self::hit(Vec3::splat(0.01), 0.5);
    let at = |t: f64| model.evaluate(&hit, direction(t, -PI / 3.0), wo).x * t.cos() as f32;
    let best = (0..2000).map(|k| (f64::from(k) / 2000.0 - 0.5) * PI).max_by(|a, b| at(*a).total_cmp(&at(*b)));
    assert!((best.unwrap().to_degrees() - (mirror + 4.0)).abs() < 0.6, "R {best:?}");
    let side = |phi: f64| model.evaluate(&hit, direction(mirror.to_radians(), phi), wo).x;
    assert!(side(-PI / 3.0) > 20.0 * side(PI / 3.0), "the reflection leaves on the side of its offset");
}

#[test]
fn lobes_of_a_fibre_with_a_medulla_share_the_light() {
    let Fibre::Medulla(model) = medulla(|_| ()) else { panic!() };
    let mean = |f: &dyn Fn([f32; 6]) -> f32| -> f32 {
        offsets(400).map(|(h, w)| w * f(model.energies([0.0, 1.0], h))).sum()
    };
    // The paper's five lobes; longer paths contribute little; the sum is 1.
    let five = mean(&|e| e[..5].iter().sum());
    let whole = mean(&|e| e.iter().sum());
    println!("five lobes {five:.5}, with all longer paths {whole:.6}");
    assert!((whole - 1.0).abs() < 1e-4 && five <= whole && five > 0.99, "{five} {whole}");
    // As published, light that is not scattered in the medulla counts there too.
    let published = mean(&|e| {
        let f = e[0];
        let through = e[1] / ((1.0 - f) * (1.0 - f)).max(1e-9);
        let scattered = if through < 0.9999 { (1.0 - f) + (1.0 - f) * f * through } else { 0.0 };
        e[0] + e[1] + e[2] + scattered
    });
    println!("without the part that is scattered: {published:.4}");
    assert!(published > 1.005, "{published}");
}

#[test]
fn medulla_tables_are_cached_and_rebuilt() {
    let medium = Medium { scattering: 1.3, anisotropy: 0.4, ior: 1.55 };
    let started = std::time::Instant::now();
    let simulated = ScatterTable::simulate(medium);
    println!("simulated in {:.2} s", started.elapsed().as_secs_f32());
    let folder = tempfile::tempdir().unwrap();
    let below = folder.path().join("not/there");
    assert_eq!(ScatterTable::cached(medium, Some(&below)), simulated);
    let file = std::fs::read_dir(&below).unwrap().next().unwrap().unwrap().path();
    let whole = std::fs::read(&file).unwrap();
    assert_eq!(ScatterTable::cached(medium, Some(&below)), simulated, "from the cache");
    // The table is read from the file: one of another medium under this name is detected, and so is
    // damage.
    let mut flipped = whole.clone();
    flipped[1000] ^= 1;
    for bad in [&whole[..whole.len() / 2], &[][..], &flipped[..]] {
        std::fs::write(&file, bad).unwrap();
        assert_eq!(ScatterTable::cached(medium, Some(&below)), simulated);
        assert_eq!(std::fs::read(&file).unwrap(), whole, "the file is rebuilt");
    }
    let other = ScatterTable::cached(Medium { anisotropy: 0.5, ..medium }, Some(&below));
    assert_ne!(other, simulated);
    // No folder can be created below a file.
    assert_eq!(ScatterTable::cached(medium, Some(&file.join("x"))), simulated);
}

#[test]
fn scattered_light_goes_where_the_medium_sends_it() {
    let of = |anisotropy| ScatterTable::simulate(Medium { scattering: 2.0, anisotropy, ior: 1.5 });
    let [forward, back] = [0.8, -0.6].map(of);
    // Mean cosine of the azimuth for light through the middle.
    let mean = |t: &ScatterTable| -> f32 {
        (0..720)
            .map(|k| (k as f32 / 720.0 - 0.5) * TAU as f32)
            .map(|x| t.around(0.0, 0.0, x) * x.cos())
            .sum::<f32>()
            * TAU as f32
            / 720.0
    };
    assert!(mean(&forward) > 0.4 && mean(&back) < 0.0, "{} {}", mean(&forward), mean(&back));
    let even = of(0.0);
    let symmetric = (even.around(0.3, 0.0, 1.0) - even.around(0.3, 0.0, -1.0)).abs();
    assert!(symmetric < 0.02, "{symmetric}");
    assert!((even.around(0.3, 0.5, 1.0) - even.around(0.3, -0.5, -1.0)).abs() < 1e-6);
    // Light that enters off centre is scattered back to the same side.
    assert!(even.around(0.0, 0.9, 2.0) > even.around(0.0, 0.9, -2.0));
}

/// The models that have tables.
fn thick() -> impl Iterator<Item = (&'static String, &'static Fibre)> {
    MODELS.iter().filter(|(_, m, _)| m.is_near_field()).map(|(name, m, _)| (name, m))
}

#[test]
fn tables_are_the_far_field() {
    for (name, model) in thick() {
        let started = std::time::Instant::now();
        let table = FarTable::new(model).unwrap();
        let seconds = started.elapsed().as_secs_f32();
        assert!(table.values.len() * 8 <= 2 << 20, "{name}: {} bytes", table.values.len() * 8);
        let mut worst = 0f32;
        let tint = Vec3::new(0.9, 0.35, 0.02);
        for i in 0..60 {
            let [a, b, c, _] = uniform(i, 9);
            let theta = (1.5 * (2.0 * a - 1.0)).sin();
            let o = [theta, (1.0 - theta * theta).sqrt()];
            let theta_i = -theta + 0.2 * (b - 0.5);
            let i = [theta_i.clamp(-1.0, 1.0), (1.0 - theta_i * theta_i).max(0.0).sqrt()];
            let at = |phi: f32| (Angles { i, o, phi }, hit(tint, 0.0));
            // Peak over the azimuth.
            let peak = (0..48)
                .map(|k| {
                    let (a, hit) = at(k as f32 / 47.0 * PI as f32);
                    model.scatter_far(&hit, &a)
                })
                .fold(Vec3::ZERO, Vec3::max);
            let (a, hit) = at(c * PI as f32);
            let off = (table.scatter(model, &a, tint) - model.scatter_far(&hit, &a)).abs() / peak;
            worst = worst.max(off.max_element());
        }
        println!(
            "{name}: table in {seconds:.2} s, {} KiB, off by {:.2} % of the peak",
            table.values.len() * 8 / 1024,
            100.0 * worst
        );
        assert!(worst < 0.02, "{name}: {worst}");
    }
}

#[test]
fn halves_of_the_directions_sum_to_the_albedo() {
    for (name, model, lossless) in MODELS.iter() {
        let albedos = Albedos::new(model);
        for degrees in [0.0f32, 40.0, -70.0] {
            let white = albedos.hemispherical(degrees.to_radians(), Vec3::ONE);
            let whole = white.forward.albedo + white.backward.albedo;
            println!("{name} at {degrees}: forward {:?}, backward {:?}", white.forward, white.backward);
            assert!(!*lossless || (whole - 1.0).abs().max_element() < 0.01, "{name} at {degrees}: {whole}");
            let tint = Vec3::new(0.8, 0.4, 0.1);
            let half = albedos.hemispherical(degrees.to_radians(), tint);
            let wanted = integrate(f64::from(degrees).to_radians(), [192, 64], |a| {
                let value = model.scatter_far(&hit(tint, 0.0), a);
                if a.phi.abs() > std::f32::consts::FRAC_PI_2 { value } else { Vec3::ZERO }
            });
            if degrees == 40.0 && name != "sadeghi_normalised" {
                for k in 0..3 {
                    let off = (f64::from(half.forward.albedo[k]) - wanted[k]).abs();
                    assert!(off < 0.01, "{name}: forward {} is not {:?}", half.forward.albedo, wanted);
                }
            }
        }
    }
    // TT continues forwards, on the specular cone minus the tilt.
    let smooth = Fibre::Chiang(Chiang::new([0.1; 2], 2f32.to_radians(), 1.55, None));
    let half = Albedos::new(&smooth).hemispherical(0.0, Vec3::ONE).forward;
    assert!((half.shift.to_degrees() + 2.0).abs() < 2.5 && half.width < 0.4, "{half:?}");
}
