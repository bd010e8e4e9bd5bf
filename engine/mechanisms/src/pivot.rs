//! Finds the velocities at which all joints of a tree satisfy their laws simultaneously.
//!
//! With one piece selected for each law, the problem is linear: velocities on vertical pieces are known, and the others
//! are found by one linear solve along the tree. A law is violated if its solution is not on the selected piece; the
//! adjacent piece is then selected. Doing this for all violated laws at once usually takes one to three solves, but may
//! cycle. If the number of violated laws does not decrease for [`MAX_STALLED_SOLVES`] solves, only the piece of the
//! first of them is changed per solve, until fewer laws are violated than ever before.
//!
//! Source: Júdice and Pires, A block principal pivoting algorithm for large-scale strictly monotone linear
//! complementarity problems, Computers & Operations Research 21, 1994, for laws of two pieces; the paper cites Murty's
//! proof that changing only the violated piece with the least index terminates for a positive definite matrix. No such
//! proof is known for laws of more pieces, so the number of solves is limited. If the limit is reached, the step
//! applies the forces found last, limited to their bounds.

use crate::{
    composite::MassMatrix,
    factor::SparseFactor,
    law::{ForceLaw, LawPiece},
    tree::Tree,
};

/// Number of solves without a decrease in violated laws after which only one piece is changed per solve.
const MAX_STALLED_SOLVES: usize = 4;

/// Statistics of a search.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PivotStats {
    /// Number of linear solves.
    pub solutions: usize,
    /// Whether all laws are satisfied.
    pub satisfied: bool,
}

impl PivotStats {
    /// Returns the combined statistics of this search and the search that continued it.
    pub fn and(self, next: PivotStats) -> PivotStats {
        PivotStats { solutions: self.solutions + next.solutions, satisfied: next.satisfied }
    }
}

/// The laws of all velocities, and the working memory of the search.
#[derive(Debug, Clone)]
pub(crate) struct PivotSolver {
    pub laws: Vec<ForceLaw>,
    /// The selected piece of each law.
    pub pieces: Vec<usize>,
    /// Velocities at the end of the step.
    pub ends: Vec<f64>,
    /// Forces of the laws.
    pub forces: Vec<f64>,
    /// Accelerations: change of velocities divided by the duration of the step.
    pub accelerations: Vec<f64>,
    next: Vec<usize>,
    held: Vec<bool>,
    added: Vec<f64>,
    product: Vec<f64>,
    pub factor: SparseFactor,
    factored: bool,
    /// Number of factorisations so far.
    pub factorizations: u64,
    /// Maximum number of linear solves of a search.
    pub max_solves: usize,
}

impl PivotSolver {
    pub fn new(tree: &Tree) -> Self {
        let n = tree.velocities();
        PivotSolver {
            laws: (0..n).map(|d| ForceLaw::zero(tree.axes_of(d).len())).collect(),
            pieces: vec![0; n],
            ends: vec![0.0; n],
            forces: vec![0.0; n],
            accelerations: vec![0.0; n],
            next: vec![0; n],
            held: vec![false; n],
            added: vec![0.0; n],
            product: vec![0.0; n],
            factor: SparseFactor::new(tree),
            factored: false,
            factorizations: 0,
            max_solves: 32 + 4 * n,
        }
    }

    /// Returns the condition that the selected piece of each law imposes.
    pub fn selected_pieces(&self) -> impl Iterator<Item = LawPiece> + '_ {
        self.laws.iter().zip(&self.pieces).map(|(law, piece)| law.piece(*piece))
    }

    /// Begins a step with new laws and a new mass matrix, and guesses each piece as if its velocity were decoupled from
    /// the others.
    pub fn begin(&mut self, tree: &Tree, mass: &MassMatrix, bias: &[f64], v: &[f64], h: f64) {
        self.factored = false;
        for (d, (v, bias)) in v.iter().zip(bias).enumerate() {
            let inertia = mass.diagonal(tree, d) / h;
            self.pieces[d] = self.laws[d].guess(inertia, inertia * v - bias);
        }
    }

    /// Continues with a new mass matrix, and the current laws and pieces.
    pub fn discard_factor(&mut self) {
        self.factored = false;
    }

    /// Solves M (ends - v) / h + bias = law(ends), starting with the current pieces.
    ///
    /// # Errors
    ///
    /// Returns the index of the velocity at which the mass matrix is singular.
    pub fn solve(
        &mut self,
        tree: &Tree,
        mass: &MassMatrix,
        bias: &[f64],
        v: &[f64],
        h: f64,
    ) -> Result<PivotStats, usize> {
        let (mut fewest, mut patience) = (usize::MAX, MAX_STALLED_SOLVES);
        for solution in 1..=self.max_solves {
            self.solve_linear(tree, mass, bias, v, h)?;
            let mut off = 0;
            let mut first = None;
            for (d, bias) in bias.iter().enumerate() {
                let (end, force) = (self.ends[d], self.forces[d]);
                let scale = force.abs() + bias.abs() + mass.diagonal(tree, d) * self.accelerations[d].abs();
                let tolerance = (1e-12 * (1.0 + end.abs()), 1e-12 * scale);
                self.next[d] = self.pieces[d];
                if let Some(better) = self.laws[d].adjacent_piece(self.pieces[d], end, force, tolerance) {
                    self.next[d] = better;
                    off += 1;
                    first = first.or(Some(d));
                }
            }
            let Some(first) = first else { return Ok(PivotStats { solutions: solution, satisfied: true }) };
            if off < fewest {
                (fewest, patience) = (off, MAX_STALLED_SOLVES);
            } else if patience > 0 {
                patience -= 1;
            } else {
                self.pieces[first] = self.next[first];
                continue;
            }
            self.pieces.copy_from_slice(&self.next);
        }
        Ok(PivotStats { solutions: self.max_solves, satisfied: false })
    }

    /// Solves with the forces `at - slope v` of `lines` in place of the laws, of which only the allowed range of
    /// velocities remains in effect. A joint that reaches a limit is held there until the end of the step.
    pub fn settle(
        &mut self,
        tree: &Tree,
        mass: &MassMatrix,
        bias: &[f64],
        v: &[f64],
        h: f64,
        lines: &[(f64, f64)],
    ) -> Result<(), usize> {
        for (d, &(at, slope)) in lines.iter().enumerate() {
            let (low, high) = self.laws[d].velocity_range();
            self.laws[d].set_line(at, slope);
            self.laws[d].restrict(low, high);
            self.pieces[d] = usize::from(low > f64::NEG_INFINITY);
        }
        // Allow three changes of piece per velocity: past the corner at velocity 0, back, and onto a limit.
        for _ in 0..=3 * v.len() {
            self.solve_linear(tree, mass, bias, v, h)?;
            let mut moved = false;
            for d in 0..v.len() {
                let free = !self.held[d];
                let better = self.laws[d].adjacent_piece(self.pieces[d], self.ends[d], self.forces[d], (0.0, 0.0));
                if let Some(piece) = better.filter(|_| free) {
                    self.pieces[d] = piece;
                    moved = true;
                }
            }
            if !moved {
                break;
            }
        }
        Ok(())
    }

    /// Solves the linear problem of the current pieces.
    fn solve_linear(&mut self, tree: &Tree, mass: &MassMatrix, bias: &[f64], v: &[f64], h: f64) -> Result<(), usize> {
        let n = v.len();
        let mut any_held = false;
        let mut moving = false;
        let mut same = self.factored;
        for (d, v) in v.iter().enumerate() {
            let (held, added) = match self.laws[d].piece(self.pieces[d]) {
                LawPiece::Held(end) => {
                    let a = (end - v) / h;
                    (self.ends[d], self.accelerations[d]) = (end, a);
                    any_held = true;
                    moving |= a != 0.0;
                    (true, 0.0)
                }
                LawPiece::Line { at, slope } => {
                    self.forces[d] = at - slope * v;
                    self.accelerations[d] = 0.0;
                    (false, h * slope)
                }
            };
            same &= self.held[d] == held && self.added[d] == added;
            (self.held[d], self.added[d]) = (held, added);
        }
        if !same {
            self.factored = false;
            self.factor.update(tree, &mass.entries, &self.added, &self.held)?;
            self.factored = true;
            self.factorizations += 1;
        }
        self.product.copy_from_slice(bias);
        if moving {
            mass.add_product(tree, &self.accelerations, &mut self.product);
        }
        // Use `accelerations` for the right-hand side; those of held velocities are recomputed from `ends` below.
        for d in 0..n {
            self.accelerations[d] = if self.held[d] { 0.0 } else { self.forces[d] - self.product[d] };
        }
        self.factor.solve(tree, &mut self.accelerations);
        for (d, v) in v.iter().enumerate() {
            if self.held[d] {
                self.accelerations[d] = (self.ends[d] - v) / h;
            } else {
                self.ends[d] = v + h * self.accelerations[d];
                self.forces[d] -= self.added[d] * self.accelerations[d];
            }
        }
        if any_held {
            self.product.copy_from_slice(bias);
            mass.add_product(tree, &self.accelerations, &mut self.product);
            for d in 0..n {
                if self.held[d] {
                    self.forces[d] = self.product[d];
                }
            }
        }
        Ok(())
    }
}
