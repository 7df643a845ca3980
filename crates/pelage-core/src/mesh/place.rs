//! From a file's units and axes to world space: cm, +y up.

use super::{MeshKind, Source};
use crate::Skin;
use crate::scene::{MeshSpec, UpAxis};
use glam::{DAffine3, DVec3, EulerRot, Quat, Vec3};

/// Length of a mesh whose file does not say how large it is, cm.
const DEFAULT_CM: f64 = 30.0;

/// Plausible lengths of an animal or a piece of fur, cm. Outside them, a unit is probably wrong.
const PLAUSIBLE_CM: std::ops::RangeInclusive<f64> = 1.0..=500.0;

/// A glTF file is taken at its word (metres) if that makes it this long, cm.
const METRES_CM: std::ops::RangeInclusive<f64> = 2.0..=500.0;

/// Largest coordinate, cm: beyond it, squares of areas overflow f32.
const MAX_COORDINATE: f32 = 1e8;

/// Takes the coordinates of another mesh's file to world space as that mesh was, then translates.
/// Normals turn alike: scales are uniform.
pub(super) fn place_like(skin: &mut Skin, spec: &MeshSpec, world_from_file: &DAffine3) {
    let translate = DAffine3::from_translation(Vec3::from_array(spec.translate).as_dvec3());
    skin.world_from_file = translate * *world_from_file;
    for p in &mut skin.positions {
        *p = skin.world_from_file.transform_point3(p.as_dvec3()).as_vec3();
    }
    for n in &mut skin.normals {
        *n = world_from_file.transform_vector3(n.as_dvec3()).as_vec3().normalize_or(Vec3::Y);
    }
}

/// Up, centre, size, units, scale, rotation (x, then y, then z), translation: in this order.
pub(super) fn place(skin: &mut Skin, spec: &MeshSpec, source: &Source) -> Result<(), String> {
    for (name, value) in [("mesh.size", spec.size), ("mesh.scale", spec.scale)] {
        if let Some(v) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
            return Err(format!("found {name} = {v}, expected a number above 0"));
        }
    }
    for (name, value) in [("mesh.rotate", spec.rotate), ("mesh.translate", spec.translate)] {
        if !value.iter().all(|v| v.is_finite()) {
            return Err(format!("found {name} = {value:?}, expected finite numbers"));
        }
    }
    let (up, up_note) = up_of(skin, spec, source);
    let turn = turn_of(up);
    for v in skin.positions.iter_mut().chain(&mut skin.normals) {
        *v = turn(*v);
    }
    let (low, high) = skin.bounds();
    let (low, high) = (low.as_dvec3(), high.as_dvec3());
    let center = if spec.center { (low + high) / 2.0 } else { DVec3::ZERO };
    let side = (high - low).max_element();
    let (scale, size_note) = scale_of(spec, source, side);
    let notes: Vec<String> = size_note.into_iter().chain(up_note).collect();
    if !notes.is_empty() {
        skin.notes.insert(0, notes.join("; "));
    }
    let [x, y, z] = spec.rotate.map(f32::to_radians);
    // Applied to a column vector: x first.
    let world_from_object = Quat::from_euler(EulerRot::ZYX, z, y, x);
    for p in &mut skin.positions {
        let scaled = ((p.as_dvec3() - center) * scale).as_vec3();
        *p = world_from_object * scaled + Vec3::from_array(spec.translate);
    }
    for n in &mut skin.normals {
        *n = (world_from_object * *n).normalize_or(Vec3::Y);
    }
    let axes = DVec3::AXES.map(|axis| turn(axis.as_vec3()).as_dvec3());
    skin.world_from_file = DAffine3::from_translation(Vec3::from_array(spec.translate).as_dvec3())
        * DAffine3::from_quat(world_from_object.as_dquat())
        * DAffine3::from_scale(DVec3::splat(scale))
        * DAffine3::from_translation(-center)
        * DAffine3::from_mat3(glam::DMat3::from_cols(axes[0], axes[1], axes[2]));
    let largest = skin.positions.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
    if !skin.positions.iter().all(|p| p.is_finite()) || largest > MAX_COORDINATE {
        return Err(format!(
            "found coordinates up to {largest:e} cm, expected at most {MAX_COORDINATE:e}: set mesh.size"
        ));
    }
    if (0..skin.triangles.len()).all(|t| skin.triangle_area(t) == 0.0) {
        return Err(format!(
            "found a mesh whose largest side is {:e} cm, expected triangles with an area: set mesh.size",
            side * scale
        ));
    }
    Ok(())
}

/// The factor from the file's units to cm for a mesh whose longest side is `side`, and what has to
/// be said about it.
fn scale_of(spec: &MeshSpec, source: &Source, side: f64) -> (f64, Option<String>) {
    let extra = spec.scale.map_or(1.0, f64::from);
    let given = spec.size.is_some() || spec.scale.is_some() || spec.units.is_some();
    let is_gltf = matches!(source.kind, Some(MeshKind::Gltf | MeshKind::Glb));
    // Shapes are in cm.
    let is_file = source.kind.is_some();
    let unit = spec.units.filter(|_| is_file).or(if given { None } else { source.unit });
    let in_cm = unit.map_or(1.0, |unit| unit.cm());
    if is_file && !given {
        let length = side * in_cm;
        return match source.unit {
            Some(unit) if !is_gltf || METRES_CM.contains(&length) => {
                let note = (!PLAUSIBLE_CM.contains(&length)).then(|| implausible(length));
                (unit.cm(), note)
            }
            stated => {
                let seen = match stated {
                    Some(_) => format!("{} m (glTF's unit) = {} cm", short(side), short(length)),
                    None => format!("{} in a file without a unit", short(side)),
                };
                let note = format!(
                    "the mesh's longest side is {seen}: made {DEFAULT_CM} cm long; \
                     set mesh.size (cm) or mesh.units to choose"
                );
                (DEFAULT_CM / side, Some(note))
            }
        };
    }
    let scale = spec.size.map_or(in_cm, |size| f64::from(size) / side) * extra;
    let length = side * scale;
    (scale, (is_file && !PLAUSIBLE_CM.contains(&length)).then(|| implausible(length)))
}

fn implausible(length: f64) -> String {
    format!(
        "warning: the mesh's longest side is {} cm, expected 1 to 500 cm for something with fur: \
         check mesh.size, mesh.units and mesh.scale",
        short(length)
    )
}

/// Four digits.
fn short(v: f64) -> String {
    if v == 0.0 || (1e-3..1e6).contains(&v) {
        let digits = (3 - v.max(1e-3).log10().floor() as i32).max(0) as usize;
        let text = format!("{v:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{v:.3e}")
    }
}

/// The axis that is up in the file, and a note where its format does not say: that on which the
/// mesh stands, else that of most such files.
fn up_of(skin: &Skin, spec: &MeshSpec, source: &Source) -> (UpAxis, Option<String>) {
    let (kind, usual) = match (spec.up, source.kind) {
        (_, None) => return (UpAxis::Y, None),
        (Some(up), _) => return (up, None),
        (None, Some(kind @ MeshKind::Stl)) => (kind, UpAxis::Z),
        (None, Some(kind @ MeshKind::Ply)) => (kind, UpAxis::Y),
        (None, _) => return (UpAxis::Y, None),
    };
    let stands = super::up::standing(skin);
    let up = stands.unwrap_or(usual);
    let name = if up == UpAxis::Z { "+z" } else { "+y" };
    let why = if stands.is_some() { "on which the mesh stands" } else { "as most have it" };
    let note = format!("{} files do not say which axis is up: {name} taken, {why}; set mesh.up", kind.name());
    (up, Some(note))
}

/// The rotation, by right angles, that turns an axis to +y.
fn turn_of(up: UpAxis) -> fn(Vec3) -> Vec3 {
    match up {
        UpAxis::Y => |v| v,
        UpAxis::NegativeY => |v| Vec3::new(v.x, -v.y, -v.z),
        UpAxis::Z => |v| Vec3::new(v.x, v.z, -v.y),
        UpAxis::NegativeZ => |v| Vec3::new(v.x, -v.z, v.y),
        UpAxis::X => |v| Vec3::new(-v.y, v.x, v.z),
        UpAxis::NegativeX => |v| Vec3::new(v.y, -v.x, v.z),
    }
}
