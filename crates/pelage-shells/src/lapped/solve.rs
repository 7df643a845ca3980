//! Sparse symmetric positive definite systems, by the Cholesky factorisation of `faer`. It runs on
//! one thread, so that results do not depend on their number.

use faer::{
    Mat, Side,
    linalg::solvers::Solve,
    sparse::{SparseColMat, Triplet, linalg::solvers::Llt},
    traits::ComplexField,
};

/// A direction in a face's frame.
pub(super) type Complex = faer::c64;

/// A factorised matrix.
pub(super) struct Factor<T>(Llt<usize, T>);

impl<T: ComplexField> Factor<T> {
    /// Of the Hermitian matrix whose lower triangle holds `entries` (row, column, value), equal
    /// places added up. `None` where it is not positive definite.
    pub fn new(size: usize, entries: impl Iterator<Item = (usize, usize, T)>) -> Option<Self> {
        let entries: Vec<_> = entries.map(|(row, col, value)| Triplet::new(row, col, value)).collect();
        let matrix = SparseColMat::try_new_from_triplets(size, size, &entries).ok()?;
        matrix.sp_cholesky(Side::Lower).ok().map(Self)
    }

    /// Solves for the right-hand sides that stand in the columns.
    pub fn solve(&self, columns: &mut Mat<T>) {
        self.0.solve_in_place(columns.as_mut());
    }
}
