//! Limits of the images that are read, checked against headers before anything is allocated.

use crate::files::Failure;

/// Largest number of pixels of an image that is read: 16,384 x 16,384. Checked against the header
/// before anything is allocated.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Largest number of values (pixels times channels) of an image that is read: 4 GiB as 32-bit
/// floats.
pub const MAX_VALUES: u64 = 1 << 30;

/// Width, height and RGBA texels row by row from the top, with straight alpha.
pub(crate) type Texels = (u32, u32, Vec<[f32; 4]>);

/// Checks a header's size before anything of that size is allocated.
pub(super) fn check_size(width: u64, height: u64, channels: u64) -> Result<(), Failure> {
    if width == 0 || height == 0 {
        return Err(format!("found a header with {width} x {height} pixels, expected one or more").into());
    }
    let pixels = width.saturating_mul(height);
    if width > u64::from(u32::MAX) || height > u64::from(u32::MAX) || pixels > MAX_PIXELS {
        return Err(format!(
            "found a header with {width} x {height} pixels, expected at most the limit of {MAX_PIXELS} (16384 x 16384)"
        )
        .into());
    }
    if pixels.saturating_mul(channels) > MAX_VALUES {
        return Err(format!(
            "found a header with {width} x {height} pixels of {channels} channels, expected at most the limit of {MAX_VALUES} values"
        )
        .into());
    }
    Ok(())
}
