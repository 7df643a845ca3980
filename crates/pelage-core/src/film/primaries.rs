//! Colour spaces of images: their primaries and white point, and conversions between them.

use super::Film;
use crate::scene::OutputSpace;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Primaries and white point of a linear RGB space, CIE xy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primaries {
    /// Red, green and blue.
    pub rgb: [[f32; 2]; 3],
    /// White.
    pub white: [f32; 2],
}

/// ITU-R BT.709 with the white point D65: what linear RGB means in this program.
// [BT709]
pub const REC709: Primaries =
    Primaries { rgb: [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06]], white: [0.3127, 0.329] };

/// AP1, the primaries of ACEScg, with the white point of ACES.
// [S-2014-004]
pub const AP1: Primaries =
    Primaries { rgb: [[0.713, 0.293], [0.165, 0.83], [0.128, 0.044]], white: [0.321_68, 0.337_67] };

/// Largest difference of a coordinate at which two spaces count as the same: files give three or
/// four digits.
const SAME: f32 = 1e-3;

impl Primaries {
    /// The primaries of a scene's colour space.
    pub fn of(space: OutputSpace) -> Self {
        match space {
            OutputSpace::Rec709 => REC709,
            OutputSpace::Acescg => AP1,
        }
    }

    fn coordinates(&self) -> impl Iterator<Item = f32> {
        self.rgb.into_iter().chain([self.white]).flatten()
    }

    /// Whether the two are the same up to the rounding of files.
    pub fn is(&self, other: &Self) -> bool {
        self.coordinates().zip(other.coordinates()).all(|(a, b)| (a - b).abs() <= SAME)
    }

    /// The matrix from linear RGB to XYZ, white to Y = 1; `None` where the primaries lie on a line.
    fn xyz_from_rgb(&self) -> Option<DMat3> {
        let column = |[x, y]: [f32; 2]| {
            let (x, y) = (f64::from(x), f64::from(y));
            DVec3::new(x, y, 1.0 - x - y)
        };
        let [r, g, b] = self.rgb.map(column);
        let white = xyz_of_white(self.white)?;
        // Not divided by y, which may be 0: XYZ is such a space itself.
        let primaries = DMat3::from_cols(r, g, b);
        let usable = primaries.determinant().abs() > 1e-6;
        let scale = usable.then(|| primaries.inverse() * white)?;
        Some(primaries * DMat3::from_diagonal(scale))
    }

    /// The matrix from linear RGB of this space to that of another one, so that white stays white;
    /// `None` where one of the two is no space: its primaries on a line, its white without
    /// luminance, or a coordinate that is not a finite number.
    pub fn to(&self, other: &Self) -> Option<DMat3> {
        let (from, to) = (self.xyz_from_rgb()?, other.xyz_from_rgb()?);
        let adapted = adaptation(xyz_of_white(self.white)?, xyz_of_white(other.white)?);
        let matrix = to.inverse() * adapted * from;
        matrix.is_finite().then_some(matrix)
    }
}

impl std::fmt::Display for Primaries {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [r, g, b] = self.rgb;
        write!(f, "red {r:?}, green {g:?}, blue {b:?}, white {:?}", self.white)
    }
}

/// XYZ of a white with Y = 1.
fn xyz_of_white([x, y]: [f32; 2]) -> Option<DVec3> {
    let (x, y) = (f64::from(x), f64::from(y));
    (x.is_finite() && y > 1e-6).then(|| DVec3::new(x / y, 1.0, (1.0 - x - y) / y))
}

/// The matrix that adapts XYZ seen under one white to another one, by the Bradford cone responses.
// [Lam1985]
fn adaptation(from: DVec3, to: DVec3) -> DMat3 {
    let cones =
        DMat3::from_cols_array(&[0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296]);
    let gain = (cones * to) / (cones * from);
    cones.inverse() * DMat3::from_diagonal(gain) * cones
}

/// Names of the layers of a film that are colours: those with planes R, G and B, without mattes.
fn colored(film: &Film) -> Vec<String> {
    let prefix =
        |name: &str| name.strip_suffix('R').filter(|p| p.is_empty() || p.ends_with('.')).map(str::to_owned);
    let is_matte = |prefix: &str| {
        let layer = prefix.trim_end_matches('.').rsplit('.').next().unwrap_or_default();
        layer.to_lowercase().starts_with("crypto")
    };
    film.planes
        .iter()
        .filter_map(|plane| prefix(&plane.name))
        .filter(|p| !is_matte(p) && ["G", "B"].iter().all(|c| film.plane(&format!("{p}{c}")).is_some()))
        .collect()
}

/// Converts all colours of a film: the planes `R G B`, alone or of a layer. Depth, normals and
/// other data, alpha and mattes stay. A colour that is not finite in all three channels stays too.
pub fn convert(film: &mut Film, matrix: &DMat3) {
    for prefix in colored(film) {
        let index = |c: &str| film.planes.iter().position(|p| p.name == format!("{prefix}{c}"));
        let (Some(r), Some(g), Some(b)) = (index("R"), index("G"), index("B")) else { continue };
        let Ok([r, g, b]) = film.planes.get_disjoint_mut([r, g, b]) else { continue };
        let pixels = r.data.par_iter_mut().zip(&mut g.data).zip(&mut b.data);
        pixels.for_each(|((r, g), b)| {
            let color = DVec3::new((*r).into(), (*g).into(), (*b).into());
            if color.is_finite() {
                [*r, *g, *b] = (*matrix * color).as_vec3().to_array();
            }
        });
    }
}
