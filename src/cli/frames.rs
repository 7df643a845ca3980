//! Ranges of frames on the command line, and the names of their files.

use pelage::scene::Animation;
use pelage::{Error, Result};
use std::path::{Path, PathBuf};

/// Frames to render, from 1, both ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Frames {
    first: u32,
    /// `None`: to the end of the animation.
    last: Option<u32>,
}

impl Frames {
    /// The numbers, in order.
    ///
    /// # Errors
    /// [`Error::Usage`] if an open range begins after the end of the animation.
    pub fn numbers(self, animation: &Animation) -> Result<std::ops::RangeInclusive<u32>> {
        let last = self.last.unwrap_or(animation.frames);
        if self.first > last {
            return Err(Error::Usage(format!(
                "--frames {}..: the animation has only {last} frames; begin earlier, or set animation.frames",
                self.first
            )));
        }
        Ok(self.first..=last)
    }
}

/// `N` (the first N), `A..B` (both included) or `A..` (to the end).
pub(super) fn frames(text: &str) -> Result<Frames, String> {
    let expected =
        || format!("expected N, A..B or A.. with 1 <= A <= B, at most {MOST} frames, found {text:?}");
    let number =
        |t: &str| t.trim().parse::<u32>().ok().filter(|n| (1..=MOST).contains(n)).ok_or_else(expected);
    let frames = match text.split_once("..") {
        None => Frames { first: 1, last: Some(number(text)?) },
        Some((first, last)) if last.trim().is_empty() => Frames { first: number(first)?, last: None },
        Some((first, last)) => Frames { first: number(first)?, last: Some(number(last)?) },
    };
    if frames.last.is_some_and(|last| last < frames.first) { Err(expected()) } else { Ok(frames) }
}

const MOST: u32 = 9_999_999;

/// `fur.png` of frame 7 is `fur_0007.png`.
pub(super) fn numbered(path: &Path, frame: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("_{frame:04}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_frames() {
        let numbers = |text: &str| {
            let animation = Animation { frames: 12, ..Animation::default() };
            frames(text).map(|f| f.numbers(&animation).map(|r| (*r.start(), *r.end())).ok())
        };
        assert_eq!(numbers("5"), Ok(Some((1, 5))));
        assert_eq!(numbers("10..20"), Ok(Some((10, 20))));
        assert_eq!(numbers("7..7"), Ok(Some((7, 7))));
        assert_eq!(numbers("9.."), Ok(Some((9, 12))));
        assert_eq!(numbers("13.."), Ok(None));
        for bad in ["", "0", "0..3", "4..3", "..", "..5", "-1", "1..x", "1...3", "10000000"] {
            assert!(frames(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn names_of_frames() {
        assert_eq!(numbered(Path::new("a/fur.png"), 7), Path::new("a/fur_0007.png"));
        assert_eq!(numbered(Path::new("fur.v2.exr"), 12_345), Path::new("fur.v2_12345.exr"));
    }
}
