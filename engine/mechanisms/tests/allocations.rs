//! Counts allocations: after initialisation, steps and dynamics must not allocate memory.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use tatu_mechanisms::{DofDrive, Dynamics, ForceBound, TreeDrives, TreeSolver};

#[allow(dead_code, reason = "shared with the other tests")]
#[path = "mechanisms/robots.rs"]
mod robots;

struct CountingAllocator;

thread_local! {
    /// Number of allocations on this thread; the test harness may allocate on others at any time.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is forwarded unchanged to the system allocator.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller guarantees the requirements of `alloc`, which are the same.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer was returned by `alloc` above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

#[test]
fn steps_and_dynamics_do_not_allocate() {
    let robot = robots::load("talos");
    let tree = &robot.tree;
    let n = tree.velocities();
    let mut state = robot.state.clone();
    let mut drives = TreeDrives::new(tree);
    for d in 6..n {
        let bound = if d % 2 == 0 { ForceBound::force(4.0) } else { ForceBound::motor(8.0, 3.0) };
        drives.drive[d] = DofDrive::Velocity { target: 0.1, bound };
    }
    let (mut solver, mut dynamics, mut out) = (TreeSolver::new(tree), Dynamics::new(tree), vec![0.0; n]);
    let zeros = vec![0.0; n];
    let before = ALLOCATIONS.get();
    for _ in 0..200 {
        solver.step(&mut state, tree, &drives, robots::gravity(), 1.25e-3).unwrap();
        dynamics.update(tree, &state).unwrap();
        dynamics.forward(tree, &zeros, robots::gravity(), &mut out).unwrap();
        dynamics.energy(tree, robots::gravity()).unwrap();
    }
    assert_eq!(ALLOCATIONS.get(), before);
}
