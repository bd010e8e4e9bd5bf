//! Factorisation and solution of small linear systems.

use nalgebra::{DMatrix, DVector};

/// Factors a symmetric positive definite matrix in place: afterwards, its lower triangle contains L with L L' = A.
/// Returns `false` if it is not positive definite.
pub fn factor(a: &mut DMatrix<f64>) -> bool {
    let n = a.nrows();
    for j in 0..n {
        let mut pivot = a[(j, j)];
        for k in 0..j {
            pivot -= a[(j, k)] * a[(j, k)];
        }
        // This condition also rejects a NaN.
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        let root = pivot.sqrt();
        a[(j, j)] = root;
        for i in j + 1..n {
            let mut x = a[(i, j)];
            for k in 0..j {
                x -= a[(i, k)] * a[(j, k)];
            }
            a[(i, j)] = x / root;
        }
    }
    true
}

/// Solves L L' x = b in place, with the lower triangle L that [`factor`] has computed.
pub fn solve_factored(l: &DMatrix<f64>, x: &mut DVector<f64>) {
    let n = l.nrows();
    for i in 0..n {
        let mut value = x[i];
        for k in 0..i {
            value -= l[(i, k)] * x[k];
        }
        x[i] = value / l[(i, i)];
    }
    for i in (0..n).rev() {
        let mut value = x[i];
        for k in i + 1..n {
            value -= l[(k, i)] * x[k];
        }
        x[i] = value / l[(i, i)];
    }
}

/// Computes J J' + damping I.
pub fn damped_square(j: &DMatrix<f64>, damping: f64, out: &mut DMatrix<f64>) {
    for r in 0..j.nrows() {
        for c in 0..=r {
            let mut sum = if r == c { damping } else { 0.0 };
            for k in 0..j.ncols() {
                sum += j[(r, k)] * j[(c, k)];
            }
            out[(r, c)] = sum;
            out[(c, r)] = sum;
        }
    }
}

/// Computes J' y.
pub fn transposed_product(j: &DMatrix<f64>, y: &DVector<f64>, out: &mut DVector<f64>) {
    for c in 0..j.ncols() {
        out[c] = (0..j.nrows()).map(|r| j[(r, c)] * y[r]).sum();
    }
}

/// Returns the Moore-Penrose inverse; singular values below `bound` times the greatest one are treated as 0.
pub fn pseudo_inverse(j: &DMatrix<f64>, bound: f64) -> DMatrix<f64> {
    let svd = j.clone().svd(true, true);
    let least = bound * svd.singular_values.max();
    svd.pseudo_inverse(least).unwrap_or_else(|_| DMatrix::zeros(j.ncols(), j.nrows()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factored_system_is_solved() {
        let a = DMatrix::from_row_slice(3, 3, &[4.0, 2.0, 0.5, 2.0, 5.0, 1.0, 0.5, 1.0, 3.0]);
        let b = DVector::from_row_slice(&[1.0, -2.0, 0.25]);
        let (mut l, mut x) = (a.clone(), b.clone());
        assert!(factor(&mut l));
        solve_factored(&l, &mut x);
        assert!((a * x - b).norm() < 1e-14);
    }

    #[test]
    fn indefinite_matrix_is_refused() {
        assert!(!factor(&mut DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0])));
        assert!(!factor(&mut DMatrix::from_element(1, 1, f64::NAN)));
    }
}
