//! Counts allocations: after initialisation, steps and dynamics must not allocate memory.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use tatu_mechanisms::{Bound, Drive, Drives, Dynamics, Solver};

#[allow(dead_code, reason = "shared with the other tests")]
#[path = "mechanisms/robots.rs"]
mod robots;

struct Counting;

thread_local! {
    /// Number of allocations on this thread; the test harness may allocate on others at any time.
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is forwarded unchanged to the system allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        // SAFETY: the caller guarantees the requirements of `alloc`, which are the same.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer was returned by `alloc` above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn steps_and_dynamics_allocate_nothing() {
    let robot = robots::load("talos");
    let tree = &robot.tree;
    let n = tree.velocities();
    let mut state = robot.state.clone();
    let mut drives = Drives::new(tree);
    for d in 6..n {
        let bound = if d % 2 == 0 { Bound::force(4.0) } else { Bound::motor(8.0, 3.0) };
        drives.drive[d] = Drive::Velocity { target: 0.1, bound };
    }
    let (mut solver, mut dynamics, mut out) = (Solver::new(tree), Dynamics::new(tree), vec![0.0; n]);
    let zeros = vec![0.0; n];
    let before = COUNT.get();
    for _ in 0..200 {
        solver.step(&mut state, tree, &drives, robots::gravity(), 1.25e-3).unwrap();
        dynamics.update(tree, &state).unwrap();
        dynamics.forward(tree, &zeros, robots::gravity(), &mut out).unwrap();
        dynamics.energy(tree, robots::gravity()).unwrap();
    }
    assert_eq!(COUNT.get(), before);
}
