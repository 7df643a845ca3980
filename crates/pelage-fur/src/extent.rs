//! How large a fur will be, estimated before any work begins, the bounds on it, and what looks
//! like a mistake in the units of the mesh or in the view.

use crate::groom;
use crate::surface::{number_edges, subdivide};
use glam::Vec3;
use pelage_core::{Error, Result, SceneFault, Skin, World};

/// Largest number of guard hairs: a hundred times as many as a large furry animal in a close view
/// needs, and still hours of work.
pub const MOST_GUARD_HAIRS: f64 = 2e8;

/// Number of guard hairs above which a body looks too large for its coat: a large dog has fewer.
pub const MANY_GUARD_HAIRS: f64 = 5e6;

/// Length of the longest hair, relative to the longest side of the body, above which a coat looks
/// like a mistake.
pub const LONGEST_PART: f32 = 0.25;

/// Expected size of a fur, with the largest values of all coats and maps.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Extent {
    /// Area of the skin, cm².
    pub area: f64,
    /// Longest side of the skin's bounding box, cm.
    pub longest_side: f32,
    /// Length of the longest hair that is drawn, cm.
    pub longest_hair: f32,
    /// Guard hairs.
    pub guard_hairs: f64,
    /// Hairs of the undercoat, which the renderer marches as a volume.
    pub undercoat_hairs: f64,
    /// Subelements of the volume.
    pub subelements: u64,
}

impl Extent {
    /// The extent of a world's fur, as far as it is drawn.
    pub fn of(world: &World) -> Self {
        let (scene, skin) = (&world.scene, &world.skin);
        let [guard, undercoat] = [groom::has_guard(scene), groom::has_undercoat(scene)];
        let density = if guard { f64::from(groom::guard_density(scene).max(0.0)) } else { 0.0 };
        let area = skin.area();
        let length = if guard { groom::guard_length(scene) } else { 0.0 };
        let height = scene.largest(|coat| coat.undercoat.height.max());
        let undercoat_density = scene.largest(|coat| coat.undercoat.density.max());
        Self {
            area,
            longest_side: longest_side(skin),
            longest_hair: length.max(if undercoat { height } else { 0.0 }),
            guard_hairs: area * density,
            undercoat_hairs: if undercoat { area * f64::from(undercoat_density.max(0.0)) } else { 0.0 },
            subelements: subdivide(skin, world, undercoat).1,
        }
    }

    /// Checks the bounds, and returns what looks like a mistake. `strands`: the guard hairs will
    /// grow one by one.
    ///
    /// # Errors
    /// [`Error::Scene`] with the numbers and the keys to change if there would be too many hairs.
    pub fn check(&self, strands: bool) -> Result<Vec<String>> {
        let size = format!(
            "{:.3e} cm² of skin, whose longest side is {} cm",
            self.area,
            significant(self.longest_side)
        );
        let fault = |message: String, help: &str| {
            let fault = SceneFault {
                file: "guard.density".into(),
                line: 0,
                column: 0,
                message,
                help: Some(help.into()),
            };
            Err(Error::Scene(vec![fault]))
        };
        if strands && self.guard_hairs > MOST_GUARD_HAIRS {
            return fault(
                format!(
                    "found {:.3e} guard hairs on {size}, expected at most {MOST_GUARD_HAIRS:.0e}",
                    self.guard_hairs
                ),
                "if the mesh is not in centimetres, set mesh.size to the length of its longest side in cm, or mesh.scale; \
                 otherwise lower guard.density",
            );
        }
        let mut notes = Vec::new();
        if strands && self.guard_hairs > MANY_GUARD_HAIRS {
            notes.push(format!(
                "warning: {:.1} million guard hairs on {size}, which may take hours: if the body is smaller than that, set \
                 mesh.size; if it is not, fewer and thicker hairs (guard.density, guard.diameter) look the same from afar",
                self.guard_hairs * 1e-6
            ));
        }
        let drawn = self.guard_hairs > 0.0 || self.undercoat_hairs > 0.0;
        if drawn && self.guard_hairs.max(self.undercoat_hairs) < 1.0 {
            notes.push(format!(
                "no hair is expected on {size}: if the mesh is not in centimetres, set mesh.size to the length of its longest \
                 side in cm"
            ));
        } else if self.longest_hair > LONGEST_PART * self.longest_side && self.longest_side > 0.0 {
            notes.push(format!(
                "the longest hair has {} cm, more than a quarter of the body's longest side, {} cm: if the body has that size, \
                 set groom.scale (with {} the longest hair has a tenth of it); if not, set mesh.size",
                significant(self.longest_hair),
                significant(self.longest_side),
                significant(0.1 * self.longest_side / self.longest_hair)
            ));
        }
        Ok(notes)
    }
}

/// A positive number with three significant digits.
fn significant(x: f32) -> String {
    if x <= 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let digits = (2 - x.log10().floor() as i32).clamp(0, 12);
    let text = format!("{x:.*}", digits as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn longest_side(skin: &Skin) -> f32 {
    let (low, high) = skin.bounds();
    if skin.positions.is_empty() { 0.0 } else { (high - low).max_element() }
}

/// What looks like a mistake in the view of the scene's camera: an eye within the fur or the body,
/// a fur that lies wholly outside the picture.
pub fn notes_of_view(world: &World) -> Vec<String> {
    let (scene, skin) = (&world.scene, &world.skin);
    let longest = Extent::of(world).longest_hair;
    let eye = Vec3::from(scene.camera.eye);
    let mut notes = Vec::new();
    if let Some((distance, outside)) = distance_to(skin, eye) {
        if !outside && is_closed(skin) {
            notes.push(format!(
                "the camera is inside the body, {} cm below the skin: move camera.eye",
                significant(distance)
            ));
        } else if distance < longest {
            notes.push(format!(
                "the camera is inside the fur ({} cm above the skin; hairs are up to {} cm long): hairs behind it are missing, \
                 and light is wrong near it; move camera.eye",
                significant(distance),
                significant(longest)
            ));
        }
    }
    if is_out_of_view(world, longest) {
        let (low, high) = skin.bounds();
        notes.push(format!(
            "no part of the fur is in the picture: the body lies around {}, and the camera at {eye} looks at {}; set camera.target",
            0.5 * (low + high),
            Vec3::from(scene.camera.target)
        ));
    }
    notes
}

/// Distance from `p` to the skin, cm, and whether `p` is on the outer side of the nearest point.
fn distance_to(skin: &Skin, p: Vec3) -> Option<(f32, bool)> {
    let nearest = (0..skin.triangles.len()).map(|t| {
        let l = nearest_on_triangle(skin.corners(t), p);
        let [a, b, c] = skin.corners(t);
        let at = l.x * a + l.y * b + l.z * c;
        (p.distance_squared(at), t, l, at)
    });
    let (squared, t, l, at) = nearest.min_by(|a, b| a.0.total_cmp(&b.0))?;
    // The smoothed normal also decides over edges and corners.
    let [a, b, c] = skin.triangles[t].map(|v| skin.normals.get(v as usize).copied().unwrap_or(Vec3::Y));
    let normal = l.x * a + l.y * b + l.z * c;
    Some((squared.sqrt(), (p - at).dot(normal) >= 0.0))
}

/// Barycentric coordinates of the point of a triangle that is nearest to `p`.
fn nearest_on_triangle([a, b, c]: [Vec3; 3], p: Vec3) -> Vec3 {
    let along = |from: Vec3, to: Vec3| {
        let edge = to - from;
        ((p - from).dot(edge) / edge.length_squared().max(1e-30)).clamp(0.0, 1.0)
    };
    let normal = (b - a).cross(c - a);
    let part = |u: Vec3, v: Vec3| (u - p).cross(v - p).dot(normal);
    let inner = Vec3::new(part(b, c), part(c, a), part(a, b));
    if inner.min_element() >= 0.0 && normal.length_squared() > 0.0 {
        return inner / inner.element_sum();
    }
    let [ab, bc, ca] = [along(a, b), along(b, c), along(c, a)];
    [Vec3::new(1.0 - ab, ab, 0.0), Vec3::new(0.0, 1.0 - bc, bc), Vec3::new(ca, 0.0, 1.0 - ca)]
        .into_iter()
        .min_by(|l, m| {
            let squared = |l: &Vec3| p.distance_squared(l.x * a + l.y * b + l.z * c);
            squared(l).total_cmp(&squared(m))
        })
        .unwrap_or(Vec3::X)
}

/// Whether every edge has two sides.
fn is_closed(skin: &Skin) -> bool {
    let (_, edges) = number_edges(skin);
    !skin.triangles.is_empty() && 2 * edges as usize == 3 * skin.triangles.len()
}

/// Whether the box around the fur lies wholly beyond one side of the view.
fn is_out_of_view(world: &World, longest: f32) -> bool {
    let (scene, skin) = (&world.scene, &world.skin);
    if skin.positions.is_empty() {
        return false;
    }
    let film = [scene.film.width, scene.film.height];
    let frame = crate::camera::frame(&scene.camera, film, glam::Vec2::ZERO, glam::Vec2::ZERO, 0);
    let (low, high) = skin.bounds();
    let (low, high) = (low - longest, high + longest);
    let corners: Vec<[f32; 3]> = (0..8)
        .map(|i| {
            let side = |bit: u32, a: f32, b: f32| if i & bit == 0 { a } else { b };
            let corner = Vec3::new(side(1, low.x, high.x), side(2, low.y, high.y), side(4, low.z, high.z));
            let d = corner - Vec3::from(frame.eye);
            [frame.right, frame.up, frame.forward].map(|axis| d.dot(Vec3::from(axis)))
        })
        .collect();
    let beyond = |outside: &dyn Fn(&[f32; 3]) -> bool| corners.iter().all(outside);
    beyond(&|[_, _, z]| *z < frame.near)
        || beyond(&|[x, _, z]| *x > frame.tan_x * z)
        || beyond(&|[x, _, z]| -*x > frame.tan_x * z)
        || beyond(&|[_, y, z]| *y > frame.tan_y * z)
        || beyond(&|[_, y, z]| -*y > frame.tan_y * z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_core::Scene;
    use pelage_core::assets::Assets;

    fn world(more: &str) -> World {
        let text = format!("[mesh]\nshape = \"sphere\"\n[[lights]]\n[camera]\neye = [0, 6, 24]\n{more}");
        let scene = Scene::parse(&text, "test", &[]).expect("a scene");
        World::load(scene, &Assets::default()).expect("a world")
    }

    fn sized(cm: f32) -> World {
        let mut scene = world("").scene;
        scene.mesh.size = Some(cm);
        World::load(scene, &Assets::default()).expect("a world")
    }

    #[test]
    fn counts_follow_area_and_density() {
        let extent = Extent::of(&world(""));
        let area = 4.0 * std::f64::consts::PI * 25.0;
        assert!((extent.guard_hairs / (300.0 * area) - 1.0).abs() < 0.02, "{extent:?}");
        assert!((extent.undercoat_hairs / (20_000.0 * area) - 1.0).abs() < 0.02, "{extent:?}");
        assert_eq!((extent.longest_hair, extent.longest_side), (2.0, 10.0));
        assert_eq!(extent.check(true).expect("within the bounds"), Vec::<String>::new());
    }

    #[test]
    fn a_body_in_the_wrong_unit_is_refused_or_noted() {
        let huge = Extent::of(&sized(10_000.0));
        let fault = huge.check(true).expect_err("too many hairs");
        assert_eq!(fault.exit_code(), 3);
        let text = fault.to_string();
        assert!(text.contains("mesh.size") && text.contains("10000 cm") && text.contains("2e8"), "{text}");
        assert!(huge.check(false).is_ok());
        let notes = Extent::of(&sized(0.0001)).check(true).expect("within the bounds");
        assert!(
            notes.len() == 1 && notes[0].contains("no hair") && notes[0].contains("0.0001 cm"),
            "{notes:?}"
        );
        let notes = Extent::of(&sized(4.0)).check(true).expect("within the bounds");
        assert!(notes.len() == 1 && notes[0].contains("groom.scale (with 0.2 "), "{notes:?}");
    }

    #[test]
    fn the_view_is_judged() {
        let notes = |eye: [f32; 3], target: [f32; 3]| {
            let mut world = world("");
            world.scene.camera.eye = eye;
            world.scene.camera.target = target;
            notes_of_view(&world).join("\n")
        };
        assert_eq!(notes([0.0, 6.0, 24.0], [0.0; 3]), "");
        let inside = notes([0.0, 0.0, 5.5], [0.0; 3]);
        assert!(inside.contains("inside the fur (0.5") && inside.contains("2 cm long"), "{inside}");
        assert!(notes([0.0, 0.0, 3.0], [0.0; 3]).contains("inside the body"), "eye in the sphere");
        let away = notes([0.0, 0.0, 24.0], [0.0, 0.0, 48.0]);
        assert!(away.contains("no part of the fur"), "{away}");
        assert!(notes([0.0, 0.0, 24.0], [30.0, 0.0, 24.0]).contains("no part of the fur"));
    }
}
