//! A bounding volume hierarchy with four boxes in a node.
//!
//! Things are sorted along a space-filling curve and cut into chunks. obvhs builds a binary tree
//! over each chunk, which is collapsed into nodes of four children. So building uses all cores, and
//! the builder's own memory is that of a few chunks. The result depends on the things alone.
// [MeisterBittner2018Ploc] and [MeisterBittner2018Reinsertion] by obvhs, [Wald2008] collapse,
// [Williams2005] ray and box

use glam::{Vec3A, Vec4};
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, reinsertion::ReinsertionOptimizer},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
};
use rayon::prelude::*;

/// A box around a thing or a part of one, cm.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// Lowest corner.
    pub low: Vec3A,
    /// Highest corner.
    pub high: Vec3A,
}

/// What the hierarchy's leaves hold: a part of a thing.
#[derive(Debug, Clone, Copy)]
pub struct Part {
    /// The thing's number, below 2³¹.
    pub thing: u32,
    /// Which part of it.
    pub part: u16,
    /// Number of its parts.
    pub parts: u16,
}

/// Largest number of parts in a chunk.
const CHUNK: usize = 1 << 16;

/// Bit of a child that is a thing.
const THING: u32 = 1 << 31;

/// Four boxes: low x, y, z, high x, y, z. Unused boxes are inside out.
#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: [Vec4; 6],
    children: [u32; 4],
}

/// Largest number of bytes per part while the hierarchy is built, measured with
/// tests/pathtrace_memory.rs.
pub const BYTES_A_PART: u64 = 128;

/// Bytes that the builder needs for the chunks in progress and the threads' stacks.
pub const BYTES_MORE: u64 = 32 << 20;

/// The hierarchy over all parts.
#[derive(Debug, Clone, Default)]
pub struct Bvh {
    nodes: Vec<Node>,
    root: u32,
}

/// A ray, prepared for its intersection with boxes.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Origin, cm.
    pub origin: Vec3A,
    /// Unit direction.
    pub direction: Vec3A,
    origins: [Vec4; 3],
    inverses: [Vec4; 3],
    /// For each axis, the index in [`Node::bounds`] of the side that the ray meets first.
    near: [usize; 3],
}

impl Ray {
    /// A ray from `origin` along the unit vector `direction`.
    #[inline]
    pub fn new(origin: Vec3A, direction: Vec3A) -> Self {
        let o = origin.to_array();
        let d = direction.to_array();
        let inverse = d.map(|d| if d.abs() < 1e-15 { 1e15f32.copysign(d) } else { 1.0 / d });
        Self {
            origin,
            direction,
            origins: o.map(Vec4::splat),
            inverses: inverse.map(Vec4::splat),
            near: [0, 1, 2].map(|k| if inverse[k] < 0.0 { k + 3 } else { k }),
        }
    }
}

/// Stack of the traversal, kept between rays: nodes and where the ray enters them.
pub type Stack = Vec<(u32, f32)>;

impl Node {
    const EMPTY: Self = Self {
        bounds: [
            Vec4::INFINITY,
            Vec4::INFINITY,
            Vec4::INFINITY,
            Vec4::NEG_INFINITY,
            Vec4::NEG_INFINITY,
            Vec4::NEG_INFINITY,
        ],
        children: [0; 4],
    };

    fn set(&mut self, slot: usize, bounds: &Aabb, child: u32) {
        for k in 0..3 {
            self.bounds[k][slot] = bounds.min[k];
            self.bounds[k + 3][slot] = bounds.max[k];
        }
        self.children[slot] = child;
    }

    /// Which boxes a ray meets before `limit`, as bits, and where it enters them.
    #[inline]
    fn meet(&self, ray: &Ray, limit: f32) -> (u32, [f32; 4]) {
        let [x, y, z] = ray.near;
        let plane = |side: usize, k: usize| (self.bounds[side] - ray.origins[k]) * ray.inverses[k];
        let far = |side: usize| if side > 2 { side - 3 } else { side + 3 };
        let enter = plane(x, 0).max(plane(y, 1)).max(plane(z, 2)).max(Vec4::ZERO);
        let exit = plane(far(x), 0).min(plane(far(y), 1)).min(plane(far(z), 2)).min(Vec4::splat(limit));
        (enter.cmple(exit).bitmask(), enter.to_array())
    }
}

impl Bvh {
    /// Builds the hierarchy over `parts`, whose boxes `bounds` gives.
    pub fn build(parts: Vec<Part>, bounds: impl Fn(Part) -> Bounds + Sync) -> Self {
        if parts.is_empty() {
            return Self::default();
        }
        // Coincident things make the builder recurse deeply, so its threads get large stacks.
        let threads = rayon::current_num_threads();
        match rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(64 << 20).build() {
            Ok(pool) => pool.install(|| Self::build_here(parts, &bounds)),
            Err(_) => Self::build_here(parts, &bounds),
        }
    }

    fn build_here(parts: Vec<Part>, bounds: &(impl Fn(Part) -> Bounds + Sync)) -> Self {
        let centre = |p: &Part| {
            let b = bounds(*p);
            0.5 * (b.low + b.high)
        };
        let (low, high) = parts
            .par_iter()
            .map(|p| (centre(p), centre(p)))
            .reduce(|| (Vec3A::INFINITY, Vec3A::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let scale = 1023.99 / (high - low).max_element().max(1e-9);
        let mut keyed: Vec<(u32, Part)> =
            parts.into_par_iter().map(|p| (morton((centre(&p) - low) * scale), p)).collect();
        keyed.par_sort_unstable_by_key(|(key, p)| (*key, p.thing, p.part));
        let mut chunks = Vec::new();
        cut(&keyed, 29, &mut chunks);
        let trees: Vec<(Vec<Node>, Aabb)> = chunks
            .par_iter()
            .map(|chunk| {
                let boxes: Vec<Aabb> = chunk
                    .iter()
                    .map(|(_, p)| {
                        let b = bounds(*p);
                        Aabb::new(b.low, b.high)
                    })
                    .collect();
                let tree = binary(&boxes);
                let mut nodes = Vec::with_capacity(chunk.len() / 2);
                let whole = collapse(&tree, &mut nodes, |leaf| THING | chunk[leaf as usize].1.thing);
                nodes.shrink_to_fit();
                (nodes, whole)
            })
            .collect();
        drop(chunks);
        drop(keyed);
        let mut nodes = Vec::with_capacity(trees.iter().map(|(n, _)| n.len()).sum::<usize>() + trees.len());
        let mut roots = Vec::with_capacity(trees.len());
        let mut boxes = Vec::with_capacity(trees.len());
        for (tree, whole) in trees {
            let base = nodes.len() as u32;
            roots.push(base);
            boxes.push(whole);
            nodes.extend(tree.into_iter().map(|mut node: Node| {
                for child in node.children.iter_mut().filter(|c| **c & THING == 0) {
                    *child += base;
                }
                node
            }));
        }
        let root = if roots.len() == 1 {
            0
        } else {
            let base = nodes.len();
            let mut top = Vec::new();
            let tree = binary(&boxes);
            // A mark tells chunks from children within the top part.
            collapse(&tree, &mut top, |leaf| THING | roots[leaf as usize]);
            nodes.extend(top.into_iter().map(|mut node| {
                for child in &mut node.children {
                    *child = if *child & THING != 0 { *child & !THING } else { *child + base as u32 };
                }
                node
            }));
            base as u32
        };
        Self { nodes, root }
    }

    /// Memory that it holds, bytes.
    pub fn bytes(&self) -> u64 {
        (self.nodes.len() * std::mem::size_of::<Node>()) as u64
    }

    /// Calls `visit` for all things whose boxes a ray meets before `limit`, nearer boxes first;
    /// `visit` returns the new limit. A negative limit ends the traversal. Returns the last limit.
    #[inline]
    pub fn walk(
        &self,
        ray: &Ray,
        limit: f32,
        stack: &mut Stack,
        mut visit: impl FnMut(u32, f32) -> f32,
    ) -> f32 {
        let mut limit = limit;
        if self.nodes.is_empty() {
            return limit;
        }
        stack.clear();
        let mut next = self.root;
        loop {
            let node = &self.nodes[next as usize];
            let (mut hits, enters) = node.meet(ray, limit);
            let mut inner = [(0u32, 0f32); 4];
            let mut count = 0;
            while hits != 0 {
                let slot = hits.trailing_zeros() as usize & 3;
                hits &= hits - 1;
                let child = node.children[slot];
                if child & THING != 0 {
                    limit = visit(child & !THING, limit);
                    if limit < 0.0 {
                        return limit;
                    }
                    continue;
                }
                // Insertion by distance, the farthest first.
                let mut at = count;
                while at > 0 && inner[at - 1].1 < enters[slot] {
                    inner[at] = inner[at - 1];
                    at -= 1;
                }
                inner[at] = (child, enters[slot]);
                count += 1;
            }
            for entry in inner.iter().take(count) {
                stack.push(*entry);
            }
            loop {
                let Some((child, enter)) = stack.pop() else { return limit };
                if enter <= limit {
                    next = child;
                    break;
                }
            }
        }
    }
}

/// Morton code: ten bits of each coordinate (0..1024), interleaved.
fn morton(p: Vec3A) -> u32 {
    let spread = |x: f32| {
        let mut x = x.clamp(0.0, 1023.0) as u32;
        x = (x | (x << 16)) & 0x0300_00ff;
        x = (x | (x << 8)) & 0x0300_f00f;
        x = (x | (x << 4)) & 0x030c_30c3;
        (x | (x << 2)) & 0x0924_9249
    };
    spread(p.x) | (spread(p.y) << 1) | (spread(p.z) << 2)
}

/// Cuts sorted keys where their highest bit changes, until each chunk is small.
fn cut<'a>(keyed: &'a [(u32, Part)], bit: i32, chunks: &mut Vec<&'a [(u32, Part)]>) {
    if keyed.is_empty() {
        return;
    }
    if keyed.len() <= CHUNK {
        chunks.push(keyed);
    } else if bit < 0 {
        chunks.extend(keyed.chunks(CHUNK));
    } else {
        let (low, high) = keyed.split_at(keyed.partition_point(|(key, _)| (key >> bit) & 1 == 0));
        cut(low, bit - 1, chunks);
        cut(high, bit - 1, chunks);
    }
}

fn binary(boxes: &[Aabb]) -> Bvh2 {
    let indices = (0..boxes.len() as u32).collect();
    let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        boxes,
        indices,
        SortPrecision::U64,
        0,
    );
    ReinsertionOptimizer::default().run(&mut tree, 0.02, None);
    tree
}

/// Collapses a binary tree into nodes of four, which are appended to `nodes`, the root first: of a
/// node's children, that with the largest box is opened until there are four. `leaf` gives the
/// child for a thing. Returns the box around everything.
fn collapse(tree: &Bvh2, nodes: &mut Vec<Node>, leaf: impl Fn(u32) -> u32) -> Aabb {
    let thing = |i: u32| leaf(tree.primitive_indices[tree.nodes[i as usize].first_index as usize]);
    let first = nodes.len() as u32;
    nodes.push(Node::EMPTY);
    let Some(root) = tree.nodes.first() else { return Aabb::empty() };
    if root.is_leaf() {
        nodes[first as usize].set(0, root.aabb(), thing(0));
        return *root.aabb();
    }
    let mut open = vec![(0u32, first)];
    while let Some((from, to)) = open.pop() {
        let pair = tree.nodes[from as usize].first_index;
        let mut members = [pair, pair + 1, 0, 0];
        let mut count = 2;
        while count < 4 {
            let largest =
                (0..count).filter(|k| !tree.nodes[members[*k] as usize].is_leaf()).max_by(|a, b| {
                    let area = |k: &usize| tree.nodes[members[*k] as usize].aabb().half_area();
                    area(a).total_cmp(&area(b))
                });
            let Some(k) = largest else { break };
            let pair = tree.nodes[members[k] as usize].first_index;
            members[k] = pair;
            members[count] = pair + 1;
            count += 1;
        }
        for (slot, member) in members[..count].iter().enumerate() {
            let node = &tree.nodes[*member as usize];
            let child = if node.is_leaf() {
                thing(*member)
            } else {
                nodes.push(Node::EMPTY);
                let child = nodes.len() as u32 - 1;
                open.push((*member, child));
                child
            };
            nodes[to as usize].set(slot, node.aabb(), child);
        }
    }
    *root.aabb()
}
