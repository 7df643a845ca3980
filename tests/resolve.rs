//! `resolve` against its CPU twin: the lists of small worlds, and synthetic lists with hard cases.

use crate::common::gpu;
use crate::common::marched::Marched;
use crate::common::worlds::ball;
use glam::{Vec3, Vec4};
use half::f16;
use pelage_core::scene::{Blend, Scene};
use pelage_fur::random::random;
use pelage_fur::view::sample_ray;
use pelage_render::twin::film::Sample;
use pelage_render::twin::resolve::{Gathered, Kind, Node, blend_fragments, exact, simplified_alpha};
use pelage_render::twin::undercoat_march::first_phase;

/// Largest difference of a resolved sample.
fn difference(found: &Sample, wanted: &Gathered) -> f32 {
    let colors =
        [(found.guard, wanted.guard), (found.undercoat, wanted.undercoat), (found.base, wanted.base)];
    colors
        .iter()
        .map(|(a, b)| (*a - *b).abs().max_element())
        .fold((found.through - wanted.through).abs(), f32::max)
}

fn scene(blend: Blend) -> impl FnOnce(&mut Scene) {
    move |s| {
        s.render.blend = blend;
        s.render.virtual_fragments = 6;
        s.undercoat.density = 4000.0.into();
    }
}

/// Part of the samples that agree with the twin within `tolerance`, of those that see anything.
fn agreement(blend: Blend, tolerance: f32) -> f64 {
    let Some(gpu) = gpu::open() else { return 1.0 };
    let m = Marched::new(gpu, ball(scene(blend)), [96, 64], [0, 0], [96, 64]);
    if blend != Blend::Exact {
        m.march();
    }
    m.draw_strands();
    let (lists, bases) = (m.nodes(), m.bases());
    let found = m.resolve(blend == Blend::Exact);
    let inputs = m.inputs();
    let fur = &m.fixture.fur;
    let (mut seen, mut good, mut sum, mut mixed) = (0u32, 0u32, 0f64, 0u32);
    for (i, xy) in m.places() {
        let list = lists[i].clone();
        assert_eq!(found[i].fragments as usize, list.len());
        let wanted = if blend == Blend::Exact {
            let ray = sample_ray(&m.tile.frame, xy);
            exact(&inputs, list.clone(), ray, first_phase(&m.tile.frame, xy), bases[i])
        } else {
            blend_fragments(&fur.undercoat, list.clone(), bases[i])
        };
        if list.is_empty() && bases[i].is_none() {
            assert_eq!(found[i].through, 1.0);
            continue;
        }
        seen += 1;
        let has = |kind| list.iter().any(|n| n.kind() == kind);
        mixed += u32::from(has(Kind::Strand) && (has(Kind::Entry) || has(Kind::Volume)));
        let d = difference(&found[i], &wanted);
        sum += f64::from(d);
        // The march ends below a transmittance of 0.0005; depth is that of what is seen.
        good += u32::from(d < tolerance && (found[i].z - wanted.depth()).abs() < 0.01);
    }
    assert!(seen > 1000 && mixed > 500, "{seen} {mixed}");
    println!("{blend:?}: {good} of {seen} agree, mean difference {:.6}", sum / f64::from(seen));
    f64::from(good) / f64::from(seen)
}

#[test]
fn exact_agrees_with_its_twin() {
    // A step at the border of a subelement may read its neighbour.
    assert!(agreement(Blend::Exact, 2e-3) > 0.98);
}

#[test]
fn simplified_agrees_with_its_twin() {
    assert!(agreement(Blend::Simplified, 1e-3) > 0.999);
}

#[test]
fn virtual_agrees_with_its_twin() {
    assert!(agreement(Blend::Virtual, 1e-3) > 0.999);
}

/// Words of the list buffer: `lists` with their nodes linked in the order given, all nodes strewn
/// over the buffer by `seed`.
fn words(lists: &[Vec<Node>], seed: u32) -> Vec<u32> {
    let all: Vec<(usize, &Node)> =
        lists.iter().enumerate().flat_map(|(i, l)| l.iter().map(move |n| (i, n))).collect();
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by_key(|i| pelage_fur::random::hash2(seed, *i as u32));
    let mut words = vec![0; 1 + lists.len() + 5 * all.len()];
    words[0] = all.len() as u32;
    for (place, i) in order.iter().enumerate() {
        let (list, node) = all[*i];
        let at = 1 + lists.len() + 5 * place;
        let pack = |a: f32, b: f32| {
            u32::from(f16::from_f32(a).to_bits()) | (u32::from(f16::from_f32(b).to_bits()) << 16)
        };
        let c = node.color;
        let next = std::mem::replace(&mut words[1 + list], place as u32 + 1);
        words[at..at + 5].copy_from_slice(&[
            next,
            node.z.to_bits(),
            node.source,
            pack(c.x, c.y),
            pack(c.z, c.w),
        ]);
    }
    words
}

/// Lists of 0, 1, 2, ... fragments with colours that halves hold, some at equal depths.
fn synthetic(count: usize, seed: u32) -> Vec<Vec<Node>> {
    (0..count as u32)
        .map(|i| {
            (0..i)
                .map(|k| {
                    let r = |j: u32| random(seed ^ i, 8 * k + j);
                    // Volume fragments are rare: eq. 4 then has many strands behind each.
                    let kind = if r(0) < 0.08 { 2 } else { 0 };
                    // Depths on a grid: many are equal.
                    let z = 5.0 + (r(1) * 40.0).floor() / 32.0;
                    let alpha = f16::from_f32(0.02 + 0.2 * r(2)).to_f32();
                    let rgb = [3, 4, 5].map(|j| f16::from_f32(r(j) * alpha).to_f32());
                    Node {
                        z,
                        source: (kind << 30) | k,
                        color: Vec4::new(rgb[0], rgb[1], rgb[2], alpha),
                        ..Node::default()
                    }
                })
                .collect()
        })
        .collect()
}

/// Samples of synthetic lists.
fn resolved(m: &Marched, lists: &[Vec<Node>], seed: u32) -> Vec<Sample> {
    let gpu = m.fixture.prepared.gpu;
    gpu.queue.write_buffer(
        &m.tile.buffers().buffer("fragment_lists").unwrap().raw,
        0,
        bytemuck::cast_slice(&words(lists, seed)),
    );
    m.resolve(false)
}

/// A tile beside the ball, without a skin.
fn empty(blend: Blend) -> Option<Marched> {
    let m = Marched::new(gpu::open()?, ball(scene(blend)), [96, 64], [0, 0], [16, 8]);
    assert!(m.bases().iter().all(Option::is_none));
    Some(m)
}

#[test]
fn long_lists_agree_with_the_twin() {
    for blend in [Blend::Virtual, Blend::Simplified] {
        let Some(m) = empty(blend) else { return };
        let lists = synthetic(128, 3);
        let found = resolved(&m, &lists, 0);
        let mut worst = (0f32, 0);
        for (i, list) in lists.iter().enumerate() {
            let d = difference(&found[i], &blend_fragments(&m.fixture.fur.undercoat, list.clone(), None));
            if d > worst.0 {
                worst = (d, i);
            }
        }
        println!("{blend:?}: largest difference {worst:?}");
        assert!(worst.0 < 1e-3, "{blend:?}: {worst:?}");
        assert_eq!(m.counts()[1], 127);
    }
}

#[test]
fn order_of_arrival_does_not_matter() {
    for blend in [Blend::Virtual, Blend::Simplified] {
        let Some(m) = empty(blend) else { return };
        let lists = synthetic(128, 5);
        let first = resolved(&m, &lists, 0);
        for seed in 1..50 {
            assert!(resolved(&m, &lists, seed) == first, "{blend:?}: order {seed} makes another image");
        }
        // Another depth does matter.
        let mut moved = lists.clone();
        moved[100][7].z += 0.5;
        assert!(resolved(&m, &moved, 0) != first);
    }
}

/// Faint fragments in long lists, in an order that puts many before those that were read.
fn faint(lists: usize, length: u32) -> Vec<Vec<Node>> {
    let node = |i: usize, k: u32| {
        let z = 5.0 + ((k * 7919 + i as u32) % length) as f32 / 1024.0;
        Node { z, source: k, color: Vec4::splat(f16::from_f32(0.0005).to_f32()), ..Node::default() }
    };
    (0..lists).map(|i| (0..length).map(|k| node(i, k)).collect()).collect()
}

/// The adapter ends the loops that read lists of thousands of fragments: that is counted, and
/// sorted lists are read to their end.
#[test]
fn lists_that_are_too_long_for_the_loops_are_counted_and_can_be_sorted() {
    let Some(m) = empty(Blend::Virtual) else { return };
    let length = 3000;
    let lists: Vec<Vec<Node>> = faint(8, length).into_iter().chain(vec![Vec::new(); 120]).collect();
    let unsorted = resolved(&m, &lists, 0);
    let counts = m.tile.counters().expect("counters");
    let wanted: Vec<_> =
        lists.iter().map(|l| blend_fragments(&m.fixture.fur.undercoat, l.clone(), None)).collect();
    let complete = |found: &[Sample]| {
        (0..8).all(|i| difference(&found[i], &wanted[i]) < 2e-3 && found[i].fragments == length)
    };
    // An adapter without such a limit reads all.
    assert_eq!(complete(&unsorted), counts.unread == 0, "{counts:?}");
    assert_eq!(counts.rays_cut > 0, counts.unread > 0, "{counts:?}");
    if counts.unread == 0 {
        return;
    }
    assert!(counts.listed == 8 * u64::from(length), "{counts:?}");
    let sorted = m.tile.sort_and_resolve(false).expect("step 7");
    let again = m.tile.counters().expect("counters");
    assert_eq!((again.unread, again.rays_cut), (0, 0), "{again:?}");
    assert!(complete(&sorted));
    // Short lists are the same either way.
    let short = synthetic(128, 3);
    for blend in [Blend::Virtual, Blend::Simplified] {
        let Some(m) = empty(blend) else { return };
        let unsorted = resolved(&m, &short, 0);
        assert!(m.tile.sort_and_resolve(false).expect("step 7") == unsorted, "{blend:?}");
    }
}

/// Shell fragment of alpha `alpha`, strands behind it.
fn shell_and_strands(alpha: f32, strands: &[(f32, f32)]) -> Vec<Node> {
    let shell =
        Node { z: 1.0, source: 2 << 30, color: Vec4::new(0.5, 0.5, 0.5, 1.0) * alpha, ..Node::default() };
    let strand = |(i, (z, a)): (usize, &(f32, f32))| Node {
        z: *z,
        source: i as u32,
        color: Vec4::splat(*a),
        ..Node::default()
    };
    std::iter::once(shell).chain(strands.iter().enumerate().map(strand)).collect()
}

#[test]
fn limits_of_the_simplified_alpha() {
    let kept = |attenuation: f32, nodes: &[Node]| simplified_alpha(attenuation, &nodes[0], &nodes[1..]);
    assert_eq!(kept(4.0, &shell_and_strands(0.7, &[])), 0.7, "no hair behind");
    assert_eq!(kept(1e9, &shell_and_strands(0.7, &[(1.001, 1.0)])), 0.7, "attenuation without end");
    assert_eq!(kept(4.0, &shell_and_strands(0.7, &[(1.0, 1.0)])), 0.0, "a hair at no distance");
    let one = kept(4.0, &shell_and_strands(0.7, &[(1.25, 0.5)]));
    assert!((one - (0.7 - 0.5 * (-1f32).exp())).abs() < 1e-6, "{one}");
    // Behind the next shell fragment nothing counts.
    let mut nodes = shell_and_strands(0.7, &[(1.1, 0.2), (1.5, 1.0)]);
    let two = kept(1.0, &nodes[..2]);
    nodes[2].source = 2 << 30;
    nodes.push(Node { z: 1.6, source: 9, color: Vec4::ONE, ..Node::default() });
    assert_eq!(kept(1.0, &nodes), two);
}

#[test]
fn limits_of_the_simplified_alpha_on_the_gpu() {
    let Some(m) = empty(Blend::Simplified) else { return };
    let a = m.fixture.fur.undercoat.attenuation;
    let lists = vec![
        shell_and_strands(0.75, &[]),
        shell_and_strands(0.75, &[(40.0, 1.0)]),
        shell_and_strands(0.75, &[(1.0, 1.0)]),
        shell_and_strands(0.75, &[(1.25, 0.5)]),
    ];
    let mut all = lists.clone();
    all.resize(128, Vec::new());
    let found = resolved(&m, &all, 0);
    let alpha = |i: usize| found[i].undercoat.x / 0.5;
    for (i, wanted) in [0.75, 0.75, 0.0, 0.75 - 0.5 * (-0.25 * a).exp()].into_iter().enumerate() {
        assert!((alpha(i) - wanted).abs() < 1e-3, "list {i}: {} is not {wanted}", alpha(i));
    }
}

/// A strand in fog: virtual fragments tend to the exact blend, [Andersen2016] sec. 3.3.
#[test]
fn virtual_fragments_tend_to_the_strand_in_fog() {
    let (s, length, z, a, c) = (2f32, 1.5f32, 0.6f32, 0.7f32, 0.9f32);
    let before = 1.0 - (-s * z).exp();
    let exact = before + (1.0 - before) * (a * c + (1.0 - a) * (1.0 - (-s * (length - z)).exp()));
    let mut fur = pelage_fur::groom::pack(&ball(|_| ())).expect("a groom").undercoat;
    fur.virtual_fragments = 1;
    let error = |k: u32| {
        let mut nodes = vec![Node { z, source: 7, color: Vec4::new(c, c, c, 1.0) * a, ..Node::default() }];
        for i in 0..k {
            let alpha = 1.0 - (-s * length / k as f32).exp();
            let middle = (i as f32 + 0.5) * length / k as f32;
            nodes.push(Node {
                z: middle,
                source: (2 << 30) | i,
                color: Vec4::splat(alpha),
                ..Node::default()
            });
        }
        let g = blend_fragments(&fur, nodes, None);
        ((g.guard + g.undercoat) - Vec3::splat(exact)).abs().max_element()
    };
    let errors = [1, 4, 16, 64].map(error);
    println!("strand in fog, 1 4 16 64 fragments: {errors:.5?}");
    assert!(errors[3] < 1e-3 && errors[3] < errors[0], "{errors:?}");
}
