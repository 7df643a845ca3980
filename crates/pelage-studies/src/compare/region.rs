//! The pixels of the silhouette and of the inside.

/// A part of an image, by the reference's alpha.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Region {
    /// All pixels.
    #[default]
    All,
    /// Pixels near the outline, where alpha crosses one half.
    Silhouette,
    /// Pixels within the outline, without the silhouette.
    Inside,
}

impl std::fmt::Display for Region {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::All => "all",
            Self::Silhouette => "silhouette",
            Self::Inside => "inside",
        })
    }
}

/// One value per pixel; `None` if a region has no pixels.
pub(super) struct Masks {
    pub silhouette: Option<Vec<bool>>,
    pub inside: Option<Vec<bool>>,
}

/// Outline points lie halfway between neighbouring pixels whose alphas are on different sides of
/// one half. The silhouette is all pixels within `band` pixels of such a point.
pub(super) fn masks(reference: &[[f32; 4]], [width, height]: [usize; 2], band: f64) -> Masks {
    let covered: Vec<bool> = reference.iter().map(|p| p[3] >= 0.5).collect();
    let mut silhouette = vec![false; covered.len()];
    let mut mark = |x: f64, y: f64| {
        let range = |at: f64, size: usize| {
            let last = (at + band).floor().clamp(0.0, size as f64 - 1.0);
            (at - band).ceil().max(0.0) as usize..last as usize + 1
        };
        for row in range(y, height) {
            for column in range(x, width) {
                let (dx, dy) = (column as f64 - x, row as f64 - y);
                if dx * dx + dy * dy <= band * band {
                    silhouette[row * width + column] = true;
                }
            }
        }
    };
    for y in 0..height {
        for x in 0..width {
            let here = covered[y * width + x];
            if x + 1 < width && covered[y * width + x + 1] != here {
                mark(x as f64 + 0.5, y as f64);
            }
            if y + 1 < height && covered[(y + 1) * width + x] != here {
                mark(x as f64, y as f64 + 0.5);
            }
        }
    }
    let inside: Vec<bool> = covered.iter().zip(&silhouette).map(|(c, s)| *c && !*s).collect();
    let some = |mask: Vec<bool>| mask.contains(&true).then_some(mask);
    Masks { silhouette: some(silhouette), inside: some(inside) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_silhouette_is_as_wide_as_asked() {
        let disc: Vec<[f32; 4]> = (0..64 * 48)
            .map(|i| {
                let (x, y) = ((i % 64) as f32 - 32.0, (i / 64) as f32 - 24.0);
                [0.0, 0.0, 0.0, if x.hypot(y) < 15.0 { 1.0 } else { 0.2 }]
            })
            .collect();
        let Masks { silhouette, inside } = masks(&disc, [64, 48], 4.0);
        let (silhouette, inside) = (silhouette.unwrap(), inside.unwrap());
        for i in 0..64 * 48 {
            let radius = ((i % 64) as f32 - 32.0).hypot((i / 64) as f32 - 24.0);
            match radius {
                r if (12.0..18.0).contains(&r) => assert!(silhouette[i] && !inside[i], "{r}"),
                r if r < 9.5 => assert!(!silhouette[i] && inside[i], "{r}"),
                r if r > 20.5 => assert!(!silhouette[i] && !inside[i], "{r}"),
                _ => assert!(!(silhouette[i] && inside[i])),
            }
        }
        let opaque = masks(&[[0.0, 0.0, 0.0, 1.0]; 12], [4, 3], 4.0);
        assert!(opaque.silhouette.is_none() && opaque.inside.unwrap().iter().all(|p| *p));
        assert!(masks(&[[0.0; 4]; 12], [4, 3], 4.0).inside.is_none());
    }
}
