//! Parts of the skin: which triangles they choose, and what they share with the scene's own coat.

use crate::scene::{Ball, FurLayers, MAX_PARTS, Names, Part, Place};
use crate::skin::Section;
use crate::{Error, Result, Scene, SceneFault, Skin};
use glam::Vec3;

/// For each triangle whether it belongs to the groups and materials that `part` names; all do if it
/// names none.
pub fn chosen(skin: &Skin, part: &Part) -> Vec<bool> {
    if !part.has_sections() {
        return vec![true; skin.triangles.len()];
    }
    let among = |names: &Names, name: &String| names.is_empty() || names.list().contains(name);
    let of_section: Vec<bool> = skin
        .sections
        .iter()
        .map(|section| among(&part.group, &section.group) && among(&part.material, &section.material))
        .collect();
    let section = |t: usize| match skin.section_of.get(t) {
        Some(section) => Some(*section as usize),
        // All triangles are of the first.
        None => skin.section_of.is_empty().then_some(0),
    };
    let holds = |t| section(t).and_then(|s| of_section.get(s)).copied().unwrap_or(false);
    (0..skin.triangles.len()).map(holds).collect()
}

/// Checks that the mesh has the groups and materials that the parts of `scene` name, and that each
/// part has a triangle.
///
/// # Errors
/// [`Error::Scene`] with all names that are unknown, and the names that the mesh has.
pub fn check(scene: &Scene, skin: &Skin) -> Result<()> {
    let mut faults = Vec::new();
    if scene.parts.len() > MAX_PARTS {
        let found = scene.parts.len();
        return Err(Error::fault("parts", format!("found {found} parts, expected at most {MAX_PARTS}")));
    }
    for (i, part) in scene.parts.iter().enumerate() {
        let before = faults.len();
        let [group, material, balls] = &part.places;
        let mut unknown =
            |key: &str, plural: &str, names: &Names, place: &Place, of: fn(&Section) -> &str| {
                let known = names_of(skin, of);
                for name in names.list().iter().filter(|name| !known.contains(&name.as_str())) {
                    let list = known.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
                    let message = format!("parts.{i}.{key}: the mesh has no {key} \"{name}\"");
                    let help = match known.is_empty() {
                        true => format!("it has no {plural}: give balls or a mask instead"),
                        false => format!("its {plural} are {list}"),
                    };
                    faults.push(fault(place, message, help));
                }
            };
        unknown("group", "groups", &part.group, group, |section| &section.group);
        unknown("material", "materials", &part.material, material, |section| &section.material);
        if faults.len() == before && part.has_sections() && !chosen(skin, part).contains(&true) {
            let message = format!("parts.{i}: no triangle has both a group and a material of this part");
            faults.push(fault(group, message, "make a part of each".into()));
        }
        if !part.balls.is_empty() && !touches(skin, part) {
            let message = format!("parts.{i}.balls: no vertex of the skin is in them or within their edge");
            let mut help = "make them larger, or the triangles smaller by mesh.subdivide".to_owned();
            if let Some([low, high]) = bounds(skin) {
                help = format!("the skin reaches from {low} to {high} cm; {help}");
            }
            faults.push(fault(balls, message, help));
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(Error::Scene(faults)) }
}

/// How far a point is inside the balls of a part, cm, negative outside; infinite if it has none.
pub fn depth_in_balls(part: &Part, p: Vec3) -> f32 {
    let depth = |ball: &Ball| ball.radius - p.distance(Vec3::from(ball.center));
    part.balls.iter().map(depth).reduce(f32::max).unwrap_or(f32::INFINITY)
}

/// Whether the balls of a part or their edge hold a vertex of the skin; with a hard border the
/// middle of a triangle.
fn touches(skin: &Skin, part: &Part) -> bool {
    let edge = part.edge_cm();
    if edge > 0.0 {
        return skin.positions.iter().any(|p| depth_in_balls(part, *p) > -edge);
    }
    let middle = |t: usize| skin.corners(t).iter().sum::<Vec3>() / 3.0;
    (0..skin.triangles.len()).any(|t| depth_in_balls(part, middle(t)) >= 0.0)
}

/// The box around the skin.
fn bounds(skin: &Skin) -> Option<[Vec3; 2]> {
    let (low, high) = skin.bounds();
    // Without negative zeros.
    (!skin.positions.is_empty()).then_some([low + Vec3::ZERO, high + Vec3::ZERO])
}

fn fault(place: &Place, message: String, help: String) -> SceneFault {
    let Place { file, line, column } = place.clone();
    SceneFault { file, line, column, message, help: Some(help) }
}

/// Names of the sections, sorted, each once, without the empty one.
fn names_of(skin: &Skin, of: fn(&Section) -> &str) -> Vec<&str> {
    let mut names: Vec<&str> = skin.sections.iter().map(of).filter(|name| !name.is_empty()).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// What a user should know of the parts: settings of a part that are those of the scene's own coat
/// all the same.
pub fn notes(scene: &Scene) -> Vec<String> {
    let mut notes = Vec::new();
    for (i, part) in scene.parts.iter().enumerate() {
        let common = common_keys(scene, part);
        if !common.is_empty() {
            let name = if part.name.is_empty() { i.to_string() } else { format!("\"{}\"", part.name) };
            notes.push(format!(
                "part {name}: these keys are those of the scene's own coat on all of the skin: {}",
                common.join(", ")
            ));
        }
    }
    if !scene.parts.is_empty() && scene.render.fur == FurLayers::Shells {
        notes.push(
            "shells and fins have the mean coat of the whole skin; of the parts they know bare skin, comb and gravity".into(),
        );
    }
    notes
}

/// Keys in which the coat of a part differs from the scene's own, but which only the latter
/// decides.
fn common_keys(scene: &Scene, part: &Part) -> Vec<String> {
    let Some(coat) = scene.coat_of(part) else { return Vec::new() };
    let mut keys = Vec::new();
    if coat.guard.fibre != scene.guard.fibre {
        keys.push("guard.fibre".to_owned());
    }
    let (of_part, own) = (coat.undercoat, &scene.undercoat);
    let values = [of_part, own].map(toml::Table::try_from);
    if let [Ok(of_part), Ok(own)] = &values {
        // Where a key is absent in one of them, it has no value there.
        let all: std::collections::BTreeSet<_> = of_part.keys().chain(own.keys()).collect();
        let differs = |key: &&String| of_part.get(*key) != own.get(*key);
        let of_parts = ["density", "diameter", "height", "color_root", "color_tip"];
        let shared = all.into_iter().filter(|key| !of_parts.contains(&key.as_str()));
        keys.extend(shared.filter(differs).map(|key| format!("undercoat.{key}")));
    }
    if of_part.diameter[1] * own.diameter[0] != own.diameter[1] * of_part.diameter[0] {
        keys.push("undercoat.diameter (its ratio of tip to root)".to_owned());
    }
    keys
}
