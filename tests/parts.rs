//! Parts of the skin: what they choose and inherit, how coats go over into each other, and that all
//! renderers know them.

use crate::common::gpu::{self, Fixture, image, jittered_grid, scaled, world_on};
use crate::common::{Folder, hairs, pelage, worlds};
use glam::Vec3;
use pelage_core::scene::{Color, Scalar};
use pelage_core::skin::Section;
use pelage_core::{Error, Scene, Skin, World};
use pelage_fur::guard_strands::strand;
use pelage_fur::hair_roots::Roots;
use pelage_fur::layout::{Column, Root};
use pelage_fur::parameters::{Maps, MeshPlace, Parameter, SkinPoint, root_point};
use pelage_fur::shell_prisms::shell_of;
use pelage_fur::strands::{opacity, position, radius};
use pelage_fur::{Layer, groom};
use pelage_pathtrace::grow::{GrowOptions, grow};
use pelage_render::twin::{lattice, shell_lattice};

/// A square of `n` cm whose triangles are in the groups `left` and `right` of its middle.
fn halves(n: u32, displacement: f32) -> Skin {
    let mut skin = scaled(jittered_grid(n, displacement), 1.0, n as f32);
    let section = |group: &str| Section { group: group.into(), ..Section::default() };
    skin.sections = vec![section("left"), section("right")];
    let right = |t| skin.corners(t).iter().map(|p| p.x).sum::<f32>() > 1.5 * n as f32;
    skin.section_of = (0..skin.triangles.len()).map(|t| u32::from(right(t))).collect();
    skin
}

/// Two coats that differ in all that parts may have of their own, with a map in the part's, and a
/// bare disc at the middle of the left half.
const TWO: &str = "[guard]\ndensity = 20\nlength = 0.6\ncomb = 0.3\ncomb_direction = [0, 0, 1]\nclump = 0.3\nsegments = 5\n\
    [undercoat]\nheight = 0.3\nlayers = 4\nsubdivision = 1\ndensity = 3000\ndiameter = [20, 10]\n[base]\ncolor = [0.1, 0.2, 0.3]\n\
    [[parts]]\ngroup = \"right\"\nedge = 2\nbase = { color = [0.7, 0.6, 0.5] }\n\
    guard = { density = { map = \"a.png\", value = 60 }, length = 1.4, length_variation = 0.1, comb = 0.8, comb_direction = [1, 0, 0],\n\
    clump = 0.6, clump_density = 9, diameter = [60, 140, 20], widest = 0.3, spread = 20, gravity = 0.6, curl = 0.05, frizz = 0.02,\n\
    curl_frequency = 0.7, frizz_frequency = 2, color_root = [0.9, 0.1, 0.1], color_tip = [0.1, 0.9, 0.1], color_transition = [0.2, 0.3],\n\
    color_variation = 0.4, opacity = 0.8, tip_fade = 0.5, segments = 7 }\n\
    undercoat = { density = 1000, diameter = [40, 20], height = 0.5, color_root = [0.8, 0.5, 0.2], color_tip = { map = \"c.png\" } }\n\
    [[parts]]\nmask = { map = \"disc.png\" }\nfur = false\n";

fn two(seed: u32) -> World {
    let text = format!("{TWO}[render]\nseed = {seed}\n");
    let disc = |u: f32, v: f32| f32::from((u - 0.25).hypot(v - 0.5) < 0.15);
    let maps = vec![
        image("a.png", false, 16, |u, v| [0.5 + 0.5 * u * v, 0.0, 0.0, 1.0]),
        image("c.png", true, 16, |u, v| [u, v, 1.0 - u, 1.0]),
        image("disc.png", false, 64, |u, v| [disc(u, v), 0.0, 0.0, 1.0]),
    ];
    world_on(&text, Some(halves(8, 0.2)), maps)
}

/// The point over (x, z) of a skin whose triangles are seen from above.
fn above(skin: &Skin, x: f32, z: f32) -> SkinPoint {
    let flat = |p: Vec3| Vec3::new(p.x, 0.0, p.z);
    let area = |a: Vec3, b: Vec3, c: Vec3| (b - a).cross(c - a).y;
    for t in 0..skin.triangles.len() {
        let [a, b, c] = skin.corners(t).map(flat);
        let p = Vec3::new(x, 0.0, z);
        let lambda = Vec3::new(area(p, b, c), area(a, p, c), area(a, b, p)) / area(a, b, c);
        if lambda.min_element() >= -1e-6 {
            return SkinPoint {
                place: MeshPlace::Triangle(t as u32, lambda),
                ..pelage_fur::parameters::triangle_point(skin, t, lambda)
            };
        }
    }
    panic!("({x}, {z}) is beside the skin");
}

#[test]
fn coats_go_over_into_each_other_beside_the_part() {
    let world = |edge: &str| {
        let text = format!(
            "[guard]\nlength = 1\nthickness = 1\ndiameter = [10, 20, 10]\n\
             [[parts]]\ngroup = \"right\"\n{edge}\nguard = {{ length = 3, diameter = [30, 20, 10] }}\n"
        );
        world_on(&text, Some(halves(8, 0.0)), Vec::new())
    };
    let at = |world: &World, x: f32| {
        let packed = groom::pack(world).expect("a groom");
        let maps = Maps { groom: &packed.groom, texels: &packed.texels };
        // Along a line across the triangles' diagonals.
        let at = above(&world.skin, x, 0.3 * x + 2.1);
        // What is the same in both coats stays as it is: the shares add up to 1.
        assert_eq!(maps.scalar(Parameter::GuardThickness, &at), 1.0);
        let [root, widest, _] = maps.hairs_at(&at).diameter;
        gpu::close(widest * 1e4, 20.0, 1e-6, "widest");
        [maps.part_share(1, &at), maps.scalar(Parameter::GuardLength, &at), root * 1e4]
    };
    for (edge, cm) in [("", 1.0), ("edge = 2", 2.0), ("edge = 0.25", 0.25)] {
        let world = world(edge);
        for k in 0..78 {
            let x = 0.1 * k as f32 + 0.05;
            let wanted = (1.0 - (4.0 - x).max(0.0) / cm).clamp(0.0, 1.0);
            let [share, length, root] = at(&world, x);
            gpu::close(share, wanted, 2e-3, format!("share at {x}, edge {cm}"));
            gpu::close(length, 1.0 + 2.0 * wanted, 2e-3, format!("length at {x}, edge {cm}"));
            gpu::close(root, 10.0 + 20.0 * wanted, 2e-3, format!("diameter at {x}, edge {cm}"));
        }
    }
    let hard = world("edge = 0");
    for (x, wanted) in [(3.98, [0.0, 1.0, 10.0]), (4.02, [1.0, 3.0, 30.0])] {
        let found = at(&hard, x);
        (0..3).for_each(|k| gpu::close(found[k], wanted[k], 1e-6, format!("value {k} at {x}")));
    }
}

#[test]
fn distances_follow_the_skin() {
    // On a displaced grid the distance to a straight border is the same, but for the bumps.
    let text = "[[parts]]\ngroup = \"right\"\nedge = 3\nguard = { length = 3 }\n";
    let mut skin = halves(16, 0.25);
    skin.positions.iter_mut().for_each(|p| p.y = 0.0);
    let world = world_on(text, Some(skin), Vec::new());
    let packed = groom::pack(&world).expect("a groom");
    let maps = Maps { groom: &packed.groom, texels: &packed.texels };
    // The border runs along edges near x = 8.
    let chosen = pelage_core::parts::chosen(&world.skin, &world.scene.parts[0]);
    let border: Vec<Vec3> = (0..world.skin.triangles.len())
        .filter(|t| chosen[*t])
        .flat_map(|t| {
            let [a, b, c] = world.skin.corners(t);
            (0..=20).flat_map(move |k| {
                let f = k as f32 / 20.0;
                [a.lerp(b, f), b.lerp(c, f), c.lerp(a, f)]
            })
        })
        .collect();
    let mut worst = 0.0f32;
    for k in 0..200u32 {
        let (x, z) = (5.2 + 0.013 * k as f32, 2.0 + (7.3 * k as f32) % 12.0);
        let at = above(&world.skin, x, z);
        let distance = border.iter().map(|p| p.distance(at.position)).fold(f32::INFINITY, f32::min);
        worst = worst.max((3.0 * (1.0 - maps.part_share(1, &at)) - distance).abs());
    }
    println!("largest error of a distance: {worst:.3} cm");
    // Edges are 1 cm long.
    assert!((1e-6..0.25).contains(&worst), "{worst} cm");
}

#[test]
fn buffers_are_those_of_the_twins() {
    let Some(gpu) = gpu::open() else { return };
    let fixture = Fixture::new(gpu, two(3));
    let (world, maps) = (&fixture.world, fixture.maps());
    assert_eq!(fixture.prepared.segments, 7, "the most segments of all coats");

    // Shell: the wanted heights, lowered alike.
    let twin = shell_of(world, &fixture.packed);
    for (v, (a, b)) in fixture.shell.vertices.iter().zip(&twin.vertices).enumerate() {
        gpu::close(a.height, b.height, 1e-4, format!("height over vertex {v}"));
    }
    // Roots.
    let found: Vec<Root> = fixture.read("roots", fixture.strands());
    let density = groom::guard_density(&world.scene);
    assert_eq!(density, 60.0);
    let roots = Roots { shell: &fixture.shell, maps, density, seed: 3 };
    let wanted: Vec<Root> = (0..fixture.prepared.triangles).flat_map(|t| roots.of(t)).collect();
    let seeds = |roots: &[Root]| roots.iter().map(|r| r.seed).collect::<std::collections::BTreeSet<_>>();
    let differ = seeds(&found).symmetric_difference(&seeds(&wanted)).count();
    assert!(found.len() > 800 && differ * 200 < found.len(), "{differ} of {} roots", found.len());
    // Strands.
    let vertices = fixture.strand_vertices();
    for (root, found) in found.iter().zip(vertices.chunks(8)) {
        let wanted = strand(&fixture.shell, &maps, root);
        for (a, b) in found.iter().zip(wanted.vertices(&fixture.packed.groom)) {
            let away = position(*a).distance(position(b));
            assert!(away < 1e-4 * wanted.length.max(0.1), "{away} cm at {:?}", wanted.root);
            gpu::close(radius(*a) * 1e3, radius(b) * 1e3, 2e-3, "radius");
            gpu::close(opacity(*a), opacity(b), 2e-3, "opacity");
        }
    }
    // Columns.
    let columns: Vec<Column> = fixture.read("columns", fixture.fur.lattice.columns as usize);
    for (i, a) in columns.iter().enumerate() {
        let b = shell_lattice::column(&fixture.shell, &fixture.fur, &maps, a);
        gpu::close(a.density, b.density, 1e-3, format!("density of column {i}"));
        let colors = [a.color_root, a.color_tip, a.color_base].into_iter();
        for (a, b) in colors.zip([b.color_root, b.color_tip, b.color_base]) {
            let away = (lattice::unpack_albedo(a) - lattice::unpack_albedo(b)).abs().max_element();
            assert!(away < 2.01 / 1023.0, "column {i}: {a:x} {b:x}");
        }
    }
}

#[test]
fn each_side_has_its_own_hairs() {
    let Some(gpu) = gpu::open() else { return };
    let fixture = Fixture::new(gpu, two(5));
    let roots: Vec<Root> = fixture.read("roots", fixture.strands());
    let points: Vec<SkinPoint> = roots.iter().map(|r| root_point(&fixture.shell, r)).collect();
    let disc = |p: &SkinPoint| (p.uv.x - 0.25).hypot(p.uv.y - 0.5);
    assert!(points.iter().all(|p| disc(p) > 0.127), "hairs on the bare disc");
    // Left of the transition, which is 2 cm wide beside x = 4, and without the disc.
    let left = points.iter().filter(|p| p.position.x < 1.7 && disc(p) > 0.175).count() as f32;
    let area = |keep: &dyn Fn(f32, f32) -> bool| {
        let places =
            (0..400).flat_map(|i| (0..400).map(move |j| ((i as f32 + 0.5) / 50.0, (j as f32 + 0.5) / 50.0)));
        places.filter(|(x, z)| keep(*x, *z)).count() as f32 / 2500.0
    };
    let wanted = 20.0 * area(&|x, z| x < 1.7 && (x / 8.0 - 0.25).hypot(z / 8.0 - 0.5) > 0.175);
    assert!((left / wanted - 1.0).abs() < 0.2, "{left} hairs on the left, expected {wanted}");
    let right = points.iter().filter(|p| p.position.x > 4.3).count() as f32;
    let mean = points.iter().filter(|p| p.position.x > 4.3).map(|p| p.uv.x * p.uv.y).sum::<f32>() / right;
    assert!((1130.0..1330.0).contains(&right) && mean > 0.3, "{right} hairs on the right");
    // Lengths: 0.6 cm and 1.4 cm with their own variation.
    for (root, at) in roots.iter().zip(&points) {
        let length = strand(&fixture.shell, &fixture.maps(), root).length;
        if at.position.x > 4.3 {
            assert!((1.259..1.401).contains(&length), "{length} cm on the right");
        } else if at.position.x < 1.7 && disc(at) > 0.175 {
            assert!((0.41..0.601).contains(&length), "{length} cm on the left");
        }
    }
    // The undercoat: 1,000 hairs of 40 µm count as 2,000 of the own 20 µm.
    let maps = fixture.maps();
    let at = |x, z| above(&fixture.world.skin, x, z);
    let density = |x, z| maps.scalar(Parameter::UndercoatDensity, &at(x, z));
    assert_eq!([density(6.0, 4.0), density(0.4, 0.4), density(2.0, 4.0)], [2000.0, 3000.0, 0.0]);
    assert_eq!(maps.scalar(Parameter::UndercoatHeight, &at(2.0, 4.0)), 0.0);
    // Bare skin has the colour of what lies below.
    let base = |x, z| maps.color(Parameter::BaseColor, &at(x, z));
    assert_eq!(base(2.0, 4.0), Vec3::new(0.1, 0.2, 0.3));
    assert_eq!(base(6.0, 4.0), Vec3::new(0.7, 0.6, 0.5));
}

#[test]
fn a_part_like_the_own_coat_changes_no_byte() {
    let Some(gpu) = gpu::open() else { return };
    let coat = "[guard]\ndensity = 60\nlength = { map = \"a.png\", value = 1.1 }\nclump = 0.4\ncomb = 0.5\ncomb_direction = [1, 0, 0.2]\n\
        curl = 0.03\nopacity = 0.9\ntip_fade = 0.3\nsegments = 6\n[undercoat]\nheight = 0.3\nlayers = 4\nsubdivision = 1\ndensity = 4000\n\
        color_tip = { map = \"c.png\" }\n";
    let parts = "[[parts]]\ngroup = \"right\"\nedge = 2\n[[parts]]\nmask = { map = \"a.png\" }\n";
    let read = |text: &str| {
        let maps = vec![
            image("a.png", false, 16, |u, v| [0.3 + 0.7 * u * v, 0.0, 0.0, 1.0]),
            image("c.png", true, 16, |u, v| [u, v, 1.0 - u, 1.0]),
        ];
        let fixture = Fixture::new(gpu, world_on(text, Some(halves(6, 0.2)), maps));
        let strands = fixture.strands();
        let nodes = (fixture.fur.lattice.columns * (fixture.fur.lattice.levels + 1)) as usize;
        let words = |name: &str, count: usize| fixture.read::<u32>(name, count);
        [
            words("shell_vertices", 8 * fixture.world.skin.positions.len()),
            words("roots", 4 * strands),
            words("strand_vertices", 4 * 7 * strands),
            words("shades", 2 * 7 * strands),
            words("columns", size_of::<Column>() / 4 * fixture.fur.lattice.columns as usize),
            words("node_light", 4 * nodes),
        ]
    };
    let [without, with] = [coat.to_owned(), format!("{coat}{parts}")].map(|text| read(&text));
    for (i, (a, b)) in without.iter().zip(&with).enumerate() {
        assert!(!a.is_empty() && a == b, "buffer {i} differs");
    }
    // The comparison sees a part that is not.
    let other = read(&format!("{coat}[[parts]]\ngroup = \"right\"\nguard = {{ length = 0.7 }}\n"));
    assert!(other[2] != without[2]);
}

#[test]
fn the_path_tracer_grows_the_same_parts() {
    if gpu::open().is_none() {
        return;
    }
    let mut world = two(7);
    world.scene.lights.push(Default::default());
    let wanted = pelage_render::strands::strands(&world).expect("strands of the GPU");
    let layers = grow(&world, &GrowOptions::default()).expect("strands");
    let guard = layers.iter().find(|l| l.layer == Layer::Guard).expect("guard hairs");
    assert_eq!(guard.hairs.len(), wanted.segments.len());
    let mut opacities = [1.0f32, 0.0];
    for (i, p) in guard.points.iter().enumerate() {
        assert!(p.truncate().distance(wanted.points[i]) < 1e-4);
        gpu::close(2.0 * p.w * 1e3, wanted.thickness[i] * 1e3, 2e-3, format!("thickness at {i}"));
        let opacity = guard.opacity_at(i / 8, i % 8);
        gpu::close(opacity, 1.0 - wanted.transparency[i], 2e-3, format!("opacity at {i}"));
        opacities = [opacities[0].min(opacity), opacities[1].max(opacity)];
    }
    assert!(opacities[0] < 0.6 && opacities[1] > 0.95, "{opacities:?}");
    // Colours: tips on the right are green already at 0.4 of the length.
    for i in 0..guard.hairs.len() {
        let x = guard.points[8 * i].x;
        let early = guard.color(i, 0.4);
        if x > 4.3 {
            assert!(early.y > 4.0 * early.x, "{early} at {x}");
        }
    }
    // The undercoat: none on the disc, and as much on the right as its density says.
    let undercoat = layers.iter().find(|l| l.layer == Layer::Undercoat).expect("undercoat");
    let roots = || undercoat.points.iter().step_by(undercoat.segments + 1);
    assert!(roots().all(|p| (p.x / 8.0 - 0.25).hypot(p.z / 8.0 - 0.5) > 0.127));
    let [left, right] = [0.0..1.0, 5.0..8.0].map(|range: std::ops::Range<f32>| {
        roots().filter(|p| range.contains(&p.x)).count() as f32 / (8.0 * (range.end - range.start))
    });
    assert!((left / right / 1.5 - 1.0).abs() < 0.15, "{left} and {right} hairs/cm2, expected 3000 to 2000");
}

/// Mean radiance of the left and the right third of an image.
fn sides(film: &pelage_core::film::Film) -> [f64; 2] {
    let plane = worlds::plane(film, "R");
    let (w, third) = (film.width as usize, film.width as usize / 3);
    let mean = |columns: std::ops::Range<usize>| {
        let of_row = |row: &[f32]| row[columns.clone()].iter().map(|v| f64::from(*v)).sum::<f64>();
        plane.chunks(w).map(of_row).sum::<f64>() / (plane.len() / w * third) as f64
    };
    [mean(0..third), mean(w - third..w)]
}

#[test]
fn path_tracer_and_hybrid_agree_on_parts_as_on_one_coat() {
    if gpu::open().is_none() {
        return;
    }
    let coats = [
        "density = 150\nlength = 0.5\ncolor_root = [0.5, 0.2, 0.1]\ncolor_tip = [0.7, 0.3, 0.1]",
        "density = 300\nlength = 0.7\ncolor_root = [0.1, 0.1, 0.1]\ncolor_tip = [0.2, 0.2, 0.2]",
    ];
    let undercoats =
        ["density = 1500\ncolor_root = [0.5, 0.4, 0.3]", "density = 2500\ncolor_root = [0.2, 0.2, 0.2]"];
    let picture = |own: usize, part: Option<usize>| {
        let table = |i: usize| (coats[i].replace('\n', ", "), undercoats[i].replace('\n', ", "));
        let part = part.map(table).map_or(String::new(), |(guard, undercoat)| {
            format!("[[parts]]\ngroup = \"right\"\nedge = 0\nguard = {{ {guard} }}\nundercoat = {{ {undercoat} }}\n")
        });
        let text = format!(
            "[guard]\nsegments = 6\n{}\n[undercoat]\nheight = 0.3\nlayers = 12\ncell = 0.1\ndiameter = [30, 20]\n{}\n{part}\
             [camera]\neye = [2, 9, 4]\ntarget = [2, 0, 2]\nfov = 20\n[film]\nwidth = 24\nheight = 24\nspp = 16\nfilter = \"box\"\n\
             [[lights]]\ndirection = [0.3, 0.9, 0.4]\n",
            coats[own], undercoats[own]
        );
        let world = world_on(&text, Some(halves(4, 0.0)), Vec::new());
        let hybrid = sides(&worlds::render(&world).film);
        let options =
            hairs::options(pelage_pathtrace::Integrator::Path, pelage_pathtrace::LightModel::Scene, 24);
        let traced = pelage_pathtrace::render(&world, &options, &mut |_| Ok(())).expect("a picture");
        [hybrid, sides(&traced.film)]
    };
    let (first, second, both) = (picture(0, None), picture(1, None), picture(0, Some(1)));
    println!("{first:?} {second:?} {both:?}");
    for renderer in 0..2 {
        let wanted = [first[renderer][0], second[renderer][1]];
        assert!(wanted[0] > 2.0 * wanted[1], "the coats differ: {wanted:?}");
        for side in 0..2 {
            let ratio = both[renderer][side] / wanted[side];
            assert!((ratio - 1.0).abs() < 0.06, "renderer {renderer}, side {side}: {ratio}");
        }
    }
}

fn parse(text: &str) -> Scene {
    Scene::parse(text, "test.toml", &[]).unwrap_or_else(|e| panic!("{e}"))
}

const SPHERE: &str = "[mesh]\nshape = \"sphere\"\n";
const HALF: &str = "[[parts]]\nmask = { map = \"vertex_color\" }\n";

#[test]
fn own_keys_lie_over_the_preset_over_the_scenes_coat() {
    let scene = parse(&format!(
        "{SPHERE}[guard]\nlength = 9\ncurl = 0.25\n[base]\ncolor = [0.1, 0.1, 0.1]\n[undercoat]\nstep = 0.7\n{HALF}preset = \"red_fox\"\n\
         guard = {{ density = 5, color_tip = [0, 0, 1] }}\n{HALF}{HALF}fur = false\n{HALF}base = {{ color = [0, 1, 0] }}\nfur = false\n"
    ));
    let coats: Vec<_> = scene.coats().collect();
    assert_eq!(coats.len(), 3, "bare parts have no coat");
    let fox = &coats[1];
    let red = parse(&format!("preset = \"red_fox\"\n{SPHERE}"));
    assert_eq!(fox.guard.density, Scalar::Constant(5.0), "its own");
    assert_eq!(fox.guard.color_tip, Color::Constant([0.0, 0.0, 1.0]));
    assert_eq!(fox.guard.length, red.guard.length, "the preset's");
    assert_eq!(fox.base.color, red.base.color);
    assert_eq!(fox.guard.curl, Scalar::Constant(0.25), "the scene's");
    assert_eq!(fox.undercoat.step, 0.7);
    assert_eq!((coats[2].guard, coats[2].base), (&scene.guard, &scene.base));
    assert_eq!(scene.parts[2].base, None);
    assert!(scene.parts[3].base.is_some());
    // What `check` prints is read as the same scene.
    let text = toml::to_string(&scene).expect("TOML");
    assert_eq!(parse(&text), scene);
    // Flags reach parts, and the coats that they inherit.
    let flags = ["parts.0.guard.density=7".to_owned(), "guard.curl=0.5".to_owned()];
    let scene = Scene::parse(&text.replace("curl = 0.25", ""), "test.toml", &flags).expect("a scene");
    assert_eq!(scene.parts[0].guard.as_ref().map(|g| g.density.max()), Some(7.0));
}

#[test]
fn faults_of_parts_name_key_and_line() {
    let fault = |text: &str| match Scene::parse(&format!("{SPHERE}{text}"), "test.toml", &[]) {
        Err(Error::Scene(faults)) => {
            assert_eq!(faults.len(), 1, "{faults:?}");
            faults[0].to_string()
        }
        other => panic!("expected a fault of {text}, got {other:?}"),
    };
    for (text, parts) in [
        ("[[parts]]\nname = \"a\"\n", ["test.toml:3", "parts.0: found none of group, material and mask"]),
        (
            "[[parts]]\ngroup = \"a\"\npreset = \"red_fix\"\n",
            ["test.toml:5:10: parts.0.preset", "\"red_fox\"?"],
        ),
        (
            "[[parts]]\ngroup = \"a\"\nguard = { lenght = 2 }\n",
            ["test.toml:5:11: unknown key \"lenght\"", "\"length\"?"],
        ),
        ("[[parts]]\ngroup = [\"a\", 3]\n", ["test.toml:4:", "parts.0.group"]),
        ("[[parts]]\ngroup = \"a\"\nedge = -1\n", ["test.toml:5:8: parts.0.edge", "at least 0"]),
        ("[[parts]]\nmask = { map = \"vertex_color\" }\nedge = 1\n", ["test.toml:5:8: parts.0.edge", "blur"]),
        (
            "[[parts]]\ngroup = \"a\"\nfur = false\nguard = {}\n",
            ["test.toml:6:1: parts.0.guard", "fur = false"],
        ),
        (
            "[[parts]]\ngroup = \"a\"\nundercoat = { density = { map = \"vertex_color\", value = -1, offset = -1 } }\n",
            ["test.toml:5:", "parts.0.undercoat.density: value and offset"],
        ),
        // Faults of the scene's own coat, which parts inherit, are reported once.
        (
            "[guard]\nlenght = 2\n[[parts]]\ngroup = \"a\"\n",
            ["test.toml:4:1: unknown key \"lenght\" in [guard]", ""],
        ),
        (&"[[parts]]\ngroup = \"a\"\n".repeat(16), ["parts: expected an array of at most 15 tables", "16"]),
    ] {
        let fault = fault(text);
        assert!(parts.iter().all(|part| fault.contains(part)), "{text}\n{fault}");
    }
}

#[test]
fn unknown_groups_and_files_are_faults_with_their_line() {
    let folder = Folder::new();
    folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\ng body\nf 1 3 2\ng eyes\nf 2 3 4\n");
    folder.write("base.toml", "[guard]\nlength = { map = \"gone.png\" }\n");
    let text =
        "include = [\"base.toml\"]\n[mesh]\npath = \"m.obj\"\n[[parts]]\nmask = { map = \"none.png\" }\n";
    let scene = folder.write("files.toml", text);
    let run = pelage(&["check", &scene])
        .expect(3, &["files.toml:5:16: parts.0.mask.map", "base.toml:2:18: guard.length"]);
    assert_eq!(run.err.matches("gone.png").count(), 1, "{}", run.err);
    // The mask is found beside the scene.
    image::GrayImage::from_pixel(2, 2, image::Luma([255])).save(folder.at("none.png")).expect("an image");
    image::GrayImage::from_pixel(2, 2, image::Luma([255])).save(folder.at("gone.png")).expect("an image");
    pelage(&["check", &scene]).expect(0, &[]);
    let named = |name: &str| {
        let text = format!(
            "[mesh]\npath = \"m.obj\"\n[[parts]]\nname = \"eyes\"\nfur = false\ngroup = [\"body\", \"{name}\"]\n"
        );
        pelage(&["check", &folder.write("groups.toml", text)])
    };
    named("eyes").expect(0, &[]);
    named("eye")
        .expect(3, &["groups.toml:6", "parts.0.group: the mesh has no group \"eye\"", "\"body\", \"eyes\""]);
    let sphere = format!("{SPHERE}[[parts]]\nmaterial = \"fur\"\n");
    let sphere = folder.write("sphere.toml", sphere);
    pelage(&["check", &sphere]).expect(3, &["sphere.toml:4", "no material \"fur\"", "mask"]);
}

#[test]
fn what_only_the_scenes_own_coat_decides_is_noted() {
    let notes = |text: &str| pelage_core::parts::notes(&parse(&format!("{SPHERE}{text}")));
    assert!(notes(HALF).is_empty());
    assert!(
        notes(&format!(
            "{HALF}guard = {{ length = 2 }}\nundercoat = {{ height = 2, diameter = [28, 16] }}\n"
        ))
        .is_empty()
    );
    let text = format!("preset = \"red_fox\"\n{SPHERE}{HALF}name = \"tail\"\npreset = \"arctic_fox\"\n");
    let found = pelage_core::parts::notes(&parse(&text));
    assert_eq!(found.len(), 1);
    for key in ["\"tail\"", "guard.fibre", "undercoat.fibre", "undercoat.layers", "undercoat.noise_frequency"]
    {
        assert!(found[0].contains(key), "{key}: {found:?}");
    }
    for key in ["undercoat.density", "undercoat.height", "undercoat.color_tip", "undercoat.cell"] {
        assert!(!found[0].contains(&format!("{key},")), "{key}: {found:?}");
    }
    let shells = notes(&format!("[render]\nfur = \"shells\"\n{HALF}"));
    assert!(shells.len() == 1 && shells[0].contains("mean coat"), "{shells:?}");
}
