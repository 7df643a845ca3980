//! Sparse Hermitian positive definite systems, by the Cholesky factorisation of `faer` on one
//! thread, so that results do not depend on the number of threads.

use faer::{
    Mat, Side,
    linalg::solvers::Solve,
    sparse::{SparseColMat, Triplet, linalg::solvers::Llt},
    traits::ComplexField,
};

/// A direction in the frame of a face, as a complex number.
pub(super) type Complex = faer::c64;

/// A factorised matrix.
pub(super) struct Factor<T>(Llt<usize, T>);

impl<T: ComplexField> Factor<T> {
    /// Factorises the Hermitian matrix with `entries` (row, column, value) in its lower triangle;
    /// duplicates are summed. `None` if it is not positive definite.
    pub fn new(size: usize, entries: impl Iterator<Item = (usize, usize, T)>) -> Option<Self> {
        let entries: Vec<_> = entries.map(|(row, col, value)| Triplet::new(row, col, value)).collect();
        let matrix = SparseColMat::try_new_from_triplets(size, size, &entries).ok()?;
        matrix.sp_cholesky(Side::Lower).ok().map(Self)
    }

    /// Solves for the right-hand sides in `columns`, in place.
    pub fn solve(&self, columns: &mut Mat<T>) {
        self.0.solve_in_place(columns.as_mut());
    }
}
