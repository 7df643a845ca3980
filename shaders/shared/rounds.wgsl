// Whether the adapter has ended loops early: Mesa's software adapter ends all loops of an
// invocation once they have run 65,535 rounds together. Then a loop of two rounds ends after the
// first. The number of rounds comes from a uniform, so that no compiler removes the loop.
// Needs: fur (uniform FurParameters).

fn rounds_ran_out() -> bool {
    let wanted = min(fur.lattice.levels, 2u);
    var rounds = 0u;
    loop {
        rounds++;
        if rounds >= wanted {
            break;
        }
    }
    return rounds < wanted;
}
