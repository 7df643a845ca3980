//! `light_occlusion` against its CPU twin, which tries every triangle.

use crate::common::gpu::{self, Fixture};
use pelage_fur::layout::Column;
use pelage_render::twin::light_occlusion::bits;

const LIGHTS: &str = "[[lights]]\ndirection = [0.3, 0.8, 0.1]\n[[lights]]\ndirection = [-1, 0.1, 0.2]\n\
    [[lights]]\ndirection = [0.1, -1, 0.3]\n[[lights]]\ndirection = [1, 0.0, 0.001]\n[environment]\nlights = 32\n";

/// Columns of a shape and, for each, the bits of the GPU and of the twin.
fn both(gpu: &'static pelage_gpu::Gpu, mesh: &str) -> (u32, Vec<(u64, u64)>) {
    let scene = format!(
        "[mesh]\n{mesh}\n{LIGHTS}[undercoat]\nheight = 0.05\nlayers = 1\nsubdivision = 0\n[render]\nfur = \"implicit\"\n"
    );
    let fixture = Fixture::new(gpu, gpu::world(&scene));
    let columns: Vec<Column> = fixture.read("columns", fixture.fur.lattice.columns as usize);
    // Some 200 columns: the twin is slow.
    let step = columns.len() / 200 + 1;
    let thinned: Vec<&Column> = columns.iter().step_by(step).collect();
    let lights = &fixture.packed.lights;
    let wanted = thinned.iter().map(|c| bits(&fixture.shell, &fixture.fur, lights, c));
    let found = thinned.iter().map(|c| u64::from(c.blocked[0]) | (u64::from(c.blocked[1]) << 32));
    (fixture.fur.lights.count, found.zip(wanted).collect())
}

#[test]
fn the_same_lights_are_blocked() {
    let Some(gpu) = gpu::open() else { return };
    for mesh in
        ["shape = \"torus\"\nsize = 3", "shape = \"hat\"\nsize = 3", "shape = \"cylinder_pelt\"\nsize = 3"]
    {
        let (lights, columns) = both(gpu, mesh);
        assert_eq!(lights, 36);
        let total = columns.len() as u32 * lights;
        let wrong: u32 = columns.iter().map(|(a, b)| (a ^ b).count_ones()).sum();
        let blocked: u32 = columns.iter().map(|(_, b)| b.count_ones()).sum();
        // Rays that graze an edge may fall on either side.
        assert!(wrong * 200 < total, "{mesh}: {wrong} of {total} rays differ");
        assert!(
            blocked * 20 > total && blocked * 10 < total * 9,
            "{mesh}: {blocked} of {total} rays are blocked"
        );
        // Bits of the next column do not agree: the comparison can fail.
        let shifted: u32 = columns.windows(9).map(|w| (w[0].0 ^ w[8].1).count_ones()).sum();
        assert!(shifted * 200 > total, "{mesh}: {shifted}");
    }
}
