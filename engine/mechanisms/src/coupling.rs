//! The Delassus matrix of an island: the responses of the rows of all contacts to impulses along each other.

use crate::{
    jacobian::{ContactJacobian, HalfRow},
    vector::Vec3,
};

/// The velocity that each row gains per impulse along each other row: a symmetric positive semidefinite matrix.
#[derive(Debug, Clone, Default)]
pub(crate) struct DelassusMatrix {
    /// Number of rows: three for each of the contacts considered.
    size: usize,
    entries: Vec<f64>,
}

impl DelassusMatrix {
    /// Computes the responses of the contacts with the indices in `points` from the current factorisation. Complexity:
    /// the square of their number, times the depth at which their paths part.
    pub fn update(&mut self, rows: &ContactJacobian, points: &[usize]) {
        let count = points.len();
        self.size = 3 * count;
        self.entries.clear();
        self.entries.resize(self.size * self.size, 0.0);
        for i in 0..count {
            for k in 0..=i {
                let mut block = [[0.0; 3]; 3];
                for a in rows.points[points[i]].halves.iter().flatten() {
                    for b in rows.points[points[k]].halves.iter().flatten().filter(|b| b.member == a.member) {
                        add_block(rows, a, b, &mut block);
                    }
                }
                for (r, row) in block.iter().enumerate() {
                    for (c, entry) in row.iter().enumerate() {
                        self.entries[(3 * i + r) * self.size + 3 * k + c] = *entry;
                        self.entries[(3 * k + c) * self.size + 3 * i + r] = *entry;
                    }
                }
            }
        }
    }

    /// Returns the responses of a row to all rows, 1/kg.
    #[inline]
    pub fn row(&self, row: usize) -> &[f64] {
        &self.entries[row * self.size..][..self.size]
    }
}

/// Adds the responses of one half of a contact to impulses on a half of another contact of the same tree. Both have
/// their columns in ascending order.
fn add_block(rows: &ContactJacobian, a: &HalfRow, b: &HalfRow, block: &mut [Vec3; 3]) {
    let (mut i, mut k) = (a.first, b.first);
    while i < a.end && k < b.end {
        match rows.columns[i].cmp(&rows.columns[k]) {
            std::cmp::Ordering::Less => i += 1,
            std::cmp::Ordering::Greater => k += 1,
            std::cmp::Ordering::Equal => {
                let (y, response) = (rows.y[i], rows.response[k]);
                for (row, y) in block.iter_mut().zip(y) {
                    for (entry, response) in row.iter_mut().zip(response) {
                        *entry += y * response;
                    }
                }
                (i, k) = (i + 1, k + 1);
            }
        }
    }
}
