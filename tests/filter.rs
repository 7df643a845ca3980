//! Reconstruction filters.

use crate::common::cases;
use pelage_core::Error;
use pelage_core::film::filter;
use pelage_core::scene::Filter;
use proptest::prelude::*;

const FILTERS: [Filter; 4] = [Filter::Box, Filter::Triangle, Filter::Gaussian, Filter::Mitchell];

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn sample_weights_are_symmetric_and_add_up_to_one(
        which in 0usize..4, radius in 0.01f32..4.0, k in 1u32..17,
    ) {
        let filter = FILTERS[which];
        let (margin, weights) = filter::sample_weights(filter, radius, k).unwrap();
        prop_assert_eq!(weights.len() as u32, k + 2 * margin);
        prop_assert_eq!(weights.iter().sum::<f32>(), 1.0);
        prop_assert_eq!(weights.iter().rev().sum::<f32>(), 1.0);
        for i in 0..weights.len() {
            prop_assert_eq!(weights[i], weights[weights.len() - 1 - i]);
        }
        // In proportion to the filter itself, to two units of 2^-22.
        let (radius, k_real) = (f64::from(radius), f64::from(k));
        let at = |i: usize| (i as f64 - f64::from(margin) + 0.5) / k_real - 0.5;
        let raw: Vec<f64> = (0..weights.len()).map(|i| filter::weight_1d(filter, radius, at(i))).collect();
        let sum: f64 = raw.iter().sum();
        if sum > 0.0 {
            for (w, r) in weights.iter().zip(&raw) {
                prop_assert!((f64::from(*w) - r / sum).abs() < 2.01 / 4_194_304.0, "{} {}", w, r / sum);
            }
        }
    }
}

#[test]
fn filters_have_their_known_values() {
    assert_eq!(filter::sample_weights(Filter::Box, 0.5, 4).unwrap(), (0, vec![0.25; 4]));
    assert_eq!(filter::sample_weights(Filter::Triangle, 1.0, 1).unwrap(), (0, vec![1.0]));
    let (margin, weights) = filter::sample_weights(Filter::Triangle, 1.0, 2).unwrap();
    assert_eq!((margin, weights), (1, vec![0.125, 0.375, 0.375, 0.125]));
    let gaussian = (-2.0f64).exp() - (-4.5f64).exp();
    let center = 1.0 - (-4.5f64).exp();
    let value = filter::weight(Filter::Gaussian, 1.5, 1.0, 0.0);
    assert!((f64::from(value) - gaussian * center).abs() < 1e-6, "sigma is 0.5: {value}");
    // Mitchell: 8/9 at the centre, 1/18 at 1, negative between 1 and 2.
    let root = filter::weight(Filter::Mitchell, 2.0, 0.0, 0.0).sqrt();
    assert!((root - 8.0 / 9.0).abs() < 1e-6);
    assert!((filter::weight(Filter::Mitchell, 2.0, 1.0, 0.0) / root - 1.0 / 18.0).abs() < 1e-6);
    assert!(filter::weight(Filter::Mitchell, 2.0, 1.5, 0.0) < 0.0);
    assert_eq!(filter::sample_weights(Filter::Mitchell, 2.0, 4).unwrap().0, 6);
    for (radius, k) in [(0.0, 4), (f32::NAN, 4), (17.0, 4), (1.0, 0), (1.0, 65)] {
        assert!(matches!(filter::sample_weights(Filter::Box, radius, k), Err(Error::Usage(_))));
    }
}
