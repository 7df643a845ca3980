//! The film: the finished image as named planes, and its processing after rendering.
//!
//! [`filter`] gives the weights with which samples become pixels, [`depth_of_field`] and
//! [`composite`] change the film, [`cryptomatte`] adds mattes, and [`io`] writes and reads it
//! (through [`exr`], [`png`], [`primaries`] and [`tonemap`]) with its [`metadata`]; [`tev`] shows
//! it.

pub mod composite;
pub mod cryptomatte;
pub mod depth_of_field;
pub mod exposure;
pub mod exr;
pub mod filter;
mod formats;
pub mod io;
mod limits;
pub mod metadata;
pub mod png;
pub mod primaries;
pub mod resample;
pub mod tev;
pub mod tonemap;

pub use metadata::Metadata;

use crate::{Error, Result};

/// The largest half float.
pub const LARGEST_HALF: f32 = 65504.0;

/// An image of named planes, row by row from the top, `width * height` values each.
///
/// `R G B` are linear and premultiplied by `A`; the others are named as pbrt's film and Blender
/// name theirs: `guard.R`, `undercoat.R`, `base.R` (premultiplied contributions that add up to
/// `R G B`), `depth.Z` (cm along the viewing direction, infinity where there is nothing),
/// `Albedo.R`, `N.X`, `P.X`, `Tangent.X`, `transmittance.Y`, `fragments.Y`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Film {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// The planes: at least `R G B A`.
    pub planes: Vec<Plane>,
}

/// One plane of a [`Film`].
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// Name of the channel in an EXR file.
    pub name: String,
    /// Written as 32-bit float (depth, position, normals, counts) instead of half.
    pub full_precision: bool,
    /// The values.
    pub data: Vec<f32>,
}

impl Film {
    /// A film with the planes `R G B A`, all zero.
    pub fn new(width: u32, height: u32) -> Self {
        let mut film = Self { width, height, planes: Vec::new() };
        for name in ["R", "G", "B", "A"] {
            film.push(name, false, vec![0.0; film.pixels()]);
        }
        film
    }

    /// A film with the planes `R G B A` of premultiplied linear pixels, row by row from the top.
    /// Missing pixels are transparent black.
    pub fn from_premultiplied(width: u32, height: u32, pixels: &[[f32; 4]]) -> Self {
        let mut film = Self::new(width, height);
        for (c, plane) in film.planes.iter_mut().enumerate() {
            plane.data.iter_mut().zip(pixels).for_each(|(to, from)| *to = from[c]);
        }
        film
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Adds a plane; `data` has [`Film::pixels`] values.
    pub fn push(&mut self, name: impl Into<String>, full_precision: bool, data: Vec<f32>) {
        self.planes.push(Plane { name: name.into(), full_precision, data });
    }

    /// The planes `R G B A` as premultiplied linear pixels.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if a plane is missing or has the wrong number of values.
    pub fn premultiplied(&self) -> Result<Vec<[f32; 4]>> {
        self.validate()?;
        let mut pixels = vec![[0.0; 4]; self.pixels()];
        for (c, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
            let plane = self.plane(name).ok_or_else(|| {
                Error::Unsupported(format!("found no plane {name} in the film, expected R, G, B and A"))
            })?;
            pixels.iter_mut().zip(plane).for_each(|(to, from)| to[c] = *from);
        }
        Ok(pixels)
    }

    /// Writes premultiplied linear pixels back to the planes `R G B A`, as far as they exist.
    pub fn set_premultiplied(&mut self, pixels: &[[f32; 4]]) {
        for (c, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
            if let Some(plane) = self.plane_mut(name) {
                plane.iter_mut().zip(pixels).for_each(|(to, from)| *to = from[c]);
            }
        }
    }

    /// Checks that the film has pixels, that each plane has as many values, and that names are
    /// unique.
    ///
    /// # Errors
    /// [`Error::Unsupported`] with the plane and both counts.
    pub fn validate(&self) -> Result<()> {
        if self.pixels() == 0 {
            return Err(Error::Unsupported(format!(
                "found a film of {} x {} pixels, expected one or more pixels",
                self.width, self.height
            )));
        }
        for (i, plane) in self.planes.iter().enumerate() {
            if plane.data.len() != self.pixels() {
                return Err(Error::Unsupported(format!(
                    "found plane {} with {} values, expected {} ({} x {})",
                    plane.name,
                    plane.data.len(),
                    self.pixels(),
                    self.width,
                    self.height
                )));
            }
            if self.planes[..i].iter().any(|other| other.name == plane.name) {
                return Err(Error::Unsupported(format!(
                    "found two planes called {} in the film, expected unique names",
                    plane.name
                )));
            }
        }
        Ok(())
    }

    /// Number of pixels of which a channel `R G B` is, or will be, cut at the largest half float
    /// (65504).
    pub fn cut_pixels(&self) -> usize {
        let halves = |name| self.planes.iter().find(|p| p.name == name && !p.full_precision);
        let planes: Vec<_> = ["R", "G", "B"].into_iter().filter_map(halves).collect();
        // Samples were cut before they were summed to pixels, with rounding.
        (0..self.pixels()).filter(|i| planes.iter().any(|p| p.data[*i].abs() > 65_500.0)).count()
    }

    /// The plane called `name`.
    pub fn plane(&self, name: &str) -> Option<&[f32]> {
        self.planes.iter().find(|p| p.name == name).map(|p| p.data.as_slice())
    }

    /// The plane called `name`, mutable.
    pub fn plane_mut(&mut self, name: &str) -> Option<&mut [f32]> {
        self.planes.iter_mut().find(|p| p.name == name).map(|p| p.data.as_mut_slice())
    }
}
