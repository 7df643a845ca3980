// Optical depths at the nodes of the lattice, pairs of halves: one per light, then that towards the
// camera. A node has `fur.lattice.tau_stride` words: with multiple scattering by transport, the
// mean scattered radiance from above and from below follows, six halves.
// Needs: fur (uniform FurParameters), tau (array<u32>).

#import shared/lattice_nodes

// Number of words of a node's optical depths.
fn tau_pairs() -> u32 {
    return (fur.lights.count + 2u) / 2u;
}

// First of the three words of a node's scattered radiance.
fn scattered_word(node: u32) -> u32 {
    return node * fur.lattice.tau_stride + tau_pairs();
}

// Optical depth from a node towards a light, or towards the camera (number fur.lights.count).
fn node_tau(node: u32, light: u32) -> f32 {
    return unpack2x16float(tau[node * fur.lattice.tau_stride + light / 2u])[light & 1u];
}

// Interpolated between a node and the one above it.
fn tau_between(node: u32, light: u32, fraction: f32) -> f32 {
    return mix(node_tau(node, light), node_tau(node + 1u, light), fraction);
}

// Interpolated in a cell of the lattice.
fn cell_tau(cell: LatticeCell, light: u32) -> f32 {
    var sum = 0.0;
    for (var k = 0u; k < 3u; k++) {
        sum += cell.weights[k] * tau_between(node_index(cell.columns[k], cell.level), light, cell.fraction);
    }
    return sum;
}
