//! Twin of `shaders/resolve.wgsl`: resolves the fragments of a sample.

use crate::twin::undercoat_march::{MarchInputs, Step, steps};
use glam::{Vec3, Vec4};
use pelage_fur::layout::UndercoatParameters;

/// Kind of a fragment, the top two bits of its source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A fragment of a guard hair.
    Strand,
    /// An entry into the shell.
    Entry,
    /// A fragment of the undercoat.
    Volume,
}

/// A fragment of a sample's list.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Node {
    /// Depth, cm.
    pub z: f32,
    /// Kind and id; breaks ties of depth.
    pub source: u32,
    /// Premultiplied radiance and opacity; of an entry unused.
    pub color: Vec4,
    /// With features: albedo of the hairs.
    pub albedo: Vec3,
    /// With features: direction of the hairs, from root to tip.
    pub tangent: Vec3,
}

/// Normal of a hair as seen along the unit vector `view` (towards the camera): that of the ribbon
/// that faces the camera; `view` itself where the hair is seen end-on.
pub fn hair_normal(tangent: Vec3, view: Vec3) -> Vec3 {
    let n = view - tangent * view.dot(tangent);
    if n.length_squared() > 1e-8 { n.normalize() } else { view }
}

impl Node {
    /// Its kind.
    pub fn kind(&self) -> Kind {
        match self.source >> 30 {
            0 => Kind::Strand,
            1 => Kind::Entry,
            _ => Kind::Volume,
        }
    }

    /// Its id: of an entry, the prism.
    pub fn id(&self) -> u32 {
        self.source & 0x3fff_ffff
    }
}

/// The skin at a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Base {
    /// Depth, cm.
    pub z: f32,
    /// Radiance.
    pub radiance: Vec3,
    /// Share of the background that shows through.
    pub transparency: f32,
}

/// Sums of a sample, front to back. Radiances are premultiplied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gathered {
    /// Radiance of the guard hairs.
    pub guard: Vec3,
    /// Radiance of the undercoat.
    pub undercoat: Vec3,
    /// Radiance of the skin.
    pub base: Vec3,
    /// Transmittance so far.
    pub through: f32,
    /// Sum of opacity times depth, cm.
    pub z_sum: f32,
}

impl Gathered {
    /// The sums before the first fragment.
    pub fn new() -> Self {
        Self { guard: Vec3::ZERO, undercoat: Vec3::ZERO, base: Vec3::ZERO, through: 1.0, z_sum: 0.0 }
    }

    /// Composites a fragment behind the others.
    // [PorterDuff1984]
    fn over(&mut self, kind: Kind, color: Vec4, z: f32) {
        let light = self.through * color.truncate();
        match kind {
            Kind::Strand => self.guard += light,
            Kind::Volume => self.undercoat += light,
            Kind::Entry => return,
        }
        self.z_sum += self.through * color.w * z;
        self.through *= 1.0 - color.w;
    }

    /// Composites the skin behind everything.
    fn finish(mut self, base: Option<Base>) -> Self {
        if let Some(base) = base {
            self.base = self.through * base.radiance;
            self.z_sum += self.through * (1.0 - base.transparency) * base.z;
            self.through *= base.transparency;
        }
        self
    }

    /// Opacity-weighted depth, cm; 1e30 where nothing is hit.
    pub fn depth(&self) -> f32 {
        let opacity = 1.0 - self.through;
        if opacity > 1e-4 { self.z_sum / opacity } else { 1e30 }
    }
}

impl Default for Gathered {
    fn default() -> Self {
        Self::new()
    }
}

/// Sorts fragments by depth, and those of equal depth by source, so that the order of arrival does
/// not matter.
pub fn sort(nodes: &mut [Node]) {
    nodes.sort_by(|a, b| a.z.total_cmp(&b.z).then(a.source.cmp(&b.source)));
}

/// Alpha of a shell fragment, reduced by the strands between it and the next shell fragment.
/// `behind`: the fragments behind it, sorted.
// [Andersen2016] eq. 4
// DEVIATION: each strand counts with its own alpha, and the result is clamped to be non-negative.
pub fn simplified_alpha(attenuation: f32, shell: &Node, behind: &[Node]) -> f32 {
    let taken: f32 = behind
        .iter()
        .take_while(|n| n.kind() != Kind::Volume)
        .filter(|n| n.kind() == Kind::Strand)
        .map(|n| n.color.w * (-attenuation * (n.z - shell.z)).exp()) // [Andersen2016] eq. 4
        .sum();
    (shell.color.w - taken).max(0.0)
}

/// Blends the fragments of a list that `undercoat_march` has filled, nearest first. Shell fragments
/// are reduced by [`simplified_alpha`]; virtual fragments are blended as they are.
pub fn blend_fragments(
    undercoat: &UndercoatParameters,
    mut nodes: Vec<Node>,
    base: Option<Base>,
) -> Gathered {
    sort(&mut nodes);
    let mut g = Gathered::new();
    for (i, node) in nodes.iter().enumerate() {
        let mut color = node.color;
        if node.kind() == Kind::Volume && undercoat.virtual_fragments == 0 {
            color *= simplified_alpha(undercoat.attenuation, node, &nodes[i + 1..]) / color.w.max(1e-6);
        }
        g.over(node.kind(), color, node.z);
    }
    g.finish(base)
}

/// Blends strands and the undercoat marched from the list's entries, both at their true depths:
/// steps of the march are split at every strand. An interval shared by two entries counts for the
/// first. `ray`, `phase`: see [`steps`].
pub fn exact(
    inputs: &MarchInputs<'_>,
    nodes: Vec<Node>,
    ray: Vec3,
    phase: f32,
    base: Option<Base>,
) -> Gathered {
    exact_of(inputs, nodes, ray, phase, base, &|step| step.radiance)
}

/// [`exact`] for another quantity than radiance: that of a step is `of_step`, those of the strands
/// and of the skin stand in their colours.
// [Max1995]
pub fn exact_of(
    inputs: &MarchInputs<'_>,
    mut nodes: Vec<Node>,
    ray: Vec3,
    phase: f32,
    base: Option<Base>,
    of_step: &dyn Fn(&Step) -> Vec3,
) -> Gathered {
    sort(&mut nodes);
    let z_base = base.map_or(f32::INFINITY, |b| b.z);
    let mut pieces: Vec<Step> = Vec::new();
    let mut consumed = 0f32;
    for entry in nodes.iter().filter(|n| n.kind() == Kind::Entry) {
        let (marched, _) = steps(inputs, ray, entry.id(), entry.z, phase);
        let end = marched.last().map_or(entry.z, |s| s.z_end);
        pieces.extend(marched.iter().map(|s| Step {
            z: s.z.max(consumed),
            z_end: s.z_end.min(z_base),
            ..*s
        }));
        consumed = consumed.max(end);
    }
    pieces.retain(|s| s.z_end > s.z);
    let strands: Vec<&Node> = nodes.iter().filter(|n| n.kind() == Kind::Strand).collect();
    // All depths at which the medium changes or a strand lies.
    let mut cuts: Vec<f32> =
        pieces.iter().flat_map(|s| [s.z, s.z_end]).chain(strands.iter().map(|n| n.z)).collect();
    cuts.sort_by(f32::total_cmp);
    cuts.dedup();
    let mut g = Gathered::new();
    let mut next = 0;
    let mut piece = 0;
    for (i, z) in cuts.iter().enumerate() {
        while next < strands.len() && strands[next].z <= *z {
            g.over(Kind::Strand, strands[next].color, strands[next].z);
            next += 1;
        }
        let Some(end) = cuts.get(i + 1) else { break };
        while piece < pieces.len() && pieces[piece].z_end <= *z {
            piece += 1;
        }
        if let Some(s) = pieces.get(piece).filter(|s| s.z <= *z) {
            let part = 1.0 - (-s.sigma * (end - z)).exp();
            g.over(Kind::Volume, (of_step(s) * part).extend(part), 0.5 * (z + end));
        }
    }
    g.finish(base)
}
