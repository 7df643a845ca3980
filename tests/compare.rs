//! Every metric: zero for equal images, the right value where it is known, and a failure where it
//! should fail.

use pelage_core::Error;
use pelage_core::film::Film;
use pelage_fur::random::random;
use pelage_studies::compare::{
    ErrorImage, METRICS, Options, Region, Thresholds, compare, compare_with, error_image,
};

fn picture() -> Film {
    let pixels: Vec<[f32; 4]> = (0..48 * 32)
        .map(|i| {
            let (x, y) = ((i % 48) as f32, (i / 48) as f32);
            let v = 0.3 + 0.25 * (x * 0.7).sin() * (y * 0.5).cos();
            [v, v * 0.8, 0.1 + 0.01 * y, 1.0]
        })
        .collect();
    Film::from_premultiplied(48, 32, &pixels)
}

fn changed(change: impl Fn(usize, [f32; 4]) -> [f32; 4]) -> Film {
    let pixels: Vec<[f32; 4]> =
        picture().premultiplied().unwrap().into_iter().enumerate().map(|(i, p)| change(i, p)).collect();
    Film::from_premultiplied(48, 32, &pixels)
}

fn shifted() -> Film {
    let pixels = picture().premultiplied().unwrap();
    changed(|i, _| pixels[i / 48 * 48 + (i % 48 + 2) % 48])
}

fn noisy() -> Film {
    changed(|i, [r, g, b, a]| {
        let noise = ((i as u32).wrapping_mul(2_654_435_761) >> 16) as f32 / 65536.0 * 0.2 - 0.1;
        [r + noise, g + noise, b + noise, a]
    })
}

fn brighter() -> Film {
    changed(|_, [r, g, b, a]| [r * 1.2, g * 1.2, b * 1.2, a])
}

fn strict() -> Thresholds {
    Thresholds {
        rmse: Some(1e-9),
        relative_mse: Some(1e-9),
        psnr: Some(200.0),
        ssim: Some(1.0 - 1e-9),
        flip: Some(1e-9),
        hdr_flip: Some(1e-9),
        luminance_ratio: Some(1e-9),
        color_ratio: Some(1e-9),
        detail_ratio: Some(1e-9),
        alpha_difference: Some(1e-9),
        max_abs: Some(1e-9),
    }
}

#[test]
fn equal_pictures_have_no_difference() {
    let c = compare(&picture(), &picture()).unwrap();
    let m = &c.all;
    assert_eq!((m.rmse, m.relative_mse, m.flip, m.max_abs, m.alpha_difference), (0.0, 0.0, 0.0, 0.0, 0.0));
    assert_eq!((m.psnr, m.luminance_ratio, m.hdr_flip), (f64::INFINITY, 1.0, 0.0));
    assert_eq!((m.color_ratio, m.detail_ratio), ([1.0; 3], [1.0; 4]));
    assert!((m.ssim - 1.0).abs() < 1e-9);
    assert_eq!(c.exceeds(&strict()), None);
    assert!(serde_json::to_string(&c).unwrap().contains("\"psnr\":null"));
    assert!(c.to_string().contains("RMSE                  0.000000"), "{c}");
}

#[test]
fn small_pictures_have_the_values_computed_by_hand() {
    let a = Film::from_premultiplied(2, 1, &[[0.5, 0.2, 0.0, 1.0], [0.3, 0.3, 0.3, 0.5]]);
    let b = Film::from_premultiplied(2, 1, &[[0.3, 0.2, 0.1, 1.0], [0.3, 0.3, 0.3, 0.25]]);
    let c = compare(&a, &b).unwrap().all;
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} {b}");
    near(c.rmse, f64::sqrt((0.04 + 0.01) / 6.0));
    near(c.relative_mse, (0.04 / (0.09 + 0.01) + 0.01 / (0.01 + 0.01)) / 6.0);
    near(c.max_abs, 0.2);
    near(c.alpha_difference, 0.125);
    let (la, lb) = (0.2126 * 0.5 + 0.7152 * 0.2 + 0.3, 0.2126 * 0.3 + 0.7152 * 0.2 + 0.0722 * 0.1 + 0.3);
    near(c.luminance_ratio, la / lb);
    [0.8 / 0.6, 1.0, 0.3 / 0.4]
        .into_iter()
        .zip(c.color_ratio)
        .for_each(|(wanted, found)| near(found, wanted));
    // SSIM of two constant pictures is the luminance term alone.
    let constant = |code: f32| {
        let v = pelage_core::film::tonemap::srgb_decode(code);
        Film::from_premultiplied(13, 13, &vec![[v, v, v, 1.0]; 169])
    };
    let c = compare(&constant(0.4), &constant(0.6)).unwrap().all;
    near(c.ssim, (2.0 * 0.24 + 1e-4) / (0.16 + 0.36 + 1e-4));
    near(c.psnr, -20.0 * 0.2f64.log10());
}

#[test]
fn every_metric_fails_on_a_wrong_picture() {
    for (name, wrong) in [("shifted", shifted()), ("noisy", noisy()), ("brighter", brighter())] {
        let c = compare(&wrong, &picture()).unwrap();
        let found = c.exceeds(&strict()).unwrap();
        for metric in ["RMSE", "relative MSE", "PSNR", "SSIM", "\nFLIP", "HDR-FLIP", "largest difference"] {
            assert!(found.contains(metric), "{name}: {metric} did not notice\n{found}");
        }
        let m = &c.all;
        assert!(m.rmse > 0.01 && m.flip > 0.02 && m.hdr_flip >= 0.02, "{name}:\n{c}");
        assert!(m.ssim < 0.995 && m.psnr < 40.0, "{name}:\n{c}");
    }
    let bright = compare(&brighter(), &picture()).unwrap().all;
    assert!((bright.luminance_ratio - 1.2).abs() < 1e-5);
    assert!(bright.color_ratio.iter().all(|ratio| (ratio - 1.2).abs() < 1e-5));
    let found = compare(&brighter(), &picture()).unwrap().exceeds(&strict()).unwrap();
    assert!(found.contains("luminance ratio") && found.contains("colour ratio G"), "{found}");
    let see_through = changed(|_, [r, g, b, _]| [r, g, b, 0.9]);
    let c = compare(&see_through, &picture()).unwrap();
    assert!(c.exceeds(&strict()).unwrap().contains("alpha difference") && c.all.rmse == 0.0);
    // Structure: noise of the same energy as a change of brightness costs more SSIM.
    let noise = compare(&noisy(), &picture()).unwrap().all;
    assert!(noise.ssim < bright.ssim, "{} {}", noise.ssim, bright.ssim);
}

#[test]
fn limits_that_hold_are_silent() {
    let c = compare(&noisy(), &picture()).unwrap();
    assert_eq!(c.exceeds(&Thresholds::default()), None);
    assert_eq!(c.exceeds(&Thresholds { rmse: Some(1.0), psnr: Some(1.0), ..Thresholds::default() }), None);
}

#[test]
fn values_that_are_not_finite_are_counted_and_fail() {
    let broken = changed(|i, p| match i {
        5 => [f32::NAN, p[1], p[2], p[3]],
        9 => [p[0], f32::INFINITY, p[2], p[3]],
        _ => p,
    });
    let c = compare(&broken, &picture()).unwrap();
    assert_eq!((c.non_finite_image, c.non_finite_reference, c.all.rmse), (2, 0, 0.0));
    assert!(c.exceeds(&Thresholds::default()).unwrap().contains("2 pixels of the image"));
    let nothing = Film::from_premultiplied(1, 1, &[[f32::NAN; 4]]);
    let c = compare(&nothing, &nothing).unwrap();
    assert!(c.exceeds(&strict()).unwrap().contains("RMSE is undefined"));
}

#[test]
fn sizes_must_match() {
    let error = compare(&picture(), &Film::new(10, 20)).unwrap_err();
    assert!(matches!(error, Error::Unsupported(_)));
    let text = error.to_string();
    assert!(text.contains("48 x 32") && text.contains("10 x 20"), "{text}");
    assert!(matches!(compare(&Film::default(), &Film::default()), Err(Error::Unsupported(_))));
}

#[test]
fn error_images_show_where() {
    let wrong = changed(|i, p| if i == 10 * 48 + 20 { [2.0, 2.0, 2.0, 1.0] } else { p });
    let map = error_image(&wrong, &picture(), ErrorImage::Flip).unwrap();
    let brightness = |film: &Film, x: usize, y: usize| {
        let p = film.premultiplied().unwrap()[y * film.width as usize + x];
        p[0] + p[1] + p[2]
    };
    let (there, elsewhere) = (brightness(&map, 20, 10), brightness(&map, 45, 30));
    assert!(there > 0.2 && elsewhere < 0.01, "{there} {elsewhere}");
    let difference = error_image(&brighter(), &picture(), ErrorImage::Difference(5.0)).unwrap();
    let (p, q) = (difference.premultiplied().unwrap()[100], picture().premultiplied().unwrap()[100]);
    assert!((p[0] - q[0]).abs() < 1e-5, "0.2 of the value, times 5");
    let relative = error_image(&brighter(), &picture(), ErrorImage::Relative(1.0)).unwrap();
    let p = relative.premultiplied().unwrap()[100];
    assert!((p[0] - 0.2 * q[0] / (q[0] * q[0] + 0.01).sqrt()).abs() < 1e-5);
    let hdr = error_image(&wrong, &picture(), ErrorImage::HdrFlip).unwrap();
    let (there, elsewhere) = (brightness(&hdr, 20, 10), brightness(&hdr, 45, 30));
    assert!(there > 0.03 && elsewhere < 0.003, "{there} {elsewhere}");
}

/// A disc of fur: alpha 1 within 20 pixels of the middle of 80 x 80, light by `value` of the
/// distance to it.
fn disc(value: impl Fn(f32, usize) -> f32) -> Film {
    let pixels: Vec<[f32; 4]> = (0..80 * 80)
        .map(|i| {
            let radius = ((i % 80) as f32 - 39.5).hypot((i / 80) as f32 - 39.5);
            let v = value(radius, i);
            if radius < 20.0 { [v, v, v, 1.0] } else { [0.0; 4] }
        })
        .collect();
    Film::from_premultiplied(80, 80, &pixels)
}

#[test]
fn silhouette_and_inside_are_separate() {
    let reference = disc(|_, _| 0.5);
    let rim = compare(&disc(|r, _| if r > 18.0 { 0.25 } else { 0.5 }), &reference).unwrap();
    let (silhouette, inside) = (rim.silhouette.as_ref().unwrap(), rim.inside.as_ref().unwrap());
    assert_eq!(inside.rmse, 0.0);
    assert!(silhouette.rmse > 1.5 * rim.all.rmse && silhouette.luminance_ratio < rim.all.luminance_ratio);
    assert_eq!(
        rim.exceeds_in(Region::Inside, &Thresholds { rmse: Some(0.0), ..Thresholds::default() }),
        None
    );
    let limit = Thresholds { luminance_ratio: Some(0.12), ..Thresholds::default() };
    assert!(rim.exceeds_in(Region::Silhouette, &limit).is_some() && rim.exceeds(&limit).is_none(), "{rim}");
    let core = compare(&core_fault(), &reference).unwrap();
    assert!(core.inside.as_ref().unwrap().rmse > 0.0);
    assert_eq!(core.silhouette.as_ref().unwrap().rmse, 0.0);
    // With a wider silhouette, the fault is in the silhouette.
    let wide =
        compare_with(&core_fault(), &reference, &Options { band: 19.0, ..Options::default() }).unwrap();
    assert!(wide.silhouette.unwrap().rmse > 0.0);
    let opaque = compare(&picture(), &picture()).unwrap();
    assert!(opaque.silhouette.is_none());
    assert!(opaque.exceeds_in(Region::Silhouette, &strict()).unwrap().contains("no pixels"));
    let text = rim.to_string();
    assert!(text.contains("silhouette") && text.contains("inside"), "{text}");
}

fn core_fault() -> Film {
    disc(|r, _| if r < 5.0 { 0.25 } else { 0.5 })
}

/// FLIP of an overexposed display misses the difference; HDR-FLIP also compares exposures that show
/// it.
#[test]
fn hdr_flip_sees_what_one_exposure_hides() {
    let bright = |v: f32| disc(move |_, i| if i % 3 == 0 { v } else { 8.0 });
    let c = compare(&bright(6.0), &bright(3.0)).unwrap();
    assert!(c.all.flip < 1e-6 && c.all.hdr_flip > 0.01, "{c}");
    let [from, to] = c.hdr_flip_exposures;
    assert!(from < -1.5 && to >= from, "{c}");
    let darker =
        compare_with(&bright(6.0), &bright(3.0), &Options { exposure: -3.5, ..Options::default() }).unwrap();
    assert!(darker.all.flip > 0.01, "{darker}");
    // HDR-FLIP chooses its exposures itself.
    assert!((darker.all.hdr_flip - c.all.hdr_flip).abs() < 1e-3, "{darker}");
    assert!((darker.all.luminance_ratio - c.all.luminance_ratio).abs() < 1e-6);
}

#[test]
fn a_soft_picture_lacks_fine_detail_and_a_noisy_one_has_too_much() {
    let random = |i: usize| ((i as u32).wrapping_mul(2_654_435_761) >> 16) as f32 / 65536.0;
    let sharp = disc(|_, i| 0.3 + 0.4 * random(i));
    let soft = disc(|_, i| 0.3 + 0.1 * [0, 1, 80, 81].into_iter().map(|k| random(i + k)).sum::<f32>());
    let inside = |a: &Film, b: &Film| compare(a, b).unwrap().inside.unwrap();
    let c = inside(&soft, &sharp);
    assert!(c.detail_ratio[0] < 0.5, "{:?}", c.detail_ratio);
    assert!((c.luminance_ratio - 1.0).abs() < 0.05);
    assert!(inside(&sharp, &soft).detail_ratio[0] > 2.0);
    // A change of brightness alone is not a change of detail.
    let bright = disc(|_, i| 2.0 * (0.3 + 0.4 * random(i)));
    assert!(inside(&bright, &sharp).detail_ratio.iter().all(|ratio| (ratio - 1.0).abs() < 1e-4));
}

#[test]
fn every_metric_has_a_limit() {
    assert!(METRICS.iter().all(|metric| (metric.limit)(&strict()).is_some()));
    assert!(METRICS.iter().all(|metric| (metric.limit)(&Thresholds::default()).is_none()));
}

/// A reference of two noisy halves has the detail of its mean, less the noise estimated from their
/// difference.
#[test]
fn noise_of_a_reference_is_no_detail() {
    let clean = disc(|_, i| 0.3 + 0.4 * random(1, i as u32));
    let half =
        |seed: u32| disc(move |_, i| 0.3 + 0.4 * random(1, i as u32) + 0.6 * (random(seed, i as u32) - 0.5));
    let (a, b) = (half(2), half(3));
    let (p, q) = (a.premultiplied().unwrap(), b.premultiplied().unwrap());
    let mean: Vec<[f32; 4]> = (0..p.len()).map(|i| [0, 1, 2, 3].map(|c| 0.5 * (p[i][c] + q[i][c]))).collect();
    let mut noisy = Film::from_premultiplied(80, 80, &mean);
    let as_detail = compare(&clean, &noisy).unwrap().inside.unwrap().detail_ratio[0];
    for (k, half) in [p, q].into_iter().enumerate() {
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            noisy.push(format!("half{k}.{name}"), true, half.iter().map(|v| v[c]).collect());
        }
    }
    let taken_off = compare(&clean, &noisy).unwrap().inside.unwrap().detail_ratio[0];
    assert!(as_detail < 0.65, "{as_detail}");
    assert!((taken_off - 1.0).abs() < 0.12, "{taken_off}");
    let other_way = compare(&noisy, &clean).unwrap().inside.unwrap().detail_ratio[0];
    assert!((other_way * taken_off - 1.0).abs() < 1e-9, "{other_way}");
}
