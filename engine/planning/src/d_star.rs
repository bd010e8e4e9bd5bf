//! D* Lite, a planner for grids that become known on the way: S. Koenig and M. Likhachev, "D* Lite" (2002).

use std::{cmp::Reverse, collections::BinaryHeap};

use crate::grid::{Cell, OccupancyGrid, cell_distance, step_distance};

/// The order in which cells are updated: by their key, then by their number.
type Key = (u64, u64, usize);

/// Plans from a start that moves to a goal that stays, and repairs the plan when cells change.
///
/// ```
/// use tatu_planning::{DStarLite, OccupancyGrid};
///
/// let mut planner = DStarLite::new(OccupancyGrid::new(5, 3).unwrap(), [0, 1], [4, 1]).unwrap();
/// assert_eq!(planner.path().unwrap().len(), 5);
/// planner.move_to([1, 1]);
/// planner.set([2, 1], true);
/// assert!(planner.path().unwrap().contains(&[3, 0]));
/// ```
#[derive(Debug, Clone)]
pub struct DStarLite {
    grid: OccupancyGrid,
    start: Cell,
    goal: usize,
    /// Costs to the goal, and those that follow from the neighbours.
    costs: Vec<f64>,
    ahead: Vec<f64>,
    open: BinaryHeap<Reverse<Key>>,
    /// The key with which a cell is in the queue; other entries are obsolete.
    queued: Vec<Option<(u64, u64)>>,
    /// How far the start has moved since the first plan, by which keys have become too small.
    moved: f64,
    last: Cell,
}

impl DStarLite {
    /// Returns a planner, or `None` if start or goal is outside of the grid.
    pub fn new(grid: OccupancyGrid, start: Cell, goal: Cell) -> Option<Self> {
        let inside = |c: Cell| c[0] < grid.columns() && c[1] < grid.rows();
        if !inside(start) || !inside(goal) {
            return None;
        }
        let (cells, goal) = (grid.columns() * grid.rows(), grid.index(goal));
        let mut planner = DStarLite {
            grid,
            start,
            goal,
            costs: vec![f64::INFINITY; cells],
            ahead: vec![f64::INFINITY; cells],
            open: BinaryHeap::new(),
            queued: vec![None; cells],
            moved: 0.0,
            last: start,
        };
        planner.ahead[goal] = 0.0;
        planner.enqueue(goal);
        Some(planner)
    }

    /// Moves the start; a cell outside of the grid is ignored.
    pub fn move_to(&mut self, start: Cell) {
        if start[0] < self.grid.columns() && start[1] < self.grid.rows() {
            self.start = start;
        }
    }

    /// Marks a cell as occupied or free; cells outside are ignored.
    pub fn set(&mut self, cell: Cell, occupied: bool) {
        let inside = cell[0] < self.grid.columns() && cell[1] < self.grid.rows();
        if !inside || self.grid.is_free(cell) != occupied {
            return;
        }
        self.moved += step_distance(self.last, self.start);
        self.last = self.start;
        self.grid.set(cell, occupied);
        // Ways past its corners change, too, but only between its neighbours.
        self.update(self.grid.index(cell));
        let around: Vec<Cell> = self.grid.around(cell).collect();
        around.into_iter().for_each(|near| self.update(self.grid.index(near)));
    }

    /// Returns the grid as it is known.
    pub fn grid(&self) -> &OccupancyGrid {
        &self.grid
    }

    /// Returns the shortest path by steps to neighbours, with both ends, or `None` if there is none.
    pub fn path(&mut self) -> Option<Vec<Cell>> {
        self.repair();
        let mut at = self.start;
        if !self.costs[self.grid.index(at)].is_finite() || !self.grid.is_free(at) {
            return None;
        }
        let mut path = vec![at];
        while self.grid.index(at) != self.goal {
            let ways = self.grid.around(at).filter(|n| self.grid.is_passable(at, *n));
            let ways = ways.map(|n| (cell_distance(at, n) + self.costs[self.grid.index(n)], n));
            let (cost, next) = ways.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
            if !cost.is_finite() || path.len() > self.costs.len() {
                return None;
            }
            path.push(next);
            at = next;
        }
        Some(path)
    }

    fn key(&self, i: usize) -> (u64, u64) {
        let least = self.costs[i].min(self.ahead[i]);
        let first = least + step_distance(self.start, self.grid.cell(i)) + self.moved;
        // The bits of numbers that are not negative are ordered as the numbers are.
        (first.to_bits(), least.to_bits())
    }

    fn enqueue(&mut self, i: usize) {
        let key = self.key(i);
        self.queued[i] = Some(key);
        self.open.push(Reverse((key.0, key.1, i)));
    }

    /// Computes the cost of a cell from its neighbours.
    fn update(&mut self, i: usize) {
        if i != self.goal {
            let cell = self.grid.cell(i);
            let ways = self.grid.around(cell).filter(|n| self.grid.is_passable(cell, *n));
            let ways = ways.map(|n| cell_distance(cell, n) + self.costs[self.grid.index(n)]);
            self.ahead[i] = ways.fold(f64::INFINITY, f64::min);
        }
        self.queued[i] = None;
        if self.costs[i] != self.ahead[i] {
            self.enqueue(i);
        }
    }

    fn repair(&mut self) {
        let start = self.grid.index(self.start);
        while let Some(Reverse((a, b, i))) = self.open.peek().copied() {
            if self.queued[i] != Some((a, b)) {
                self.open.pop();
                continue;
            }
            if (a, b) >= self.key(start) && self.ahead[start] == self.costs[start] {
                return;
            }
            self.open.pop();
            self.queued[i] = None;
            if (a, b) < self.key(i) {
                self.enqueue(i);
                continue;
            }
            let around: Vec<Cell> = self.grid.around(self.grid.cell(i)).collect();
            if self.costs[i] > self.ahead[i] {
                self.costs[i] = self.ahead[i];
            } else {
                self.costs[i] = f64::INFINITY;
                self.update(i);
            }
            around.into_iter().for_each(|near| self.update(self.grid.index(near)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{grid::a_star, random::Random};

    fn length(path: &[Cell]) -> f64 {
        path.windows(2).map(|w| cell_distance(w[0], w[1])).sum()
    }

    #[test]
    fn repaired_paths_are_as_short_as_new_ones() {
        let mut random = Random::new(6);
        for _ in 0..20 {
            let goal = [24, 14];
            let mut planner = DStarLite::new(OccupancyGrid::new(25, 15).unwrap(), [0, 0], goal).unwrap();
            let mut at = [0, 0];
            for _ in 0..20 {
                for _ in 0..12 {
                    let cell = [random.index(25), random.index(15)];
                    if cell != at && cell != goal {
                        planner.set(cell, random.unit() < 0.6);
                    }
                }
                let (own, fresh) = (planner.path(), a_star(planner.grid(), at, goal));
                assert_eq!(own.is_some(), fresh.is_some());
                if let (Some(own), Some(fresh)) = (own, fresh) {
                    assert!((length(&own) - length(&fresh)).abs() < 1e-9);
                    at = own[1.min(own.len() - 1)];
                    planner.move_to(at);
                }
            }
        }
    }
}
