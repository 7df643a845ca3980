//! A camera that goes round the fur: an animated PNG, a few of its frames, and how much the picture flickers.

use super::super::{FigureContent, FigureContext};
use crate::report::Table;
use crate::report::plot::{Curve, Plot};
use glam::Vec3;
use pelage_core::assets::Assets;
use pelage_core::film::composite::over;
use pelage_core::film::tonemap::{display_rgb8, luminance, srgb_decode, srgb_encode};
use pelage_core::film::{Film, depth_of_field};
use pelage_core::scene::FilmSpec;
use pelage_core::{Result, World, animation, files};
use serde::Deserialize;
use std::io::Write;
use std::path::Path;

/// The video's name.
const FILE: &str = "orbit.png";
/// What the encoded luminance 1 is as a code value.
const CODES: f64 = 255.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Scene file, relative to the figure's folder; `[animation]` says how many frames, how fast, how far round.
    scene: String,
    /// How many of its frames are shown as pictures.
    shown: u32,
    /// Frames of the camera's small steps; at least 3.
    steps: u32,
    /// Length of a step, pixels.
    step: f32,
    /// How many times the samples are taken for what motion alone leaves.
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

/// Renders the orbit.
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
        let shot = context.render_panel(&format!("frame {number}"), world, assets)?;
        pictures.push(codes(&shot.film, &shot.spec)?);
        if (number - 1) % every == 0 {
            content.images.push(shot);
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

/// Frames as an animated PNG that repeats.
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
    encode().map_err(|e| pelage_core::Error::io(Path::new(FILE), std::io::Error::other(e)))
}

/// A way to render successive frames.
struct Way {
    name: String,
    samples: u32,
    /// Whether each frame has a seed of its own.
    seeds: bool,
}

/// Measures the flicker of small steps of the camera.
fn flicker(
    context: &FigureContext,
    settings: &Settings,
    mut world: World,
    content: &mut FigureContent,
) -> Result<()> {
    let spp = world.scene.film.spp;
    let way = |name: String, samples, seeds| Way { name, samples, seeds };
    let ways = [
        way(format!("{spp} samples a pixel"), spp, false),
        way(format!("{} samples", spp * settings.samples), spp * settings.samples, false),
        way(format!("{spp} samples, a new seed each frame"), spp, true),
    ];
    let scene = world.scene.clone();
    // What stands half the picture's height in front of the axis moves by so many pixels.
    let step = (2.0 * settings.step / scene.film.height as f32).to_degrees();
    let mut plot = Plot {
        caption: format!("Flicker while the camera goes round in steps of {} pixels", settings.step),
        x: "frame".into(),
        y: "flicker, code values".into(),
        ..Plot::default()
    };
    let mut table = Table {
        caption: format!(
            "Flicker over {} frames, {step:.4} degrees apart: root mean square over the fur's pixels, code values of 255.",
            settings.steps
        ),
        head: ["", "flicker", "by the first"].map(String::from).to_vec(),
        rows: Vec::new(),
    };
    let mut first = f64::NAN;
    for way in ways {
        let mut seen: Vec<Seen> = Vec::new();
        let mut curve = Curve { name: way.name.clone(), points: Vec::new() };
        for k in 0..settings.steps.max(3) {
            world.scene = scene.clone();
            world.scene.film.spp = way.samples;
            world.scene.animation.frames = 1;
            world.scene.animation.turntable = step;
            // Frame k + 1 of an animation of one frame stands k whole turntables further.
            world.scene.camera = animation::at(&world.scene, k + 1).camera;
            if way.seeds {
                world.scene.render.seed = scene.render.seed.wrapping_add(k);
            }
            let mut frame = context.render(&world)?;
            depth_of_field::apply(&mut frame.film, &world.scene.camera)?;
            seen.push(Seen::of(&frame.film, &world.scene.film)?);
            if let [.., a, b, c] = &seen[..] {
                curve.points.push([f64::from(k), second_difference([a, b, c])]);
            }
        }
        let mean = curve.points.iter().map(|p| p[1]).sum::<f64>() / curve.points.len() as f64;
        first = if first.is_nan() { mean } else { first };
        context.tell(&format!("flicker, {}: {mean:.3}", way.name))?;
        table.rows.push(vec![way.name.clone(), format!("{mean:.3}"), format!("{:.2}", mean / first)]);
        content.value(&format!("flicker, {}", way.name), mean, 0.05 * mean);
        plot.curves.push(curve);
    }
    content.table(&table);
    content.plots.push(("flicker".into(), plot));
    Ok(())
}

/// What a frame shows.
struct Seen {
    /// sRGB-encoded luminance over the background colour, 0..1.
    luminance: Vec<f32>,
    alpha: Vec<f32>,
}

impl Seen {
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

/// Root mean square of the second difference in time over the pixels that fur covers in the middle frame, by the root of 6, in code
/// values: the standard deviation of noise that is independent from frame to frame. What moves evenly leaves nothing.
fn second_difference([a, b, c]: [&Seen; 3]) -> f64 {
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

    fn seen(value: impl Fn(u32) -> f32) -> Seen {
        Seen { luminance: (0..4000).map(value).collect(), alpha: vec![1.0; 4000] }
    }

    #[test]
    fn noise_flickers_and_even_motion_does_not() {
        let ramp = |k: u32| seen(move |i| 0.3 + 1e-4 * i as f32 + 0.01 * k as f32);
        assert!(second_difference([&ramp(0), &ramp(1), &ramp(2)]) < 1e-3);
        // Uniform noise of width 0.1 has a standard deviation of 0.1 / sqrt(12).
        let noise = |k: u32| seen(move |i| 0.3 + 0.1 * random(i, k));
        let found = second_difference([&noise(0), &noise(1), &noise(2)]);
        assert!((found / (255.0 * 0.1 / 12f64.sqrt()) - 1.0).abs() < 0.05, "{found}");
    }

    #[test]
    fn nothing_but_fur_counts() {
        let mut middle = seen(|_| 0.0);
        middle.alpha = vec![0.0; 4000];
        let all = seen(|i| i as f32);
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
