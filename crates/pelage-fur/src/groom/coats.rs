//! The coats, as the passes read them.

use super::map_packer::{MapPacker, below, constant};
use super::relative_diameter;
use crate::layout::{Coat, GuardHairs, PARAMETERS, Parameter};
use crate::parameters::{NO_LANE, Parameter as Which};
use glam::Vec3;
use pelage_core::scene::{self, Guard, Part, Scalar, Scene};

/// The scene's own coat. `height` replaces that of the undercoat, cm.
pub(super) fn own(scene: &Scene, maps: &mut MapPacker<'_>, height: Option<f32>) -> Coat {
    let mut coat = packed(scene, &scene.own_coat(), maps, height);
    coat.parameters[Which::ShellColor as usize] = maps.color(&scene.shells.color);
    coat.parameters[Which::ShellLength as usize] = maps.scalar(&scene.shells.length);
    coat
}

/// The coat of a part. `lane` is that of its coverage.
pub(super) fn of_part(
    scene: &Scene,
    part: &Part,
    maps: &mut MapPacker<'_>,
    height: Option<f32>,
    lane: u32,
) -> Coat {
    let mut coat = match scene.coat_of(part) {
        Some(coat) => packed(scene, &coat, maps, height),
        None => bare(scene, part, maps, height),
    };
    if let Some(mask) = &part.mask {
        coat.parameters[Which::PartMask as usize] = maps.scalar(&Scalar::Mapped(mask.clone()));
    }
    Coat { lane, ..coat }
}

/// A coat without the parameters of shells, on all of the skin.
fn packed(scene: &Scene, coat: &scene::Coat<'_>, maps: &mut MapPacker<'_>, height: Option<f32>) -> Coat {
    let (guard, undercoat) = (coat.guard, coat.undercoat);
    let ratio = relative_diameter(scene, coat);
    let scalars = [
        &guard.density,
        &guard.length,
        &guard.thickness,
        &guard.comb,
        &guard.clump,
        &guard.curl,
        &guard.frizz,
    ];
    let mut parameters = [below(); PARAMETERS];
    for (to, scalar) in parameters.iter_mut().zip(scalars) {
        *to = maps.scalar(scalar);
    }
    let mut set = |which: Which, parameter| parameters[which as usize] = parameter;
    set(Which::GuardColorRoot, maps.color(&guard.color_root));
    set(Which::GuardColorTip, maps.color(&guard.color_tip));
    let density = maps.scalar(&undercoat.density);
    let value = density.value.map(|value| value * ratio);
    set(Which::UndercoatDensity, Parameter { value, offset: density.offset * ratio, ..density });
    set(Which::UndercoatHeight, height.map_or_else(|| maps.scalar(&undercoat.height), constant));
    set(Which::UndercoatColorRoot, maps.color(&undercoat.color_root));
    set(Which::UndercoatColorTip, maps.color(&undercoat.color_tip));
    set(Which::BaseColor, maps.color(&coat.base.color));
    set(Which::PartMask, constant(1.0));
    Coat { parameters, hairs: guard_hairs(guard), lane: NO_LANE, bare: 0, padding: [0; 2] }
}

/// Bare skin: no hairs, else everything as below. Where there is no undercoat at all, `height`
/// keeps the shell, which carries the light.
fn bare(scene: &Scene, part: &Part, maps: &mut MapPacker<'_>, height: Option<f32>) -> Coat {
    let mut parameters = [below(); PARAMETERS];
    let mut set = |which: Which, parameter| parameters[which as usize] = parameter;
    for which in [Which::GuardDensity, Which::GuardLength, Which::UndercoatDensity, Which::ShellLength] {
        set(which, constant(0.0));
    }
    if height.is_none() {
        set(Which::UndercoatHeight, constant(0.0));
    }
    if let Some(base) = &part.base {
        set(Which::BaseColor, maps.color(&base.color));
    }
    set(Which::PartMask, constant(1.0));
    Coat { parameters, hairs: guard_hairs(&scene.guard), lane: NO_LANE, bare: 1, padding: [0; 2] }
}

fn guard_hairs(guard: &Guard) -> GuardHairs {
    GuardHairs {
        comb_direction: Vec3::from(guard.comb_direction).normalize_or_zero().into(),
        widest: guard.widest,
        diameter: guard.diameter.map(|um| um * 1e-4),
        spread: guard.spread.to_radians().tan(),
        color_transition: guard.color_transition,
        color_variation: guard.color_variation,
        length_variation: guard.length_variation,
        gravity: guard.gravity,
        clump_density: guard.clump_density,
        curl_frequency: guard.curl_frequency,
        frizz_frequency: guard.frizz_frequency,
        root_darkening: guard.root_darkening,
        opacity: guard.opacity,
        tip_fade: guard.tip_fade,
    }
}
