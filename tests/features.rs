//! Features of the film: albedo, normal, tangent, position and coverages, against the CPU twins and
//! against what is known of simple scenes.

use crate::common::gpu::{self, Fixture};
use crate::common::marched::Marched;
use crate::common::worlds::{ball, plane, square};
use glam::{Vec3, Vec4};
use pelage_core::film::Film;
use pelage_core::scene::{Blend, Filter, FurLayers, Lens, LensMethod, Scene};
use pelage_core::{World, film};
use pelage_fur::view::sample_ray;
use pelage_render::RenderOptions;
use pelage_render::twin::base_raster;
use pelage_render::twin::film::Features;
use pelage_render::twin::resolve::{
    Base, Gathered, Kind, Node, blend_fragments, exact_of, hair_normal, simplified_alpha,
};
use pelage_render::twin::undercoat_march::{Step, first_phase, look_up};

const BLENDS: [Blend; 3] = [Blend::Exact, Blend::Virtual, Blend::Simplified];

fn scene(blend: Blend) -> impl Fn(&mut Scene) {
    move |s| {
        s.render.blend = blend;
        s.render.virtual_fragments = 6;
        s.undercoat.density = 4000.0.into();
    }
}

fn render(world: &World, features: bool) -> Film {
    let options = RenderOptions { aovs: true, features, ..Default::default() };
    pelage_shells::render(world, &options).expect("a frame").film
}

/// Sum of the three layers of a blend of another quantity than radiance.
fn all(g: Gathered) -> Vec3 {
    g.guard + g.undercoat + g.base
}

/// Samples agree with what the twins make of the lists when they blend albedos, normals or tangents
/// in place of radiances. The skin's albedo is uniform, so that it is known.
fn agreement(blend: Blend) {
    let Some(gpu) = gpu::open() else { return };
    let world = ball(|s| {
        scene(blend)(s);
        s.base.color = [0.5, 0.25, 0.125].into();
    });
    let m = Marched::of(Fixture::with_features(gpu, world, true), [96, 64], [0, 0], [96, 64]);
    if blend != Blend::Exact {
        m.march();
    }
    m.draw_strands();
    let (lists, bases, records) = (m.nodes(), m.bases(), m.tile.base_records().unwrap());
    let inputs = m.inputs();
    let (mut seen, mut good) = (0u32, [0u32; 4]);
    for ((i, xy), found) in m.places().zip(m.resolve(blend == Blend::Exact)) {
        let Features { albedo, normal, tangent, coverage, object } = found.features.expect("features");
        assert_eq!(object, 0, "a scene without objects");
        let ray = sample_ray(&m.tile.frame, xy);
        let view = -ray.normalize();
        let blended = |of_node: &dyn Fn(&Node) -> Vec3, of_step: &dyn Fn(&Step) -> Vec3, of_base: Vec3| {
            let list =
                lists[i].iter().map(|n| Node { color: (of_node(n) * n.color.w).extend(n.color.w), ..*n });
            let base = bases[i].map(|b| Base { radiance: of_base, ..b });
            let list: Vec<Node> = list.collect();
            if blend == Blend::Exact {
                exact_of(&inputs, list, ray, first_phase(&m.tile.frame, xy), base, of_step)
            } else {
                blend_fragments(&m.fixture.fur.undercoat, list, base)
            }
        };
        let medium = |s: &Step| inputs.undercoat.at(&s.place).tangent;
        let ones = blended(&|_| Vec3::ONE, &|_| Vec3::ONE, Vec3::ONE);
        if ones.through == 1.0 {
            assert_eq!((albedo, coverage), (Vec3::ZERO, Vec3::ZERO), "sample {xy:?}");
            continue;
        }
        seen += 1;
        let of_skin = base_raster::unpack(records[i]).normal;
        let wanted = [
            (
                albedo,
                all(blended(
                    &|n| n.albedo,
                    &|s| look_up(&inputs, &s.place).albedo,
                    Vec3::new(0.5, 0.25, 0.125),
                )),
            ),
            (
                normal,
                all(blended(&|n| hair_normal(n.tangent, view), &|s| hair_normal(medium(s), view), of_skin)),
            ),
            (tangent, all(blended(&|n| n.tangent, &medium, Vec3::ZERO))),
            (coverage, Vec3::new(ones.guard.x, ones.undercoat.x, ones.base.x)),
        ];
        for (good, (found, wanted)) in good.iter_mut().zip(wanted) {
            *good += u32::from((found - wanted).abs().max_element() < 4e-3);
        }
        // Alpha as the sample holds it.
        let sum = coverage.element_sum();
        assert!((sum - (1.0 - found.through)).abs() < 2e-6, "sample {xy:?}: {coverage} of {}", found.through);
    }
    println!("{blend:?}: {good:?} of {seen} agree");
    assert!(seen > 1000, "{seen}");
    // A step at the border of a subelement may read its neighbour.
    let least = if blend == Blend::Exact { 0.97 } else { 0.999 };
    assert!(good.iter().all(|g| f64::from(*g) > least * f64::from(seen)), "{blend:?}: {good:?} of {seen}");
}

#[test]
fn exact_blend_agrees_with_its_twin() {
    agreement(Blend::Exact);
}

#[test]
fn virtual_blend_agrees_with_its_twin() {
    agreement(Blend::Virtual);
}

#[test]
fn simplified_blend_agrees_with_its_twin() {
    agreement(Blend::Simplified);
}

/// The twin of the comparison above can tell wrong features from right ones.
#[test]
fn twin_weighs_by_what_is_visible() {
    let node = |z, kind: u32, alpha| Node {
        z,
        source: kind << 30,
        color: Vec4::splat(alpha),
        albedo: Vec3::ONE,
        ..Node::default()
    };
    let mut fur = pelage_fur::groom::pack(&ball(|_| ())).expect("a groom").undercoat;
    fur.virtual_fragments = 4;
    let g = blend_fragments(&fur, vec![node(1.0, 0, 0.25), node(2.0, 2, 0.5)], None);
    assert_eq!((g.guard.x, g.undercoat.x), (0.25, 0.375));
    assert_eq!(node(1.0, 2, 0.5).kind(), Kind::Volume);
    assert_eq!(simplified_alpha(1.0, &node(1.0, 2, 0.5), &[]), 0.5);
    let view = Vec3::new(0.0, 0.6, 0.8);
    assert!((hair_normal(Vec3::Y, view) - Vec3::Z).length() < 1e-6);
    assert_eq!(hair_normal(view, view), view);
}

/// The colour and its parts are the same bits with and without features, in any tiles and out of
/// core.
#[test]
fn features_do_not_change_the_picture() {
    for blend in BLENDS {
        let world = ball(|s| {
            scene(blend)(s);
            s.film.filter = Filter::Gaussian;
        });
        let (without, with) = (render(&world, false), render(&world, true));
        assert!(with.planes.len() > without.planes.len());
        for a in &without.planes {
            let b = plane(&with, &a.name);
            let other = a.data.iter().zip(b).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
            assert_eq!(other, 0, "{blend:?}: pixels of {}", a.name);
        }
        let tiled = render(
            &ball(|s| {
                scene(blend)(s);
                s.film.filter = Filter::Gaussian;
                s.render.tile = Some(40);
            }),
            true,
        );
        let differing = crate::common::worlds::differing(&with, &tiled);
        assert!(differing.is_empty(), "{blend:?}: {differing:?}");
    }
}

/// Vectors of a film: three planes whose names end in the given letters.
fn vectors(film: &Film, name: &str, axes: &str) -> Vec<Vec3> {
    let planes: Vec<&[f32]> = axes.chars().map(|c| plane(film, &format!("{name}.{c}"))).collect();
    (0..film.pixels()).map(|i| Vec3::new(planes[0][i], planes[1][i], planes[2][i])).collect()
}

#[test]
fn skin_alone_has_its_own_albedo_normal_and_position() {
    if gpu::open().is_none() {
        return;
    }
    // A square in the plane y = 0 that faces up.
    let world = square(|s| {
        s.render.fur = FurLayers::Base;
        s.base.color = [0.8, 0.4, 0.2].into();
    });
    let film = render(&world, true);
    let alpha = plane(&film, "A");
    let (albedo, normal) = (vectors(&film, "Albedo", "RGB"), vectors(&film, "N", "XYZ"));
    let (position, tangent) = (vectors(&film, "P", "XYZ"), vectors(&film, "Tangent", "XYZ"));
    let (depth, base) = (plane(&film, "depth.Z"), plane(&film, "base.A"));
    let eye = Vec3::from(world.scene.camera.eye);
    let forward = (Vec3::from(world.scene.camera.target) - eye).normalize();
    let mut seen = 0;
    for i in 0..film.pixels() {
        let a = alpha[i];
        assert!((albedo[i] - a * Vec3::new(0.8, 0.4, 0.2)).abs().max_element() < 2e-3, "{}", albedo[i]);
        assert!((normal[i] - a * Vec3::Y).abs().max_element() < 1e-3, "{}", normal[i]);
        assert_eq!((tangent[i], base[i]), (Vec3::ZERO, a));
        if a > 0.0 {
            seen += 1;
            let p = position[i] / a;
            assert!(p.y.abs() < 1e-4 && p.x.abs() < 1.01 && p.z.abs() < 1.01, "{p}");
            assert!(((p - eye).dot(forward) - depth[i]).abs() < 1e-3);
        }
    }
    assert!(seen > 1000, "{seen}");
}

#[test]
fn fur_has_the_colour_of_its_hairs() {
    if gpu::open().is_none() {
        return;
    }
    for blend in BLENDS {
        let world = ball(|s| {
            scene(blend)(s);
            let brown = [0.5, 0.3, 0.2];
            s.guard.color_root = brown.into();
            s.guard.color_tip = brown.into();
            s.guard.color_variation = 0.0;
            s.undercoat.color_root = brown.into();
            s.undercoat.color_tip = brown.into();
            s.base.color = brown.into();
        });
        let film = render(&world, true);
        let (alpha, albedo) = (plane(&film, "A"), vectors(&film, "Albedo", "RGB"));
        let (normal, tangent) = (vectors(&film, "N", "XYZ"), vectors(&film, "Tangent", "XYZ"));
        let position = vectors(&film, "P", "XYZ");
        let layers = ["guard.A", "undercoat.A", "base.A"].map(|name| plane(&film, name));
        let (mut facing, mut outwards, mut seen) = (0.0, 0.0, 0.0);
        for i in 0..film.pixels() {
            let a = alpha[i];
            let wanted = a * Vec3::new(0.5, 0.3, 0.2);
            assert!((albedo[i] - wanted).abs().max_element() < 3e-3, "{blend:?}: {} at {a}", albedo[i]);
            assert!((layers.iter().map(|l| l[i]).sum::<f32>() - a).abs() < 1e-5);
            assert!(normal[i].length() <= a + 1e-3 && tangent[i].length() <= a + 1e-3);
            if a > 0.5 {
                seen += 1.0;
                let p = position[i] / a;
                assert!(p.length() < 1.7, "{p}");
                facing += (Vec3::from(world.scene.camera.eye) - p).normalize().dot(normal[i] / a);
                outwards += p.normalize().dot(tangent[i] / a);
            }
        }
        println!("{blend:?}: {} {}", facing / seen, outwards / seen);
        // Ribbons face the camera, hairs grow outwards.
        assert!(seen > 500.0 && facing / seen > 0.5 && outwards / seen > 0.4);
    }
}

#[test]
fn shells_keep_only_what_they_know() {
    if gpu::open().is_none() {
        return;
    }
    let world = ball(|s| {
        s.render.fur = FurLayers::Shells;
        s.bake.resolution = [32; 2];
    });
    let film = render(&world, true);
    for name in ["Albedo.R", "N.X", "Tangent.X", "guard.A"] {
        assert!(film.plane(name).is_none(), "{name}");
    }
    let (alpha, position) = (plane(&film, "A"), vectors(&film, "P", "XYZ"));
    let far = (0..film.pixels()).filter(|i| alpha[*i] > 0.9 && (position[*i] / alpha[*i]).length() > 1.8);
    assert_eq!(far.count(), 0);
    assert!(position.iter().any(|p| *p != Vec3::ZERO));
}

/// Depth of field as a post-process blurs what is weighted like a colour; the rest stays sharp.
#[test]
fn depth_of_field_blurs_albedo_and_coverage_alone() {
    if gpu::open().is_none() {
        return;
    }
    let world = ball(|s| {
        s.camera.lens = Some(Lens { aperture: 0.5, focus: Some(3.0), method: LensMethod::Post });
    });
    let sharp = render(&world, true);
    let mut blurred = sharp.clone();
    film::depth_of_field::apply(&mut blurred, &world.scene.camera).unwrap();
    for (name, same) in
        [("Albedo.R", false), ("guard.A", false), ("N.X", true), ("P.X", true), ("Tangent.X", true)]
    {
        assert_eq!(plane(&sharp, name) == plane(&blurred, name), same, "{name}");
    }
}
