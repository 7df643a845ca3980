//! A camera that orbits the fur: an animated PNG, some of its frames, and the flicker of the
//! picture.

use super::super::{FigureContent, FigureContext};
use crate::report::Table;
use crate::report::plot::{Curve, Plot};
use glam::Vec3;
use pelage_core::assets::Assets;
use pelage_core::film::composite::over;
use pelage_core::film::tonemap::{display_rgb8, luminance, srgb_decode, srgb_encode};
use pelage_core::film::{Film, depth_of_field};
use pelage_core::scene::FilmSpec;
use pelage_core::{Error, Result, World, animation, files};
use serde::Deserialize;
use std::io::Write;
use std::path::Path;

/// File name of the video.
const FILE: &str = "orbit.png";
/// Code value of the encoded luminance 1.
const CODES: f64 = 255.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Scene file, relative to the figure's folder; its `[animation]` sets the number of frames,
    /// their rate and the angle.
    scene: String,
    /// Number of frames that are also shown as pictures.
    shown: u32,
    /// Frames of the flicker measurement; at least 3.
    steps: u32,
    /// Camera step between two of them, pixels.
    step: f32,
    /// Factor on the samples for the variant that shows what remains from motion alone.
    samples: u32,
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let (mut world, assets) = context.load(&settings.scene, &[])?;
    let mut content = FigureContent::default();
    video(context, &settings, &mut world, &assets, &mut content)?;
    flicker(context, &settings, world, &mut content)?;
    Ok(content)
}

/// Renders the orbit and writes the video.
fn video(
    context: &FigureContext,
    settings: &Settings,
    world: &mut World,
    assets: &Assets,
    content: &mut FigureContent,
) -> Result<()> {
    let scene = world.scene.clone();
    let frames = scene.animation.frames;
    let every = frames.div_ceil(settings.shown.max(1)).max(1);
    let mut pictures = Vec::new();
    for number in 1..=frames {
        world.scene.camera = animation::at(&scene, number).camera;
        let image = context.render_panel(&format!("frame {number}"), world, assets)?;
        pictures.push(codes(&image.film, &image.spec)?);
        if (number - 1) % every == 0 {
            content.images.push(image);
        }
    }
    world.scene = scene;
    let [width, height] = context.size();
    let bytes = animated(width, height, &pictures, world.scene.animation.fps)?;
    files::write_atomically(&context.out.join(FILE), |file| Ok(file.write_all(&bytes)?))?;
    content.files.push((FILE.into(), format!("The orbit, {frames} frames (an animated PNG)")));
    content.value("frames", f64::from(frames), 0.0);
    Ok(())
}

/// The 8-bit sRGB pixels of an opaque film.
fn codes(film: &Film, spec: &FilmSpec) -> Result<Vec<u8>> {
    Ok(film
        .premultiplied()?
        .iter()
        .flat_map(|&[r, g, b, _]| display_rgb8(Vec3::new(r, g, b), spec))
        .collect())
}

/// Frames as an animated PNG that repeats forever.
fn animated(width: u32, height: u32, frames: &[Vec<u8>], fps: f32) -> Result<Vec<u8>> {
    let encode = || -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_animated(frames.len().max(1) as u32, 0)?;
        encoder.set_frame_delay((1000.0 / fps).round().clamp(1.0, 65535.0) as u16, 1000)?;
        let mut writer = encoder.write_header()?;
        frames.iter().try_for_each(|frame| writer.write_image_data(frame))?;
        writer.finish()?;
        Ok(bytes)
    };
    encode().map_err(|e| Error::io(Path::new(FILE), std::io::Error::other(e)))
}

/// Sampling of successive frames.
struct Variant {
    name: String,
    samples: u32,
    /// Whether each frame has its own seed.
    seeds: bool,
}

/// Measures the flicker while the camera moves in small steps.
fn flicker(
    context: &FigureContext,
    settings: &Settings,
    mut world: World,
    content: &mut FigureContent,
) -> Result<()> {
    let spp = world.scene.film.spp;
    let variant = |name: String, samples, seeds| Variant { name, samples, seeds };
    let variants = [
        variant(format!("{spp} samples a pixel"), spp, false),
        variant(format!("{} samples", spp * settings.samples), spp * settings.samples, false),
        variant(format!("{spp} samples, a new seed each frame"), spp, true),
    ];
    let scene = world.scene.clone();
    // A point half the picture's height in front of the axis moves by this number of pixels.
    let step = (2.0 * settings.step / scene.film.height as f32).to_degrees();
    let mut plot = Plot {
        caption: format!("Flicker while the camera goes round in steps of {} pixels", settings.step),
        x: "frame".into(),
        y: "flicker, code values".into(),
        ..Plot::default()
    };
    let caption = format!(
        "Flicker over {} frames, {step:.4} degrees apart: root mean square over the fur's pixels, code values of 255.",
        settings.steps
    );
    let mut table = Table::new(caption, &["", "flicker", "by the first"], Vec::new());
    let mut first = f64::NAN;
    for variant in variants {
        let mut frames: Vec<Shown> = Vec::new();
        let mut curve = Curve::new(&variant.name, Vec::new());
        for k in 0..settings.steps.max(3) {
            world.scene = scene.clone();
            world.scene.film.spp = variant.samples;
            world.scene.animation.frames = 1;
            world.scene.animation.turntable = step;
            // Frame k + 1 of an animation of one frame is rotated by k whole turntables.
            world.scene.camera = animation::at(&world.scene, k + 1).camera;
            if variant.seeds {
                world.scene.render.seed = scene.render.seed.wrapping_add(k);
            }
            let mut frame = context.render(&world)?;
            depth_of_field::apply(&mut frame.film, &world.scene.camera)?;
            frames.push(Shown::of(&frame.film, &world.scene.film)?);
            if let [.., a, b, c] = &frames[..] {
                curve.points.push([f64::from(k), second_difference([a, b, c])]);
            }
        }
        let mean = curve.points.iter().map(|p| p[1]).sum::<f64>() / curve.points.len() as f64;
        first = if first.is_nan() { mean } else { first };
        context.report(&format!("flicker, {}: {mean:.3}", variant.name))?;
        table.rows.push(vec![variant.name.clone(), format!("{mean:.3}"), format!("{:.2}", mean / first)]);
        content.value(&format!("flicker, {}", variant.name), mean, 0.05 * mean);
        plot.curves.push(curve);
    }
    content.table(&table);
    content.plot("flicker", plot);
    Ok(())
}

/// The pixels of a displayed frame.
struct Shown {
    /// sRGB-encoded luminance over the background colour, 0..1.
    luminance: Vec<f32>,
    alpha: Vec<f32>,
}

impl Shown {
    fn of(film: &Film, spec: &FilmSpec) -> Result<Self> {
        let [r, g, b] = spec.background_color;
        let shown = |pixel: &[f32; 4]| {
            let [r, g, b, _] = over(*pixel, [r, g, b, 1.0]);
            let codes = display_rgb8(Vec3::new(r, g, b), spec);
            srgb_encode(luminance(Vec3::from(codes.map(|code| srgb_decode(f32::from(code) / 255.0)))))
        };
        let pixels = film.premultiplied()?;
        Ok(Self {
            luminance: pixels.iter().map(shown).collect(),
            alpha: pixels.iter().map(|p| p[3]).collect(),
        })
    }
}

/// Root mean square of the second difference in time, divided by the root of 6, over the pixels
/// that fur covers in the middle frame; in code values. For noise that is independent from frame to
/// frame it is the standard deviation; for a uniform change it is 0.
fn second_difference([a, b, c]: [&Shown; 3]) -> f64 {
    let (mut sum, mut count) = (0.0, 0u32);
    for (i, alpha) in b.alpha.iter().enumerate() {
        if *alpha > 0.0 {
            let d = f64::from(a.luminance[i]) - 2.0 * f64::from(b.luminance[i]) + f64::from(c.luminance[i]);
            (sum, count) = (sum + d * d, count + 1);
        }
    }
    CODES * (sum / 6.0 / f64::from(count.max(1))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_fur::random::random;

    fn frame(value: impl Fn(u32) -> f32) -> Shown {
        Shown { luminance: (0..4000).map(value).collect(), alpha: vec![1.0; 4000] }
    }

    #[test]
    fn noise_flickers_and_uniform_change_does_not() {
        let ramp = |k: u32| frame(move |i| 0.3 + 1e-4 * i as f32 + 0.01 * k as f32);
        assert!(second_difference([&ramp(0), &ramp(1), &ramp(2)]) < 1e-3);
        // Uniform noise of width 0.1 has a standard deviation of 0.1 / sqrt(12).
        let noise = |k: u32| frame(move |i| 0.3 + 0.1 * random(i, k));
        let found = second_difference([&noise(0), &noise(1), &noise(2)]);
        assert!((found / (255.0 * 0.1 / 12f64.sqrt()) - 1.0).abs() < 0.05, "{found}");
    }

    #[test]
    fn only_fur_counts() {
        let mut middle = frame(|_| 0.0);
        middle.alpha = vec![0.0; 4000];
        let all = frame(|i| i as f32);
        assert_eq!(second_difference([&all, &middle, &all]), 0.0);
    }

    #[test]
    fn a_video_has_all_its_frames() {
        let frames: Vec<Vec<u8>> = (0..3u8).map(|k| vec![40 * k; 3 * 4 * 2]).collect();
        let bytes = animated(4, 2, &frames, 24.0).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 3);
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        for frame in &frames {
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!(&pixels, frame);
        }
    }
}
