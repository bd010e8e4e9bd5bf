//! Finds the velocities at which all joints of a tree meet their laws at once.
//!
//! With a choice of one piece for each law, the problem is linear: velocities on vertical pieces are known, the others
//! follow from one solution along the tree. Laws whose solution lies off their piece move on to the next one. Moving
//! all of them at once mostly ends after one to three solutions, but may cycle; then single moves, the first law first,
//! take over until fewer laws are off than ever before.
//!
//! Source: Júdice and Pires, A block principal pivoting algorithm for large-scale strictly monotone linear
//! complementarity problems, Computers & Operations Research 21, 1994, for laws of two pieces; that single moves by the
//! least index end for a positive definite matrix is Murty's result, cited there. For laws of more pieces there is no
//! proof here, so that the number of solutions is bounded, and what is left after it is met by forces that are allowed.

use crate::{
    composite::MassMatrix,
    factor::Factor,
    law::{Law, Piece},
    tree::Tree,
};

/// Block moves that may fail to leave fewer laws off before single moves begin.
const PATIENCE: usize = 4;

/// How a solution was found.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Search {
    /// Linear solutions.
    pub solutions: usize,
    /// Whether all laws are met.
    pub met: bool,
}

impl Search {
    /// Returns this search and the one that went on from it.
    pub fn and(self, next: Search) -> Search {
        Search { solutions: self.solutions + next.solutions, met: next.met }
    }
}

/// Laws of all velocities, and room to solve them.
#[derive(Debug, Clone)]
pub(crate) struct Pivot {
    pub laws: Vec<Law>,
    /// The piece that each law is on.
    pub pieces: Vec<usize>,
    /// Velocities at the end of the step.
    pub ends: Vec<f64>,
    /// Forces of the laws.
    pub forces: Vec<f64>,
    /// Accelerations: velocities at the end less those at the beginning, over the step.
    pub accelerations: Vec<f64>,
    next: Vec<usize>,
    held: Vec<bool>,
    added: Vec<f64>,
    product: Vec<f64>,
    pub factor: Factor,
    factored: bool,
    /// Factorisations so far.
    pub renewals: u64,
    /// Most linear solutions of a search.
    pub most: usize,
}

impl Pivot {
    pub fn new(tree: &Tree) -> Self {
        let n = tree.velocities();
        Pivot {
            laws: vec![Law::ZERO; n],
            pieces: vec![0; n],
            ends: vec![0.0; n],
            forces: vec![0.0; n],
            accelerations: vec![0.0; n],
            next: vec![0; n],
            held: vec![false; n],
            added: vec![0.0; n],
            product: vec![0.0; n],
            factor: Factor::new(tree),
            factored: false,
            renewals: 0,
            most: 32 + 4 * n,
        }
    }

    /// Returns what each law asks for on its piece.
    pub fn forms(&self) -> impl Iterator<Item = Piece> + '_ {
        self.laws.iter().zip(&self.pieces).map(|(law, piece)| law.piece(*piece))
    }

    /// Returns what was added to the diagonal of the mass matrix in the last factorisation.
    pub fn added(&self) -> &[f64] {
        &self.added
    }

    /// Begins a step with new laws and a new mass matrix: guesses each piece as if its velocity were alone.
    pub fn begin(&mut self, tree: &Tree, mass: &MassMatrix, bias: &[f64], v: &[f64], h: f64) {
        self.factored = false;
        for (d, (v, bias)) in v.iter().zip(bias).enumerate() {
            let inertia = mass.diagonal(tree, d) / h;
            self.pieces[d] = self.laws[d].guess(inertia, inertia * v - bias);
        }
    }

    /// Goes on with a new mass matrix, and laws and pieces as they are.
    pub fn renew(&mut self) {
        self.factored = false;
    }

    /// Solves M (ends - v) / h + bias = law(ends), beginning from the pieces at hand.
    ///
    /// # Errors
    ///
    /// The velocity at which the mass matrix is singular.
    pub fn solve(&mut self, tree: &Tree, mass: &MassMatrix, bias: &[f64], v: &[f64], h: f64) -> Result<Search, usize> {
        let (mut fewest, mut patience) = (usize::MAX, PATIENCE);
        for solution in 1..=self.most {
            self.linear(tree, mass, bias, v, h)?;
            let mut off = 0;
            let mut first = None;
            for (d, bias) in bias.iter().enumerate() {
                let (end, force) = (self.ends[d], self.forces[d]);
                let scale = force.abs() + bias.abs() + mass.diagonal(tree, d) * self.accelerations[d].abs();
                let tolerance = (1e-12 * (1.0 + end.abs()), 1e-12 * scale);
                self.next[d] = self.pieces[d];
                if let Some(better) = self.laws[d].better(self.pieces[d], end, force, tolerance) {
                    self.next[d] = better;
                    off += 1;
                    first = first.or(Some(d));
                }
            }
            let Some(first) = first else { return Ok(Search { solutions: solution, met: true }) };
            if off < fewest {
                (fewest, patience) = (off, PATIENCE);
            } else if patience > 0 {
                patience -= 1;
            } else {
                self.pieces[first] = self.next[first];
                continue;
            }
            self.pieces.copy_from_slice(&self.next);
        }
        Ok(Search { solutions: self.most, met: false })
    }

    /// Solves with the forces `at - slope v`, whatever the laws say; only the velocities that they allow stay. Joints
    /// that meet a limit stop there, if need be until the next step.
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
            let (low, high) = self.laws[d].domain();
            self.laws[d].set_line(at, slope);
            self.laws[d].restrict(low, high);
            self.pieces[d] = usize::from(low > f64::NEG_INFINITY);
        }
        // at most three moves of each: past the corner at 0, and onto a limit
        for _ in 0..=3 * v.len() {
            self.linear(tree, mass, bias, v, h)?;
            let mut moved = false;
            for d in 0..v.len() {
                let free = !self.held[d];
                let better = self.laws[d].better(self.pieces[d], self.ends[d], self.forces[d], (0.0, 0.0));
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

    /// Solves for the pieces at hand.
    fn linear(&mut self, tree: &Tree, mass: &MassMatrix, bias: &[f64], v: &[f64], h: f64) -> Result<(), usize> {
        let n = v.len();
        let mut any_held = false;
        let mut moving = false;
        let mut same = self.factored;
        for (d, v) in v.iter().enumerate() {
            let (held, added) = match self.laws[d].piece(self.pieces[d]) {
                Piece::Held(end) => {
                    let a = (end - v) / h;
                    (self.ends[d], self.accelerations[d]) = (end, a);
                    any_held = true;
                    moving |= a != 0.0;
                    (true, 0.0)
                }
                Piece::Line { at, slope } => {
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
            self.renewals += 1;
        }
        self.product.copy_from_slice(bias);
        if moving {
            mass.add_product(tree, &self.accelerations, &mut self.product);
        }
        // accelerations of what is free; those of what is held are kept aside in `ends`
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
