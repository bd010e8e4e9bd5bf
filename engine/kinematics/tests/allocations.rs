//! Counts allocations: a solver that has been created must not allocate memory, whatever it finds.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use nalgebra::{Isometry3, Vector3};
use tatu_kinematics::{Goal, JointType, Linkage, ReachSettings, ReachSolver};

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
fn solutions_and_reasons_do_not_allocate() {
    let mut arm = Linkage::default();
    let mut last = None;
    for x in [0.0, 0.5, 0.4] {
        let joint = arm.add_joint(last, Isometry3::translation(x, 0.0, 0.0), JointType::Revolute);
        arm.joint_mut(joint).expect("the joint was just added").limits = Some([-1.5, 1.5]);
        last = Some(joint);
    }
    let tip = arm.add_frame(last, Isometry3::translation(0.3, 0.0, 0.0));
    let mut solver = ReachSolver::new(&arm, &[tip]).expect("the arm has revolute joints");
    let start = [0.1, 0.2, 0.3];
    let goals = [[0.6, 0.5], [2.0, 0.0], [-0.8, 0.1]].map(|[x, y]| Goal::position(Vector3::new(x, y, 0.0)));
    let before = ALLOCATIONS.get();
    let mut found = 0;
    for goal in goals {
        let settings = ReachSettings { posture: Some(&start), ..ReachSettings::from(&start) };
        found += usize::from(solver.solve(&[goal], &settings, &mut |_| None).is_ok());
    }
    assert_eq!(ALLOCATIONS.get(), before);
    assert_eq!(found, 1);
}
