//! Objects: their material against the CPU twin, what they cover and shade, what the fur does to
//! their light, shadow catchers, mattes and features.

use crate::common::gpu::{self, Fixture};
use crate::common::worlds::{differing, plane};
use crate::common::{Folder, pelage};
use glam::{Vec3, Vec4};
use pelage_core::film::Film;
use pelage_core::film::{cryptomatte, io};
use pelage_core::scene::{Color, ColorMap};
use pelage_core::{Scene, World};
use pelage_fur::layout::Column;
use pelage_fur::material::Material;
use pelage_fur::random::random;
use pelage_render::RenderOptions;
use pelage_render::prepare::FurCells;
use pelage_render::twin::base_raster::unpack;
use pelage_render::twin::lattice::{node_place, unpack_albedo};
use pelage_render::twin::objects::{Surroundings, fur_depth};

/// A furry ball of radius 1 cm, seen from the front and above.
const BALL: &str = "[mesh]\nshape = \"sphere\"\nscale = 0.2\n[camera]\neye = [0, 2, 9]\ntarget = [0, 0, 0]\nfov = 30\n\
    [film]\nwidth = 96\nheight = 64\nspp = 4\nfilter = \"box\"\n\
    [guard]\ndensity = 200\nlength = 0.4\nsegments = 4\n[undercoat]\ndensity = 3000\nheight = 0.2\nlayers = 4\nsubdivision = 0\n";

const LIGHTS: &str = "[[lights]]\ndirection = [0.5, 1, 0.6]\nirradiance = [3, 2.5, 2]\n\
    [[lights]]\ndirection = [-0.7, 0.4, 0.5]\nirradiance = [0.5, 1, 1.5]\n";

/// Ground, eye, a metal bar and a shadow catcher in front.
const THINGS: &str = "[[objects]]\nname = \"ground\"\nmesh = { shape = \"plane\", size = 5, translate = [0, -1.2, 0] }\n\
    material = { roughness = 0.6 }\n\
    [[objects]]\nname = \"eye\"\nmesh = { shape = \"sphere\", size = 0.8, translate = [0.3, 0.6, 1] }\n\
    material = { color = [0.05, 0.02, 0.01], roughness = 0.3, clearcoat = 1, clearcoat_roughness = 0.3 }\n\
    [[objects]]\nname = \"bar\"\nmesh = { shape = \"cylinder\", size = 3, rotate = [0, 0, 75], translate = [-1.5, 0, 0.4] }\n\
    material = { color = [0.9, 0.6, 0.3], metallic = 1, roughness = 0.45 }\n\
    [[objects]]\nname = \"catcher\"\nmesh = { shape = \"disc\", size = 1.5, translate = [1.6, -1, 1] }\nshadow_catcher = true\n";

fn features(world: &World) -> Film {
    let options = RenderOptions { aovs: true, features: true, ..Default::default() };
    pelage_shells::render(world, &options).expect("a frame").film
}

/// Mean of a plane over pixels.
fn mean(film: &Film, name: &str, pixels: &[usize]) -> f32 {
    assert!(pixels.len() > 5, "{} pixels", pixels.len());
    pixels.iter().map(|i| plane(film, name)[*i]).sum::<f32>() / pixels.len() as f32
}

#[test]
fn materials_agree_with_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    let code = "#import shared/material\n\
        @group(0) @binding(50) var<storage, read> input: array<vec4f>;\n\
        @group(0) @binding(51) var<storage, read_write> output: array<vec4f>;\n\
        @compute @workgroup_size(64)\nfn main(@builtin(global_invocation_id) id: vec3u) {\n\
            let i = id.x;\n\
            if i >= arrayLength(&output) { return; }\n\
            let m = input[4u * i + 1u];\n\
            let v = input[4u * i + 2u];\n\
            let l = input[4u * i + 3u];\n\
            let material = Material(input[4u * i].rgb, m.x, m.y, m.z, m.w);\n\
            output[i] = vec4f(scatter_material(material, vec3f(0.0, 1.0, 0.0), v.xyz, l.xyz, l.w), 0.0);\n\
        }\n";
    let count = 20_000u32;
    let direction = |i: u32, k: u32| {
        let d = Vec3::from([0, 1, 2].map(|j| 2.0 * random(i, k + j) - 1.0));
        Vec3::new(d.x, if k == 10 { d.y.abs() } else { d.y }, d.z).normalize_or(Vec3::Y)
    };
    let case = |i: u32| {
        let color = Vec3::from([0, 1, 2].map(|k| random(i, k)));
        let round = |x: f32| if x < 0.2 { 0.0 } else { x };
        let [roughness, metallic, clearcoat, clearcoat_roughness] = [3, 4, 5, 6].map(|k| round(random(i, k)));
        let m = Material { color, roughness, metallic, clearcoat, clearcoat_roughness };
        (m, direction(i, 10), direction(i, 20), 0.3 * round(random(i, 7)))
    };
    let input: Vec<[f32; 4]> = (0..count)
        .flat_map(|i| {
            let (m, v, l, spread) = case(i);
            let more = [m.roughness, m.metallic, m.clearcoat, m.clearcoat_roughness];
            [m.color.extend(0.0).to_array(), more, v.extend(0.0).to_array(), l.extend(spread).to_array()]
        })
        .collect();
    let found: Vec<[f32; 4]> = gpu::evaluate(gpu, code, &[], &input, count as usize);
    let mut lit = 0;
    for (i, found) in (0..count).zip(found) {
        let (m, v, l, spread) = case(i);
        let wanted = m.evaluate(Vec3::Y, v, l, spread);
        lit += u32::from(wanted != Vec3::ZERO);
        let found = Vec4::from(found).truncate();
        // Narrow lobes amplify the rounding of the half vector.
        let away = (found - wanted).abs().max_element();
        assert!(
            away <= 2e-3 * (0.01 + wanted.max_element()),
            "{m:?} {v} {l} {spread}: {found}, wanted {wanted}"
        );
    }
    assert!(lit > count / 3, "{lit}");
}

#[test]
fn objects_are_shaded_as_by_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    let mut world = gpu::world(&format!("{BALL}{LIGHTS}[environment]\nlights = 6\n{THINGS}"));
    // A map on the ground, read by its uv.
    world.maps.images.push(gpu::image("tiles", true, 8, |u, v| [u, v, 0.4, 1.0]));
    let map = ColorMap { map: "tiles".into(), layer: String::new(), value: [0.9, 0.8, 0.7] };
    let color = Color::Mapped(map);
    world.scene.objects[0].material.color = color.clone();
    world.objects[0].material.color = color;
    let film = [96, 64];
    let fixture = Fixture::with_features(gpu, world, true);
    let (skin, size) = (fixture.world.skin.triangles.len(), [76, 64]);
    let tile = fixture.tile(film, [20, 0], size, 16);
    tile.draw_base().unwrap();
    let fur = FurCells::of(&fixture.world, &fixture.packed, &fixture.shell);
    let around = Surroundings::new(&fixture.world, &fixture.packed, &fur);
    let records = tile.base_records().unwrap();
    let words: Vec<u32> = tile.read("samples", 16 * tile.samples()).unwrap();
    let (mut seen, mut wrong, mut lit) = ([0u32; 4], 0u32, 0u32);
    for (i, id) in gpu::triangle_ids(&tile).into_iter().enumerate() {
        let Some(behind) = (id as usize).checked_sub(skin + 1) else {
            assert!(id == 0 || words[16 * i + 9] == 0, "the skin is no object");
            continue;
        };
        let place = around.place_of(behind).expect("an object");
        let wanted = around.shade(&tile.frame, place, tile.xy(i));
        let found = unpack(records[i]);
        seen[place.0] += 1;
        gpu::close(found.z, wanted.base.z, 1e-5, format!("depth at {:?}", tile.xy(i)));
        assert!((found.normal - wanted.base.normal).length() < 3e-3, "{found:?} {wanted:?}");
        assert_eq!(words[16 * i + 9], place.0 as u32 + 1, "the number of the object");
        assert!((unpack_albedo(words[16 * i + 8]) - wanted.albedo).abs().max_element() < 2e-3, "{wanted:?}");
        let away = (found.radiance - wanted.base.radiance).abs().max_element();
        let near = away < 4e-3 * (0.05 + wanted.base.radiance.max_element())
            && (found.transparency - wanted.base.transparency).abs() < 3e-3;
        // Rays that graze an edge may fall on either side.
        wrong += u32::from(!near);
        lit += u32::from(wanted.base.radiance.max_element() > 0.1);
    }
    println!("seen {seen:?}, lit {lit}, wrong {wrong}");
    assert!(seen.iter().all(|n| *n > 40), "{seen:?}");
    assert!(lit > 500 && wrong * 100 < seen.iter().sum::<u32>(), "{wrong} wrong of {seen:?}, {lit} lit");
}

/// Objects in front of the fur, and behind or within it.
#[test]
fn objects_cover_the_fur_behind_them() {
    let Some(_) = gpu::open() else { return };
    let of = |objects: &str| features(&gpu::world(&format!("{BALL}{LIGHTS}{objects}")));
    let ball = |z: f32, size: f32| {
        let y = z * 2.0 / 9.0; // in the middle of the picture
        format!(
            "[[objects]]\nname = \"b\"\nmesh = {{ shape = \"sphere\", size = {size}, translate = [0, {y}, {z}] }}\n"
        )
    };
    let (alone, front, within) = (of(""), of(&ball(3.0, 0.8)), of(&ball(0.0, 1.2)));
    let center = 96 * 32 + 48;
    let middle: Vec<usize> = (0..8).flat_map(|y| (0..8).map(move |x| center - 4 * 97 + 96 * y + x)).collect();
    let [guard, undercoat] = ["guard.A", "undercoat.A"].map(|name| mean(&alone, name, &middle));
    assert!(guard > 0.03 && undercoat > 0.03, "{guard} {undercoat}");
    for name in ["guard.A", "undercoat.A", "skin.A"] {
        assert_eq!(plane(&front, name)[center], 0.0, "{name}");
    }
    assert_eq!((plane(&front, "object1.A")[center], plane(&front, "base.A")[center]), (1.0, 1.0));
    assert!((plane(&front, "depth.Z")[center] - (85f32.sqrt() * 6.0 / 9.0 - 0.4)).abs() < 0.05);
    // What the skin hides changes nothing: neither the picture nor the shadows.
    let kept: Vec<_> = within.planes.iter().filter(|p| alone.plane(&p.name).is_some()).cloned().collect();
    let within = Film { planes: kept, ..within };
    assert_eq!(differing(&alone, &within), []);
}

/// Light that crosses straight upright hairs to a wall is attenuated by the area that the hairs
/// project onto it.
#[test]
fn fur_darkens_what_lies_behind_it() {
    let Some(_) = gpu::open() else { return };
    let straight = "[guard]\nlength = 1\nlength_variation = 0\ngravity = 0\nspread = 0\nclump = 0\ncurl = 0\nfrizz = 0\n\
        comb = 0\nthickness = 1\nopacity = 1\ntip_fade = 0\nsegments = 2\nroot_darkening = [1, 0.1]\n";
    let rows = [
        ("guard", "density = 400\ndiameter = [7.5, 7.5, 7.5]\n", "[undercoat]\ndensity = 0\n"),
        (
            "undercoat",
            "density = 0\n",
            "[undercoat]\ndensity = 200\ndiameter = [15, 15]\nheight = 1\nheight_variation = 0\nnoise_contrast = 0\n\
             tangent_jitter = 0\nlean = 0\nlayers = 8\nsubdivision = 0\n",
        ),
    ];
    // 400 x 7.5 µm or 200 x 15 µm: 0.3 per cm on 4 cm.
    let wanted = (-0.3f32 * 4.0).exp();
    for (layer, guard, undercoat) in rows {
        let scene = format!(
            "[mesh]\nshape = \"plane\"\nsize = 4\n[camera]\neye = [6, 1.2, 0]\ntarget = [-2.5, 1.2, 0]\nfov = 24\n\
             [film]\nwidth = 64\nheight = 64\nspp = 4\nfilter = \"box\"\n[[lights]]\ndirection = [1, 0, 0]\n\
             irradiance = [3, 3, 3]\n{straight}{guard}{undercoat}\
             [[objects]]\nname = \"wall\"\nmesh = {{ shape = \"plane\", size = 6, rotate = [0, 0, -90], translate = [-2.5, 0, 0] }}\n\
             material = {{ roughness = 1, color = [0.8, 0.8, 0.8] }}\n"
        );
        let film = features(&gpu::world(&scene));
        // The light of the wall alone, relative to how much of it is seen through the fur.
        let at = |low: f32, high: f32| -> Vec<usize> {
            (0..64 * 64)
                .filter(|i| {
                    // Height at the wall, 8.5 cm from the eye.
                    let y = 1.2 + 8.5 * 12f32.to_radians().tan() * (1.0 - (*i as f32 / 64.0).floor() / 32.0);
                    let z = 8.5 * 12f32.to_radians().tan() * ((*i % 64) as f32 / 32.0 - 1.0);
                    y > low && y < high && z.abs() < 1.4
                })
                .collect()
        };
        let light = |pixels: &[usize]| mean(&film, "base.R", pixels) / mean(&film, "object1.A", pixels);
        let (lit, dimmed) = (light(&at(1.2, 2.2)), light(&at(0.25, 0.75)));
        println!("{layer}: {}, wanted {wanted}", dimmed / lit);
        assert!(lit > 0.4, "{layer}: {lit}");
        assert!((dimmed / lit - wanted).abs() < 0.05 * wanted, "{layer}: {} is not {wanted}", dimmed / lit);
    }
}

/// Rays at any angle, against the twin, and a grid without fur.
#[test]
fn depths_of_the_grid_do_not_depend_on_the_direction_of_travel() {
    let Some(gpu) = gpu::open() else { return };
    let fixture = Fixture::new(gpu, gpu::world(&format!("{BALL}{LIGHTS}")));
    let fur = FurCells::of(&fixture.world, &fixture.packed, &fixture.shell);
    let mut deepest = 0f32;
    for i in 0..200 {
        let d = Vec3::from([0, 1, 2].map(|k| 2.0 * random(i, k) - 1.0)).normalize();
        let far = 5.0 * Vec3::from([3, 4, 5].map(|k| random(i, k) - 0.5));
        let [there, back] = [(far - 9.0 * d, d), (far + 9.0 * d, -d)].map(|(o, d)| fur_depth(&fur, o, d));
        gpu::close(there, back, 1e-3, format!("ray {i}"));
        deepest = deepest.max(there);
    }
    assert!(deepest > 1.0, "{deepest}");
    let bare = Fixture::new(
        gpu,
        gpu::world("[mesh]\nshape = \"sphere\"\n[guard]\ndensity = 0\n[undercoat]\ndensity = 0\n"),
    );
    let none = FurCells::of(&bare.world, &bare.packed, &bare.shell);
    assert_eq!(fur_depth(&none, Vec3::new(0.0, 9.0, 0.0), -Vec3::Y), 0.0);
}

#[test]
fn objects_cast_shadows_on_fur_and_skin() {
    let Some(gpu) = gpu::open() else { return };
    let scene = |fur: &str| {
        format!(
            "[mesh]\nshape = \"plane\"\nsize = 4\n[camera]\neye = [0, 4, 9]\nfov = 30\n[film]\nwidth = 64\nheight = 40\nspp = 4\n\
             [[lights]]\ndirection = [0, 1, 0]\nirradiance = [3, 3, 3]\n[guard]\n{fur}length = 0.3\nspread = 0\n\
             [undercoat]\ndensity = 0\n\
             [[objects]]\nname = \"roof\"\nmesh = {{ shape = \"plane\", size = 6, translate = [3, 2.9, 0] }}\n"
        )
    };
    // Half of the square, x > 0, lies under the roof.
    let fixture = Fixture::new(gpu, gpu::world(&scene("density = 100\n")));
    let columns: Vec<Column> = fixture.read("columns", fixture.fur.lattice.columns as usize);
    let mut blocked = 0;
    for column in &columns {
        let (_, top) = node_place(&fixture.shell, &fixture.fur, column, fixture.fur.lattice.levels);
        if top.x.abs() > 0.01 {
            assert_eq!(column.blocked[0] & 1, u32::from(top.x > 0.0), "{top}");
            blocked += column.blocked[0] & 1;
        }
    }
    assert!(blocked as usize * 3 > columns.len(), "{blocked} of {}", columns.len());
    let pixels = |right: bool| -> Vec<usize> {
        let columns = if right { 37..44 } else { 21..28 };
        (24..36).flat_map(|y| columns.clone().map(move |x| 64 * y + x)).collect()
    };
    for (fur, layer) in [("density = 100\n", "guard"), ("density = 0\n", "base")] {
        let film = features(&gpu::world(&scene(fur)));
        let light = |right| {
            mean(&film, &format!("{layer}.G"), &pixels(right))
                / mean(&film, &format!("{layer}.A"), &pixels(right))
        };
        let (bright, dark) = (light(false), light(true));
        assert!(bright > 1e-3 && dark < 1e-3 * bright, "{layer}: {bright} {dark}");
    }
}

#[test]
fn shadow_catchers_show_the_missing_light_as_alpha() {
    let Some(_) = gpu::open() else { return };
    // A ball without fur, 1 cm above the catcher; light from above and, as strong, from the side.
    let scene = |lights: &str| {
        format!(
            "[mesh]\nshape = \"sphere\"\nsize = 1\ntranslate = [0, 1, 0]\n[guard]\ndensity = 0\n[undercoat]\ndensity = 0\n\
             [camera]\neye = [0, 5, 9]\ntarget = [0, 0, 0]\nfov = 30\n[film]\nwidth = 64\nheight = 48\nspp = 4\nfilter = \"box\"\n\
             {lights}[[objects]]\nname = \"floor\"\nmesh = {{ shape = \"plane\", size = 6 }}\nshadow_catcher = true\n"
        )
    };
    let above = "[[lights]]\ndirection = [0, 1, 0]\nirradiance = [2, 2, 2]\n";
    // Half as much on the floor: the cosine is 1/2.
    let beside = "[[lights]]\ndirection = [1.7320508, 1, 0]\nirradiance = [2, 2, 2]\n";
    let umbra = 64 * 24 + 32;
    let clear = 64 * 24 + 48;
    for (lights, alpha) in [(above.to_owned(), 1.0), (format!("{above}{beside}"), 2.0 / 3.0)] {
        let film = features(&gpu::world(&scene(&lights)));
        assert!((plane(&film, "A")[umbra] - alpha).abs() < 2e-3, "{}", plane(&film, "A")[umbra]);
        assert_eq!((plane(&film, "R")[umbra], plane(&film, "A")[clear]), (0.0, 0.0));
        assert_eq!(plane(&film, "depth.Z")[clear], f32::INFINITY);
        assert!((plane(&film, "object1.A")[umbra] - alpha).abs() < 2e-3);
        assert!(plane(&film, "A")[64 * 47] == 0.0 && plane(&film, "base.R")[64 * 15 + 32] > 0.05);
    }
}

#[test]
fn a_scene_of_objects_alone_renders() {
    let Some(_) = gpu::open() else { return };
    let bare = "[guard]\ndensity = 0\n[undercoat]\ndensity = 0\n";
    for fur in ["hybrid", "base", "explicit", "implicit"] {
        let ball = BALL.split("[guard]").next().unwrap_or_default();
        let world = gpu::world(&format!("{ball}{bare}[render]\nfur = \"{fur}\"\n{LIGHTS}{THINGS}"));
        let film = features(&world);
        let total = |name: &str| plane(&film, name).iter().sum::<f32>();
        assert!(["object1.A", "object2.A", "object3.A"].iter().all(|name| total(name) > 10.0), "{fur}");
        assert!(
            (total("skin.A") + (1..5).map(|k| total(&format!("object{k}.A"))).sum::<f32>() - total("A"))
                .abs()
                < 1.0
        );
        assert!(total("R") > 10.0 && total("guard.A") == 0.0, "{fur}");
    }
}

/// A ball of eight segments is shaded as round: no triangle on the lit side is in shadow.
#[test]
fn coarse_meshes_have_no_stripes_at_the_terminator() {
    let Some(gpu) = gpu::open() else { return };
    let mut world = gpu::world(
        "[mesh]\nshape = \"sphere\"\nscale = 0.02\ntranslate = [0, -9, 0]\n[guard]\ndensity = 0\n[undercoat]\ndensity = 0\n\
         [camera]\neye = [0, 0, 9]\nfov = 16\n[film]\nwidth = 48\nheight = 48\n[[lights]]\ndirection = [0.8, 0.36, 0.48]\n\
         [[objects]]\nname = \"ball\"\nmesh = { shape = \"sphere\", size = 2 }\ncrease = 180\n",
    );
    // An octahedron cut twice, on the sphere: edges of about 20 degrees.
    let corners = [Vec3::X, Vec3::Y, Vec3::Z];
    let mut positions = Vec::new();
    for signs in 0..8u32 {
        let mut p = [0, 1, 2].map(|k| if signs >> k & 1 == 1 { -corners[k] } else { corners[k] });
        if signs.count_ones() % 2 == 1 {
            p.swap(1, 2); // counter-clockwise from outside
        }
        let at = |i: u32, j: u32| {
            let (u, v) = (i as f32 / 4.0, j as f32 / 4.0);
            (p[0] * (1.0 - u - v) + p[1] * u + p[2] * v).normalize()
        };
        for (i, j) in (0..4).flat_map(|i| (0..4 - i).map(move |j| (i, j))) {
            positions.extend([at(i, j), at(i + 1, j), at(i, j + 1)]);
            if i + j < 3 {
                positions.extend([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    let surface = &mut world.objects[0].surface;
    surface.triangles = (0..positions.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    surface.normals = positions.clone();
    surface.colors = vec![Vec3::ONE; positions.len()];
    surface.alphas.clear();
    surface.corner_uv = None;
    surface.positions = positions;
    let fixture = Fixture::new(gpu, world);
    let tile = fixture.tile([48, 48], [0, 0], [48, 48], 16);
    tile.draw_base().unwrap();
    let (mut lit, mut dark) = (0, 0);
    for base in tile.base_records().unwrap().into_iter().map(unpack).filter(|b| b.z < 1e29) {
        let cosine = base.normal.dot(Vec3::new(0.8, 0.36, 0.48));
        if cosine > 0.02 {
            lit += 1;
            dark += u32::from(base.radiance.x <= 0.0);
        }
    }
    assert!(lit > 500 && dark == 0, "{dark} of {lit} are in shadow");
}

#[test]
fn pictures_name_their_objects() {
    let Some(_) = gpu::open() else { return };
    let folder = Folder::new();
    let (scene, picture) = (folder.at("scene.toml"), folder.at("a.exr"));
    std::fs::write(&scene, format!("{BALL}{LIGHTS}{THINGS}")).unwrap();
    pelage(&["render", &scene, "-o", &picture, "-D", "film.background=transparent"]).expect(0, &[]);
    let (film, meta) = (io::read(&picture).unwrap(), io::read_metadata(&picture).unwrap());
    let manifest = |set: &str| {
        let key = format!("cryptomatte/{}/manifest", &format!("{:08x}", cryptomatte::hash(set))[..7]);
        meta.attribute(&key).unwrap_or_else(|| panic!("no manifest of {set}")).to_owned()
    };
    for name in ["sphere", "ground", "eye", "bar", "catcher"] {
        assert!(manifest("CryptoObject").contains(&format!("\"{name}\"")), "{}", manifest("CryptoObject"));
    }
    assert!(manifest("CryptoLayer").contains("\"objects\""));
    let sum = |set: &str, pixel: usize| {
        let ranks = (0..3).flat_map(|layer| ["g", "a"].map(|c| format!("{set}{layer:02}.{c}")));
        ranks.filter_map(|name| Some(film.plane(&name)?[pixel])).sum::<f32>()
    };
    let eye = cryptomatte::id("eye").to_bits();
    let mut of_eye = 0;
    for i in 0..96 * 64 {
        let alpha = plane(&film, "A")[i];
        assert!((sum("CryptoObject", i) - alpha).abs() < 2e-3, "pixel {i}");
        assert!((sum("CryptoLayer", i) - alpha).abs() < 2e-3, "pixel {i}");
        if plane(&film, "object2.A")[i] == 1.0 {
            of_eye += 1;
            assert_eq!(plane(&film, "CryptoObject00.r")[i].to_bits(), eye);
            let albedo = plane(&film, "Albedo.R")[i];
            assert!((albedo - 0.05).abs() < 1e-3, "{albedo}");
            let p = Vec3::from(["P.X", "P.Y", "P.Z"].map(|name| plane(&film, name)[i]));
            assert!((p.distance(Vec3::new(0.3, 0.6, 1.0)) - 0.4).abs() < 0.02, "{p}");
        }
    }
    assert!(of_eye > 10, "{of_eye}");
}

#[test]
fn faults_of_objects_are_named() {
    let fault = |text: &str| match Scene::parse(&format!("[mesh]\nshape = \"sphere\"\n{text}"), "t.toml", &[])
    {
        Err(e) => e.to_string(),
        Ok(_) => panic!("{text} is valid"),
    };
    let object = |name: &str, more: &str| format!("[[objects]]\nname = \"{name}\"\n{more}\n");
    let cube = "mesh = { shape = \"cube\" }";
    assert!(fault(&object("", cube)).contains("name"));
    assert!(fault(&object("a", "")).contains("has no mesh"));
    assert!(fault(&(object("a", cube) + &object("a", cube))).contains("an earlier object is called \"a\""));
    assert!(fault(&object("sphere", cube)).contains("the matte of the body"));
    assert!(fault(&object("a", "mesh = { shape = \"cube\", front = \"x\" }")).contains("front"));
    assert!(fault(&object("a", &format!("{cube}\nmaterial = {{ roughness = 1.5 }}"))).contains("roughness"));
    assert!(fault(&object("a", "mesh = { shape = \"cube\", path = \"a.obj\" }")).contains("keep one"));
}

/// Shells and fins do not show objects, and say so; their shadows on the fur are seen.
#[test]
fn shells_say_that_they_show_no_objects() {
    if gpu::open().is_none() {
        return;
    }
    let folder = Folder::new();
    let picture = |name: &str, things: &str, notes: &[&str]| {
        let scene = folder.write(&format!("{name}.toml"), format!("{BALL}{LIGHTS}{things}"));
        let image = folder.at(&format!("{name}.png"));
        pelage(&["render", &scene, "--fur", "shells", "--size", "48x32", "-o", &image]).expect(0, notes);
        image::open(image).expect("a picture").into_rgba8()
    };
    let with = picture("with", THINGS, &["a picture of shells and fins does not show the scene's objects"]);
    let (mut darker, mut brighter) = (0, 0);
    for (with, without) in with.pixels().zip(picture("without", "", &[]).pixels()) {
        darker += usize::from(with[1] + 2 < without[1]);
        brighter += usize::from(with[1] > without[1] + 2);
    }
    assert!(darker > 20 && brighter == 0, "{darker} pixels are darker, {brighter} brighter");
}

/// A cube has sharp edges and flat sides, a ball none.
#[test]
fn creases_are_sharp_and_the_rest_is_round() {
    let of = |shape: &str, crease: f32| {
        let world = gpu::world(&format!(
            "[mesh]\nshape = \"plane\"\n[[objects]]\nname = \"a\"\ncrease = {crease}\nmesh = {{ shape = \"{shape}\" }}\n"
        ));
        world.objects[0].surface.clone()
    };
    let cube = of("cube", 40.0);
    // 9 x 9 vertices on each of six sides.
    assert_eq!(cube.positions.len(), 6 * 81);
    for (t, corners) in cube.triangles.iter().enumerate() {
        let [a, b, c] = cube.corners(t);
        let flat = (b - a).cross(c - a).normalize();
        assert!(corners.iter().all(|v| cube.normals[*v as usize].distance(flat) < 1e-5));
    }
    assert_eq!(of("cube", 100.0).positions.len(), 386);
    let ball = of("sphere", 40.0);
    assert_eq!(ball.positions.len(), of("sphere", 180.0).positions.len());
    assert!(ball.positions.iter().zip(&ball.normals).all(|(p, n)| p.normalize().distance(*n) < 0.01));
    // The rim of a cylinder is sharp, its side is not.
    let cylinder = of("cylinder", 40.0);
    let side =
        cylinder.positions.iter().zip(&cylinder.normals).filter(|(p, n)| p.y.abs() < 4.9 && n.y.abs() < 1e-4);
    assert!(side.clone().count() >= 48 * 71);
    assert!(side.into_iter().all(|(p, n)| Vec3::new(p.x, 0.0, p.z).distance(*n) < 0.01));
    assert_eq!(cylinder.normals.iter().filter(|n| n.y.abs() > 0.999).count(), 2 * 13 * 13);
}
