//! Shortest paths on occupancy grids: A* and Theta*.
//!
//! P. E. Hart, N. J. Nilsson and B. Raphael, "A formal basis for the heuristic determination of minimum cost paths" (1968);
//! A. Nash, K. Daniel, S. Koenig and A. Felner, "Theta*: any-angle path planning on grids" (2007).

use std::{cmp::Reverse, collections::BinaryHeap};

/// A cell: column and row.
pub type Cell = [usize; 2];

/// Cells that are free or occupied.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OccupancyGrid {
    columns: usize,
    rows: usize,
    occupied: Vec<bool>,
}

/// Largest number of cells.
const MAX_CELLS: usize = 1 << 28;

impl OccupancyGrid {
    /// Returns a free grid, or `None` if it has no cells, or more than 2^28.
    pub fn new(columns: usize, rows: usize) -> Option<Self> {
        let cells = columns.checked_mul(rows).filter(|n| (1..=MAX_CELLS).contains(n))?;
        Some(OccupancyGrid { columns, rows, occupied: vec![false; cells] })
    }

    /// Returns the grid of a drawing, a line for each row, in which `#` is occupied; missing cells are free.
    ///
    /// ```
    /// use tatu_planning::{OccupancyGrid, a_star};
    ///
    /// let grid = OccupancyGrid::drawn(&["....", ".##.", "...."]).unwrap();
    /// let path = a_star(&grid, [0, 1], [3, 1]).unwrap();
    /// assert_eq!(path.len(), 6);
    /// ```
    pub fn drawn(lines: &[&str]) -> Option<Self> {
        let mut grid = Self::new(lines.iter().map(|l| l.len()).max()?, lines.len())?;
        for (row, line) in lines.iter().enumerate() {
            for (column, letter) in line.bytes().enumerate() {
                grid.set([column, row], letter == b'#');
            }
        }
        Some(grid)
    }

    /// Returns the number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Marks a cell as occupied or free; cells outside are ignored.
    pub fn set(&mut self, cell: Cell, occupied: bool) {
        if cell[0] < self.columns && cell[1] < self.rows {
            let i = self.index(cell);
            self.occupied[i] = occupied;
        }
    }

    /// Returns whether a cell exists and is free.
    pub fn is_free(&self, cell: Cell) -> bool {
        cell[0] < self.columns && cell[1] < self.rows && !self.occupied[self.index(cell)]
    }

    pub(crate) fn index(&self, cell: Cell) -> usize {
        cell[1] * self.columns + cell[0]
    }
    pub(crate) fn cell(&self, index: usize) -> Cell {
        [index % self.columns, index / self.columns]
    }

    /// Returns whether one may go from a cell to a neighbour: diagonally only if both cells beside are free.
    pub(crate) fn is_passable(&self, from: Cell, to: Cell) -> bool {
        let beside = self.is_free([from[0], to[1]]) && self.is_free([to[0], from[1]]);
        self.is_free(from) && self.is_free(to) && beside
    }

    /// Returns the neighbours within the grid, occupied or not.
    pub(crate) fn around(&self, [column, row]: Cell) -> impl Iterator<Item = Cell> {
        let (columns, rows) = (self.columns, self.rows);
        let offsets = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];
        offsets.into_iter().filter_map(move |(dx, dy): (isize, isize)| {
            let cell = [column.checked_add_signed(dx)?, row.checked_add_signed(dy)?];
            (cell[0] < columns && cell[1] < rows).then_some(cell)
        })
    }

    /// Returns whether the straight line between the centres of two cells touches no occupied cell.
    pub fn sees(&self, from: Cell, to: Cell) -> bool {
        let (mut x, mut y) = (from[0] as isize, from[1] as isize);
        let (dx, dy) = (to[0] as isize - x, to[1] as isize - y);
        let (sx, sy, nx, ny) = (dx.signum(), dy.signum(), dx.abs(), dy.abs());
        let free = |x: isize, y: isize| x >= 0 && y >= 0 && self.is_free([x as usize, y as usize]);
        let (mut ix, mut iy) = (0, 0);
        if !free(x, y) {
            return false;
        }
        while ix < nx || iy < ny {
            // Which border the line crosses first: a vertical one, a horizontal one, or a corner.
            let side = (1 + 2 * ix) * ny - (1 + 2 * iy) * nx;
            if side == 0 && (!free(x + sx, y) || !free(x, y + sy)) {
                return false;
            }
            if side <= 0 {
                x += sx;
                ix += 1;
            }
            if side >= 0 {
                y += sy;
                iy += 1;
            }
            if !free(x, y) {
                return false;
            }
        }
        true
    }
}

/// Returns the distance between the centres of two cells, in cells.
pub fn cell_distance(a: Cell, b: Cell) -> f64 {
    libm::hypot(a[0] as f64 - b[0] as f64, a[1] as f64 - b[1] as f64)
}

/// Returns the shortest path of steps to the eight neighbours, with both ends, or `None` if there is none.
pub fn a_star(grid: &OccupancyGrid, start: Cell, goal: Cell) -> Option<Vec<Cell>> {
    best_first(grid, start, goal, false)
}

/// Returns a path whose corners see each other, with both ends, or `None` if there is none. It is at most as long as
/// that of A*, and nearly the shortest.
pub fn theta_star(grid: &OccupancyGrid, start: Cell, goal: Cell) -> Option<Vec<Cell>> {
    best_first(grid, start, goal, true)
}

/// The least cost of a path on an empty grid by steps to neighbours.
pub(crate) fn step_distance(a: Cell, b: Cell) -> f64 {
    let (dx, dy) = (a[0].abs_diff(b[0]) as f64, a[1].abs_diff(b[1]) as f64);
    dx.max(dy) + (std::f64::consts::SQRT_2 - 1.0) * dx.min(dy)
}

fn best_first(grid: &OccupancyGrid, start: Cell, goal: Cell, any_angle: bool) -> Option<Vec<Cell>> {
    if !grid.is_free(start) || !grid.is_free(goal) {
        return None;
    }
    let estimate = |cell| if any_angle { cell_distance(cell, goal) } else { step_distance(cell, goal) };
    let cells = grid.columns * grid.rows;
    let (mut costs, mut from, mut closed) = (vec![f64::INFINITY; cells], vec![usize::MAX; cells], vec![false; cells]);
    let (first, last) = (grid.index(start), grid.index(goal));
    (costs[first], from[first]) = (0.0, first);
    let mut open = BinaryHeap::new();
    // The bits of numbers that are not negative are ordered as the numbers are.
    open.push(Reverse((estimate(start).to_bits(), first)));
    while let Some(Reverse((_, i))) = open.pop() {
        if closed[i] {
            continue;
        }
        closed[i] = true;
        if i == last {
            let mut path = vec![grid.cell(i)];
            let mut at = i;
            while from[at] != at {
                at = from[at];
                path.push(grid.cell(at));
            }
            path.reverse();
            return Some(path);
        }
        let cell = grid.cell(i);
        for next in grid.around(cell).filter(|n| grid.is_passable(cell, *n)) {
            let n = grid.index(next);
            let above = grid.cell(from[i]);
            let (parent, base) = if any_angle && grid.sees(above, next) { (from[i], above) } else { (i, cell) };
            let cost = costs[parent] + cell_distance(base, next);
            if cost < costs[n] && !closed[n] {
                (costs[n], from[n]) = (cost, parent);
                open.push(Reverse(((cost + estimate(next)).to_bits(), n)));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn length(path: &[Cell]) -> f64 {
        path.windows(2).map(|w| cell_distance(w[0], w[1])).sum()
    }

    #[test]
    fn a_star_finds_the_length_that_is_counted_by_hand() {
        let grid = OccupancyGrid::drawn(&[".....", ".###.", ".....", "....."]).unwrap();
        let path = a_star(&grid, [2, 0], [2, 2]).unwrap();
        // To the side by 2, down by 2, back by 2: corners must not be cut.
        assert!((length(&path) - 6.0).abs() < 1e-12);
        assert!(path.windows(2).all(|w| grid.is_passable(w[0], w[1])));
    }

    #[test]
    fn theta_star_is_never_longer_and_straight_in_the_open() {
        let mut random = Random::new(5);
        for _ in 0..50 {
            let mut grid = OccupancyGrid::new(30, 20).unwrap();
            for _ in 0..120 {
                grid.set([random.index(30), random.index(20)], true);
            }
            grid.set([0, 0], false);
            grid.set([29, 19], false);
            let (a, t) = (a_star(&grid, [0, 0], [29, 19]), theta_star(&grid, [0, 0], [29, 19]));
            assert_eq!(a.is_some(), t.is_some());
            let (Some(a), Some(t)) = (a, t) else { continue };
            assert!(length(&t) <= length(&a) + 1e-9);
            assert!(t.windows(2).all(|w| grid.sees(w[0], w[1])));
        }
        let open = OccupancyGrid::new(10, 10).unwrap();
        assert_eq!(theta_star(&open, [0, 0], [9, 4]).unwrap(), [[0, 0], [9, 4]]);
    }

    #[test]
    fn enclosed_goals_and_occupied_ends_have_no_path() {
        let grid = OccupancyGrid::drawn(&["..#.", "..#.", "..#."]).unwrap();
        assert_eq!(a_star(&grid, [0, 0], [3, 0]), None);
        assert_eq!(theta_star(&grid, [0, 0], [2, 0]), None);
        assert_eq!(a_star(&grid, [9, 9], [0, 0]), None);
        assert!(OccupancyGrid::new(0, 3).is_none() && OccupancyGrid::new(usize::MAX, 2).is_none());
    }
}
