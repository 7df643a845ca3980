//! `edge_table` against its CPU twin and against the neighbour table of the mesh.

use crate::common::cases;
use crate::common::gpu::{self, Fixture, jittered_grid, skin, world_on};
use glam::Vec3;
use pelage_core::Skin;
use pelage_core::mesh::topology;
use pelage_core::skin::NONE;
use pelage_render::twin::edge_table::neighbours;
use proptest::prelude::*;

const SCENE: &str = "[render]\nfur = \"implicit\"\n[undercoat]\nlayers = 1\nsubdivision = 0\n";

/// Meshes with every kind of edge: closed, open, three triangles on an edge, inconsistent winding,
/// a triangle twice.
fn meshes() -> Vec<(&'static str, Skin)> {
    let tetrahedron = vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::ONE];
    let fan = vec![[0, 1, 2], [1, 0, 3], [1, 0, 4]];
    let turned = vec![[0, 1, 2], [0, 1, 3], [1, 3, 5]];
    let twice = vec![[0, 1, 2], [0, 1, 2], [2, 1, 3]];
    let of = |triangles: &Vec<[u32; 3]>| skin(corners.clone(), triangles.clone());
    vec![
        ("closed", of(&tetrahedron)),
        ("open", jittered_grid(9, 0.2)),
        ("non-manifold", of(&fan)),
        ("inconsistent", of(&turned)),
        ("duplicate", of(&twice)),
    ]
}

#[test]
fn the_gpu_finds_the_same_neighbours() {
    let Some(gpu) = gpu::open() else { return };
    for (name, skin) in meshes() {
        let wanted = topology::neighbours(&skin.triangles).neighbours;
        assert_eq!(neighbours(&skin.triangles), wanted, "twin, {name}");
        let fixture = Fixture::new(gpu, world_on(SCENE, Some(skin), Vec::new()));
        let found: Vec<[u32; 3]> = fixture.shell.prisms.iter().map(|p| p.neighbours).collect();
        assert_eq!(found, wanted, "GPU, {name}");
        let corners: Vec<[u32; 3]> = fixture.shell.prisms.iter().map(|p| p.vertices).collect();
        assert_eq!(corners, fixture.world.skin.triangles, "corners, {name}");
        let open = wanted.iter().flatten().filter(|n| **n == NONE).count();
        assert_eq!(fixture.prepared.walls as usize, open, "walls, {name}");
    }
}

/// The table without the check of single owners: the first owner of a reversed key is the
/// neighbour.
fn careless(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let side = |t: &[u32; 3], k: usize| (t[(k + 1) % 3], t[(k + 2) % 3]);
    let owner = |key| triangles.iter().position(|t| (0..3).any(|k| side(t, k) == key));
    let across = |t: &[u32; 3], k| owner((side(t, k).1, side(t, k).0)).map_or(NONE, |i| i as u32);
    triangles.iter().map(|t| [0, 1, 2].map(|k| across(t, k))).collect()
}

fn symmetric(table: &[[u32; 3]]) -> bool {
    let inner = table.iter().enumerate().flat_map(|(t, n)| n.iter().map(move |n| (t as u32, *n)));
    inner.filter(|(_, n)| *n != NONE).all(|(t, n)| {
        let back = |a: u32, b: u32| table[a as usize].iter().filter(|x| **x == b).count();
        back(n, t) == back(t, n)
    })
}

#[test]
fn a_table_without_the_check_of_owners_is_caught() {
    let (_, fan) = meshes().remove(2);
    assert!(!symmetric(&careless(&fan.triangles)));
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn neighbours_are_symmetric(indices in prop::collection::vec(prop::array::uniform3(0u32..9), 1..40)) {
        let triangles: Vec<[u32; 3]> =
            indices.into_iter().filter(|[a, b, c]| a != b && b != c && c != a).collect();
        let topology = topology::neighbours(&triangles);
        let table = neighbours(&triangles);
        prop_assert!(symmetric(&table));
        // The two tables differ where more than two triangles share an undirected edge but each
        // directed key has one owner: never.
        prop_assert_eq!(&table, &topology.neighbours);
        let open = table.iter().flatten().filter(|n| **n == NONE).count();
        // Each inner edge has two sides.
        prop_assert_eq!((3 * triangles.len() - open) % 2, 0);
    }
}
