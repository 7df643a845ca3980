//! `shellfin_raster` against its CPU twin: the picture of skin, fins and shells.

use crate::common::gpu;
use crate::common::shellfins::{Fur, even, fur_world, textures};
use glam::{Vec3, Vec4};
use pelage_core::scene::{BakeSource, Mapping};
use pelage_fur::layout::{FinEdge, FurCorner};
use pelage_gpu::recorder::Timings;
use pelage_gpu::{Recorder, Resource};
use pelage_render::twin::film::{halves, unpack};
use pelage_shells::bake::{FurTextures, lod};
use pelage_shells::lapped::lap;
use pelage_shells::passes::shellfin_raster::{ShellfinRaster, Uses};
use pelage_shells::shellfin::Pictures;
use pelage_shells::twin::shellfin_raster::{Picture, Pixel, fin_fade};
use pelage_shells::twin::shellfin_rows;

/// The GPU's samples (colour and depth) and the twin's.
fn both(text: &str, maps: FurTextures, change: impl Fn(&mut Picture<'_>)) -> Option<Vec<(Vec4, f32, Pixel)>> {
    let gpu = gpu::open()?;
    let mut world = fur_world(text);
    if world.scene.lapped.overlapping {
        world.scene.shells.mapping = Mapping::Lapped;
    }
    let fur = Fur::new(gpu, world, maps, Vec3::ZERO);
    let size = fur.frame.tile_size;
    let samples = u64::from(size[0] * size[1]);
    let pictures = Pictures::new(gpu, size).unwrap();
    let frame = gpu.uniform("frame", &fur.frame).unwrap();
    let mut timings = Timings::default();
    fur.fur.draw(&frame, &fur.rows, &pictures.targets(size), &mut timings).unwrap();
    let buffer = gpu.storage("samples", 7, samples * 32).unwrap();
    let [color, depth] = pictures.views();
    let scope = fur.fur.scope().with(&[&frame, &buffer]);
    let scope =
        scope.and("color_target", Resource::Texture(color)).and("depth_target", Resource::Texture(depth));
    let uses = Uses { guard: false, detail: false, shadow: false, mapped: false, outline: 0, coats: 1 };
    let mut recorder = Recorder::new(gpu);
    ShellfinRaster::new(gpu, uses).unwrap().record_samples(&mut recorder, &scope, samples).unwrap();
    recorder.submit(&mut timings).unwrap();
    let words: Vec<[u32; 8]> = gpu.read(&buffer, samples * 32).unwrap();

    let vertices = fur.vertices(gpu);
    let prepared = fur.fur.prepared();
    let base: Vec<[u32; 2]> =
        gpu.read(prepared.buffer("base_light").unwrap(), vertices.len() as u64 * 8).unwrap();
    let base: Vec<Vec3> =
        base.iter().map(|w| Vec3::new(halves(w[0])[0], halves(w[0])[1], halves(w[1])[0])).collect();
    let draws = fur.rows.draws;
    let last = (fur.rows.shellfin.first_corner + 3 * draws.shell_triangles).max(3 * draws.triangles);
    let corners: Vec<FurCorner> =
        gpu.read(fur.fur.buffer("fur_corners").unwrap(), u64::from(last) * 24).unwrap();
    let outlines = match fur.world.scene.lapped.overlapping {
        true => {
            lap(&fur.world.skin, &fur.world.scene).unwrap().patches.into_iter().map(|p| p.outline).collect()
        }
        false => Vec::new(),
    };
    let edges: Vec<FinEdge> = gpu.read(fur.fur.buffer("fin_edges").unwrap(), 12 * 16).unwrap();
    let count = (fur.rows.rows.len() * vertices.len()) as u64;
    let positions: Vec<[f32; 4]> = gpu.read(fur.rows.buffer("row_positions").unwrap(), count * 16).unwrap();
    let lights: Vec<[u32; 4]> = gpu.read(fur.rows.buffer("row_lights").unwrap(), count * 16).unwrap();
    let row_vertices: Vec<_> =
        positions.iter().zip(&lights).map(|(p, l)| shellfin_rows::unpack(*p, *l)).collect();
    let coarser = lod::coarser(&fur.textures);
    let layers: Vec<_> =
        fur.textures.layers.iter().chain(coarser.iter().flat_map(|l| &l.layers)).cloned().collect();
    let guard: Vec<_> =
        fur.textures.guard.iter().chain(coarser.iter().flat_map(|l| &l.guard)).cloned().collect();
    let fins = pelage_shells::shellfin::deepened(&fur.textures, fur.fur.fin_depth);
    let mut picture = Picture {
        shellfin: &fur.rows.shellfin,
        draws: fur.rows.draws,
        frame: &fur.frame,
        vertices: &vertices,
        base_light: &base,
        corners: &corners,
        outlines: &outlines,
        edges: &edges,
        rows: &fur.rows.rows,
        row_vertices: &row_vertices,
        layers: &layers,
        guard_layers: &guard,
        fin: [&fins[0], &fins[1]],
    };
    change(&mut picture);
    let found = words.into_iter().map(|words| {
        let s = unpack(&words);
        (s.undercoat.extend(1.0 - s.through), s.z)
    });
    Some(found.zip(picture.draw()).map(|((color, z), pixel)| (color, z, pixel)).collect())
}

/// Share of the samples that agree, of those not at an edge, and the number of these that show fur
/// beyond the skin.
fn agreement(samples: &[(Vec4, f32, Pixel)], tolerance: f32) -> (f64, usize) {
    let clear: Vec<_> = samples.iter().filter(|(_, _, pixel)| pixel.margin > 0.02).collect();
    let good = clear.iter().filter(|(color, z, pixel)| {
        let same_depth = pixel.depth.is_infinite() == (*z > 1e29)
            && (pixel.depth.is_infinite() || (pixel.depth - z).abs() < 1e-3);
        same_depth && (*color - pixel.color).abs().max_element() < tolerance
    });
    let fringe = clear.iter().filter(|(_, _, p)| p.color.w > 0.05 && p.color.w < 0.95).count();
    (good.count() as f64 / clear.len() as f64, fringe)
}

#[test]
fn even_layers_are_those_of_the_twin() {
    for (text, source) in [
        ("lighting = 'table'\nfins = false\nslanted = false", BakeSource::Dots),
        ("depth_write = false", BakeSource::Hybrid),
        ("fade = 'both'\nfin_threshold = 0.4\nlod = { enabled = true, distance = 1.7 }", BakeSource::Hybrid),
        ("shells = false\nfade = 'threshold'", BakeSource::Hybrid),
    ] {
        let maps = even(source, 6, source == BakeSource::Hybrid);
        let Some(samples) = both(text, maps, |_| ()) else { return };
        let (share, fringe) = agreement(&samples, 6e-3);
        println!("{text:?}: {share:.4} agree, {fringe} samples of fringe");
        assert!(share > 0.995 && fringe > 100, "{text}: {share} {fringe}");
    }
}

#[test]
fn overlapping_patches_are_those_of_the_twin() {
    let text = "fins = false\n[lapped]\noverlapping = true\nradius = 0.5";
    let maps = || even(BakeSource::Particles, 4, false);
    let Some(samples) = both(text, maps(), |_| ()) else { return };
    let (share, fringe) = agreement(&samples, 6e-3);
    println!("{share:.4} agree, {fringe} samples of fringe");
    assert!(share > 0.98 && fringe > 50, "{share} {fringe}");
    // Without the outlines each patch shows all of the faces that it touches.
    let Some(unmasked) = both(text, maps(), |picture| picture.outlines = &[]) else { return };
    assert!(agreement(&unmasked, 6e-3).0 < 0.9);
}

#[test]
fn patterns_are_those_of_the_twin_where_they_are_magnified() {
    let maps = textures(BakeSource::Hybrid, 4, 8, true, |layer, u, v, part| {
        let wave = |k: f32| 0.5 + 0.5 * (std::f32::consts::TAU * k).sin();
        let coverage = 0.1 + 0.3 * wave(u + 0.1 * layer as f32) * wave(v);
        let share = if part { 0.5 * wave(u + v) } else { 1.0 };
        [0.7 * coverage * share, 0.4 * coverage * share, 0.2 * wave(v) * coverage * share, coverage * share]
    });
    let Some(samples) = both("", maps, |_| ()) else { return };
    // Half a level of minification remains at grazing angles.
    let (share, _) = agreement(&samples, 0.02);
    println!("{share:.4} agree");
    assert!(share > 0.97, "{share}");
}

#[test]
fn hairs_shade_the_gaps_away_from_the_light() {
    // Stripes: half of the texture is hair.
    let stripes = || {
        textures(
            BakeSource::Dots,
            4,
            16,
            false,
            |_, u, _, _| if u < 0.5 { [0.3, 0.3, 0.3, 1.0] } else { [0.0; 4] },
        )
    };
    let light_and_cover = |text: &str| {
        let samples = both(text, stripes(), |_| ())?;
        let sum = samples.iter().map(|(color, ..)| *color).sum::<Vec4>();
        Some((sum.truncate().element_sum(), sum.w))
    };
    let plain = "lighting = 'table'\nfins = false\nslanted = false\n";
    let with = |strength: f32| {
        light_and_cover(&format!("{plain}shadow = {{ strength = {strength}, offset = 0.2 }}"))
    };
    let Some([none, half, full]) =
        [0.0, 0.5, 1.0].map(with).into_iter().collect::<Option<Vec<_>>>().map(|v| [v[0], v[1], v[2]])
    else {
        return;
    };
    println!("{none:?} {half:?} {full:?}");
    // The skin in the gaps gets darker, and the coverage does not change.
    assert!(half.0 < 0.99 * none.0 && full.0 < half.0 && full.0 < 0.98 * none.0);
    assert!(half.1 >= none.1 && full.1 >= half.1);
}

#[test]
fn another_order_is_noticed() {
    let maps = even(BakeSource::Hybrid, 6, true);
    let Some(samples) = both("", maps, |picture| picture.draws.shells -= 1) else { return };
    assert!(agreement(&samples, 6e-3).0 < 0.9);
}

#[test]
fn fins_fade_as_the_paper_says() {
    use pelage_core::skin::NONE;
    use pelage_fur::layout::{ShellVertex, Shellfin};
    let vertex = |x: f32, y: f32, z: f32| ShellVertex {
        position: [x, y, z],
        height: 0.3,
        normal: [0.0, 1.0, 0.0],
        color: !0,
    };
    // A flat piece of skin facing +y, its edge along x.
    let vertices =
        [vertex(-0.5, 0.0, 0.0), vertex(0.5, 0.0, 0.0), vertex(0.0, 0.0, -1.0), vertex(0.0, 0.0, 1.0)];
    let edge = FinEdge { a: 0, b: 1, opposite: [2, 3] };
    let mut shellfin: Shellfin = bytemuck::Zeroable::zeroed();
    shellfin.fin_threshold = 0.25;
    let eye = |degrees: f32| Vec3::new(0.0, degrees.to_radians().sin(), degrees.to_radians().cos()) * 1e4;
    for (degrees, wanted) in [(0.0, 1.0), (30.0, 0.7320508), (45.0, 0.4142136), (60.0, 0.0), (90.0, 0.0)] {
        let found = fin_fade(&shellfin, &vertices, &edge, eye(degrees));
        assert!((found - wanted).abs() < 1e-3, "{degrees}: {found}");
    }
    shellfin.fade = 1;
    assert_eq!([5.0, 14.0, 15.0].map(|d| fin_fade(&shellfin, &vertices, &edge, eye(d))), [1.0, 1.0, 0.0]);
    let border = FinEdge { opposite: [2, NONE], ..edge };
    assert_eq!(fin_fade(&shellfin, &vertices, &border, eye(80.0)), 1.0);
    shellfin.fade = 2;
    assert!((fin_fade(&shellfin, &vertices, &edge, eye(0.1)) - 1.0).abs() < 0.02);
    assert_eq!(fin_fade(&shellfin, &vertices, &edge, eye(20.0)), 0.0);
}
