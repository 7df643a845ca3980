//! HAIR files: written files read back the same, and damaged files are errors.

use crate::common::{assets, cases};
use glam::Vec3;
use pelage_core::hair::HairFile;
use proptest::prelude::*;

fn sample(segments: Vec<u16>, arrays: bool) -> HairFile {
    let points: usize = segments.iter().map(|s| usize::from(*s) + 1).sum();
    let array = |f: f32| if arrays { (0..points).map(|i| f * i as f32).collect() } else { Vec::new() };
    HairFile {
        points: (0..points).map(|i| Vec3::new(i as f32, 0.5 * i as f32, -1.0)).collect(),
        segments,
        thickness: array(0.001),
        transparency: array(0.01),
        colors: array(0.1).into_iter().map(Vec3::splat).collect(),
        default_thickness: 0.007,
        default_transparency: 0.25,
        default_color: Vec3::new(0.1, 0.2, 0.3),
        info: "a test".into(),
    }
}

fn bytes_of(hair: &HairFile) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("a.hair");
    std::fs::write(&path, "old").expect("writable");
    hair.write(&path).expect("written");
    assert_eq!(std::fs::read_dir(folder.path()).expect("folder").count(), 1, "no temporary file stays");
    assert_eq!(&HairFile::read(&path).expect("read again"), hair);
    std::fs::read(&path).expect("readable")
}

#[test]
fn written_files_read_back() {
    // Uniform strands without arrays take the header and the points only.
    assert_eq!(bytes_of(&sample(vec![4; 10], false)).len(), 128 + 50 * 12);
    assert_eq!(bytes_of(&sample(vec![4, 2, 0], true)).len(), 128 + 3 * 2 + 9 * (12 + 4 + 4 + 12));
    assert_eq!(bytes_of(&HairFile::default()).len(), 128);
    let mut strands = sample(vec![2, 1], false);
    strands.info = "ä".repeat(60);
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("a.hair");
    strands.write(&path).expect("written");
    let again = HairFile::read(&path).expect("read again");
    assert_eq!(again.info, "ä".repeat(44), "cut at 88 bytes");
    let firsts: Vec<(usize, usize)> = again.strands().map(|(first, points)| (first, points.len())).collect();
    assert_eq!(firsts, [(0, 3), (3, 2)]);
}

#[test]
fn the_header_is_as_documented() {
    let bytes = bytes_of(&sample(vec![4, 2, 0], true));
    let word = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
    assert_eq!(&bytes[..4], b"HAIR");
    assert_eq!((word(4), word(8), word(12), word(16)), (3, 9, 31, 4));
    assert_eq!(f32::from_bits(word(20)), 0.007);
    assert_eq!(f32::from_bits(word(36)), 0.3);
    assert_eq!(&bytes[40..47], b"a test\0");
    assert_eq!(&bytes[128..134], [4, 0, 2, 0, 0, 0]);
}

#[test]
fn forged_and_truncated_files_are_errors() {
    let good = bytes_of(&sample(vec![4; 10], false));
    let arrays = bytes_of(&sample(vec![4, 2, 0], true));
    let forged = |bytes: &[u8], at: usize, word: u32| {
        let mut bytes = bytes.to_vec();
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        bytes
    };
    let rows = [
        (vec![], "begin with the letters HAIR"),
        (b"HAIR".to_vec(), "expected a header of 128"),
        (good[..127].to_vec(), "found 127 bytes"),
        (good[..good.len() - 1].to_vec(), "truncated or forged: found 727 bytes, expected 728"),
        ([good.as_slice(), b"x"].concat(), "too long"),
        (forged(&good, 8, u32::MAX), "truncated or forged"),
        (forged(&good, 4, u32::MAX), "expected 4294967295 strands of 4 segments"),
        (forged(&good, 4, 9), "expected 9 strands of 4 segments"),
        (forged(&good, 16, 70000), "70000 segments"),
        (forged(&good, 12, 0), "without a point array"),
        (forged(&good, 128, f32::NAN.to_bits()), "point 0"),
        (forged(&arrays, 128, 0x0002_0005), "expected 10"),
        (forged(&arrays, 4, u32::MAX), "truncated or forged"),
    ];
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("forged.hair");
    for (bytes, wanted) in rows {
        std::fs::write(&path, &bytes).expect("writable");
        let error = HairFile::read(&path).expect_err(wanted);
        assert_eq!(error.exit_code(), 3);
        let message = error.to_string();
        assert!(
            message.contains(wanted) && message.contains("forged.hair"),
            "{wanted:?} is not in {message}"
        );
    }
    assert_eq!(HairFile::read(&folder.path().join("missing")).expect_err("missing").exit_code(), 1);

    let mut uneven = sample(vec![4; 10], true);
    uneven.thickness.pop();
    assert!(uneven.write(&path).expect_err("uneven").to_string().contains("49 values of thickness"));
    uneven = sample(vec![4; 10], false);
    uneven.points.pop();
    assert!(uneven.write(&path).expect_err("uneven").to_string().contains("expected 50"));
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn no_bytes_make_the_reader_panic(tail in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = HairFile::from_bytes(&tail);
        let _ = HairFile::from_bytes(&[b"HAIR", tail.as_slice()].concat());
    }
}

#[test]
fn the_straight_hair_model_reads() {
    let Some(folder) = assets() else { return };
    let hair = HairFile::read(&folder.join("hair/straight.hair")).expect("straight.hair");
    assert_eq!((hair.segments.len(), hair.points.len(), hair.colors.len()), (10_000, 160_000, 160_000));
    assert!(hair.segments.iter().all(|s| *s == 15));
    assert!(hair.thickness.is_empty() && hair.transparency.is_empty());
    assert!((hair.default_thickness - 0.1).abs() < 1e-6, "{}", hair.default_thickness);
    assert!(hair.info.starts_with("Hair model file generated by Cem Yuksel"), "{}", hair.info);
}
