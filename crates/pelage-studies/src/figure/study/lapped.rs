//! A skin, the direction field of its hair, and the lapped patches that cover it.

use super::super::{FigureContent, FigureContext};
use crate::report::{Table, number};
use pelage_core::Result;
use pelage_shells::lapped::{self, Statistics};
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Scene file, relative to the figure's folder.
    scene: String,
    /// Number of patches in the paper.
    paper_patches: u32,
    /// Number of faces of the paper's mesh.
    paper_faces: u32,
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let [width, height] = context.size();
    let side = width.max(height);
    let mut content = FigureContent::default();
    let mut rows = Vec::new();
    let mut fur = None;
    for (label, set) in [("whole faces", "false"), ("overlapping", "true")] {
        let set = [format!("lapped.overlapping={set}")];
        let (world, assets) = context.load(&settings.scene, &set)?;
        let skin = &world.skin;
        let found = lapped::lap(skin, &world.scene)?;
        if content.images.is_empty() {
            // Flat shading shows the mesh below the strokes.
            let picture = lapped::field_picture(&found, &skin.clone().faceted(), side);
            content.picture("mesh and directions", picture);
        }
        let picture = lapped::patch_picture(&found, skin, side);
        content.picture(&format!("patches, {label}"), picture);
        context.report(&format!("patches, {label}: {:.2} s", found.time_ms / 1e3))?;
        if content.images.len() == 2 {
            fur = Some(context.render_panel("fur on the patches", &world, &assets)?);
        }
        let statistics = found.statistics(skin)?;
        // Patches grow by comparing floats, so that another machine may find a few more or fewer.
        content.value(&format!("{label}: patches"), statistics.patches as f64, 5.0);
        content.value(&format!("{label}: coverage"), statistics.coverage, 1e-6);
        content.value(&format!("{label}: mean stretch"), statistics.mean_stretch, 0.01);
        rows.push(row(&format!("{label}, ours"), &statistics));
    }
    content.images.extend(fur);
    let mut paper = vec![
        "whole faces, paper's bunny".to_owned(),
        settings.paper_faces.to_string(),
        settings.paper_patches.to_string(),
    ];
    paper.resize(HEAD.len(), "-".into());
    rows.insert(1, paper);
    let caption = "Patches. Stretch is a face's largest singular value or the inverse of its smallest, whichever is larger; layers is \
        the area of all patches over that of the skin.";
    content.table(&Table::new(caption, &HEAD, rows));
    Ok(content)
}

const HEAD: [&str; 7] =
    ["patches", "faces", "number", "layers", "mean stretch", "angle to the field", "seams, cm"];

fn row(name: &str, s: &Statistics) -> Vec<String> {
    let angle = s.mean_angle_error.map_or("-".into(), |a| format!("{a:.1}°"));
    vec![
        name.into(),
        s.faces.to_string(),
        s.patches.to_string(),
        number(s.layers),
        number(s.mean_stretch),
        angle,
        number(s.seam_length),
    ]
}
