//! Solutions, inverses and eigenvalues of dense matrices.

use nalgebra::DMatrix;

/// A dense matrix.
pub type Matrix = DMatrix<f64>;
type AlgebraResult<T> = Result<T, String>;

/// Maximum number of iterations of an eigenvalue computation.
const MAX_ITERATIONS: usize = 10_000;
/// Maximum 1-norm of a matrix whose exponential is computed.
const MAX_NORM: f64 = 1000.0;
/// Fraction of the greatest singular value below which singular values are treated as 0.
const SINGULAR_TOLERANCE: f64 = 1e-12;

fn check_square(m: &Matrix) -> AlgebraResult<()> {
    if m.is_square() { Ok(()) } else { Err(format!("expected a square matrix, found {} x {}", m.nrows(), m.ncols())) }
}

/// Solves a x = b, in the least-squares sense if `a` has more rows than columns.
pub fn solve(a: &Matrix, b: &Matrix) -> AlgebraResult<Matrix> {
    if a.nrows() != b.nrows() {
        return Err(format!("{} equations require as many right-hand sides, found {}", a.nrows(), b.nrows()));
    }
    if a.nrows() < a.ncols() {
        let [rows, columns] = [a.nrows(), a.ncols()];
        return Err(format!(
            "{rows} equations for {columns} unknowns: expected at least as many equations as unknowns"
        ));
    }
    let lacks = || "the equations have no unique solution: the matrix is singular".to_owned();
    if a.is_square() {
        return a.clone().lu().solve(b).filter(|x| x.iter().all(|v| v.is_finite())).ok_or_else(lacks);
    }
    let svd = a.clone().svd(true, true);
    let most = svd.singular_values.max();
    if svd.singular_values.min() <= SINGULAR_TOLERANCE * most {
        return Err(lacks());
    }
    svd.solve(b, 0.0).map_err(str::to_owned)
}

/// Returns the inverse of a square matrix.
pub fn inverse(m: &Matrix) -> AlgebraResult<Matrix> {
    check_square(m)?;
    let inverse = m.clone().try_inverse().filter(|x| x.iter().all(|v| v.is_finite()));
    inverse.ok_or_else(|| "the matrix is singular: it has no inverse".into())
}

/// Returns the Moore-Penrose inverse; singular values below 1e-12 times the greatest one are treated as 0.
pub fn pseudo_inverse(m: &Matrix) -> AlgebraResult<Matrix> {
    let most = m.clone().singular_values().max();
    m.clone().pseudo_inverse(SINGULAR_TOLERANCE * most).map_err(str::to_owned)
}

/// Returns the exponential of a square matrix.
pub fn exponential(m: &Matrix) -> AlgebraResult<Matrix> {
    check_square(m)?;
    // The number of squarings grows with the norm, and each squaring loses precision.
    let norm = m.column_iter().map(|c| c.lp_norm(1)).fold(0.0, f64::max);
    if norm > MAX_NORM {
        return Err(format!("the 1-norm of the matrix must be at most {MAX_NORM}, but it is {norm:e}"));
    }
    Ok(m.exp())
}

/// Returns the lower triangular factor L of the Cholesky decomposition L L' of a symmetric matrix.
pub fn cholesky(m: &Matrix) -> AlgebraResult<Matrix> {
    check_square(m)?;
    check_symmetric(m)?;
    let found = m.clone().cholesky();
    found.map(|c| c.l()).ok_or_else(|| "the matrix is not positive definite".into())
}

/// Returns the determinant of a square matrix.
pub fn determinant(m: &Matrix) -> AlgebraResult<f64> {
    check_square(m)?;
    Ok(m.determinant())
}

/// Returns the real and the imaginary parts of the eigenvalues of a square matrix, by ascending real part.
pub fn eigenvalues(m: &Matrix) -> AlgebraResult<(Vec<f64>, Vec<f64>)> {
    check_square(m)?;
    let schur = nalgebra::linalg::Schur::try_new(m.clone(), f64::EPSILON, MAX_ITERATIONS);
    let schur = schur.ok_or("the eigenvalues were not found: the iteration did not converge")?;
    let mut all: Vec<(f64, f64)> = schur.complex_eigenvalues().iter().map(|c| (c.re, c.im)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    Ok(all.into_iter().unzip())
}

/// Returns the eigenvalues of a symmetric matrix, in ascending order, and its eigenvectors as columns.
pub fn symmetric_eigen(m: &Matrix) -> AlgebraResult<(Vec<f64>, Matrix)> {
    check_square(m)?;
    check_symmetric(m)?;
    let eigen = nalgebra::linalg::SymmetricEigen::try_new(m.clone(), f64::EPSILON, MAX_ITERATIONS);
    let eigen = eigen.ok_or("the eigenvalues were not found: the iteration did not converge")?;
    let mut order: Vec<usize> = (0..m.nrows()).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    // The sign of an eigenvector is arbitrary: make the component with the largest magnitude positive, so that results
    // are reproducible.
    let columns = order.iter().map(|i| {
        let v = eigen.eigenvectors.column(*i).into_owned();
        if v[v.iamax()] < 0.0 { -v } else { v }
    });
    let vectors = Matrix::from_columns(&columns.collect::<Vec<_>>());
    Ok((order.iter().map(|i| eigen.eigenvalues[*i]).collect(), vectors))
}

fn check_symmetric(m: &Matrix) -> AlgebraResult<()> {
    let (away, most) = ((m - m.transpose()).amax(), m.amax());
    if away <= 1e-9 * most { Ok(()) } else { Err("expected a symmetric matrix".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn m(rows: usize, numbers: &[f64]) -> Matrix {
        Matrix::from_row_slice(rows, numbers.len() / rows, numbers)
    }

    #[test]
    fn equations_are_solved_or_refused() {
        let x = solve(&m(2, &[2.0, 1.0, 1.0, 3.0]), &m(2, &[3.0, 5.0])).unwrap();
        assert!((x - m(2, &[0.8, 1.4])).amax() < 1e-14);
        // A line through (0, 1), (1, 2), (2, 4): y = 5/6 + 3/2 x.
        let x = solve(&m(3, &[1.0, 0.0, 1.0, 1.0, 1.0, 2.0]), &m(3, &[1.0, 2.0, 4.0])).unwrap();
        assert!((x - m(2, &[5.0 / 6.0, 1.5])).amax() < 1e-12);
        assert!(solve(&m(2, &[1.0, 2.0, 2.0, 4.0]), &m(2, &[1.0, 1.0])).is_err());
        assert!(solve(&m(1, &[1.0, 2.0]), &m(1, &[1.0])).is_err());
        assert!(inverse(&m(2, &[1.0, 2.0, 2.0, 4.0])).is_err());
    }

    #[test]
    fn eigenvalues_are_ascending() {
        // A damped oscillator: -0.1 +- i sqrt(1 - 0.01).
        let (real, imaginary) = eigenvalues(&m(2, &[0.0, 1.0, -1.0, -0.2])).unwrap();
        let w = 0.99_f64.sqrt();
        assert!(real.iter().all(|r| (r + 0.1).abs() < 1e-14), "{real:?}");
        assert!((imaginary[0] + w).abs() < 1e-14 && (imaginary[1] - w).abs() < 1e-14, "{imaginary:?}");
        let (values, vectors) = symmetric_eigen(&m(2, &[2.0, 1.0, 1.0, 2.0])).unwrap();
        assert!((values[0] - 1.0).abs() < 1e-14 && (values[1] - 3.0).abs() < 1e-14);
        let half = 0.5_f64.sqrt();
        assert!((vectors.column(1) - m(2, &[half, half])).amax() < 1e-14);
        assert!(symmetric_eigen(&m(2, &[0.0, 1.0, 0.0, 0.0])).is_err());
    }

    #[test]
    fn exponential_advances_a_linear_system() {
        // Sine and cosine of 0.7.
        let (s, c) = (0.644217687237691, 0.764842187284489);
        let turned = exponential(&m(2, &[0.0, -0.7, 0.7, 0.0])).unwrap();
        assert!((turned - m(2, &[c, -s, s, c])).amax() < 1e-14);
        assert!(exponential(&m(2, &[0.0, 1e20, -1e20, 0.0])).is_err());
        assert!((pseudo_inverse(&m(2, &[1.0, 1.0])).unwrap() - m(1, &[0.5, 0.5])).amax() < 1e-14);
        assert!((cholesky(&m(2, &[4.0, 2.0, 2.0, 5.0])).unwrap() - m(2, &[2.0, 0.0, 1.0, 2.0])).amax() < 1e-14);
    }
}
