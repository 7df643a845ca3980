//! Twin of `shaders/shell_entry.wgsl`: where the view rays of samples enter the prism shell.
// [Andersen2016] sec. 3.2

use crate::twin::base_raster::{plane_depth, project};
use glam::Vec3;
use pelage_fur::layout::Frame;
use pelage_fur::shell::Shell;
use pelage_fur::view::sample_ray;

/// Entry of a view ray into the shell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Depth, cm.
    pub z: f32,
    /// Prism that it enters.
    pub prism: u32,
    /// Distance of the sample's centre from the nearest edge of the face, in samples.
    pub margin: f32,
}

/// The faces through which rays may enter, with their prisms: the tops, and two triangles over each
/// border edge. `border`: triangle, and corner opposite the edge.
pub fn faces(shell: &Shell, border: &[[u32; 2]]) -> Vec<(u32, [Vec3; 3])> {
    let skin = |v: u32| Vec3::from(shell.vertices[v as usize].position);
    let raised = |v: u32| {
        let s = &shell.vertices[v as usize];
        skin(v) + s.height * Vec3::from(s.normal)
    };
    let tops = shell.prisms.iter().enumerate().map(|(i, p)| (i as u32, p.vertices.map(raised)));
    let walls = border.iter().flat_map(|[prism, corner]| {
        let v = shell.prisms[*prism as usize].vertices;
        let (a, b) = (v[(*corner as usize + 1) % 3], v[(*corner as usize + 2) % 3]);
        [(*prism, [skin(a), skin(b), raised(b)]), (*prism, [skin(a), raised(b), raised(a)])]
    });
    tops.chain(walls).collect()
}

/// Entries of each sample of the tile in front of the skin, nearest first. Back faces are not
/// entries. `base_z`: depth of the skin at each sample, cm.
pub fn entries(frame: &Frame, shell: &Shell, border: &[[u32; 2]], base_z: &[f32]) -> Vec<Vec<Entry>> {
    let width = frame.tile_size[0];
    let mut entries = vec![Vec::new(); base_z.len()];
    for (prism, corners) in faces(shell, border) {
        let Some(projected) = project(frame, corners) else { continue };
        let [columns, rows] = projected.bounds(frame);
        for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
            let cover = projected.cover(frame, [x, y]);
            let z = plane_depth(frame, corners, sample_ray(frame, [x, y]));
            let i = (y * width + x) as usize;
            if cover.front && cover.margin >= 0.0 && z > frame.near && z < base_z[i] {
                entries[i].push(Entry { z, prism, margin: cover.margin });
            }
        }
    }
    for list in &mut entries {
        list.sort_by(|a, b| a.z.total_cmp(&b.z).then(a.prism.cmp(&b.prism)));
    }
    entries
}
