//! Parameters of the solver, each with its reason. `docs/physics.md` describes their effects.

/// Stiffness of contacts, as natural frequency (Hz) and damping ratio. A wall of 20 rows of boxes sinks by 60 mm with
/// rapier's defaults, and by 4 mm with these.
pub const CONTACT_SOFTNESS: (f64, f64) = (120.0, 5.0);

/// Stiffness of contacts with fixed bodies, as natural frequency (Hz) and damping ratio.
pub const STATIC_CONTACT_SOFTNESS: (f64, f64) = (240.0, 5.0);

/// Maximum natural frequency of a contact, as a fraction of the sub-step rate; twice as much with fixed bodies. At a
/// fraction of 0.3, ten stacked boxes do not move; at 0.6, they rock indefinitely.
pub const MAX_CONTACT_FREQUENCY_SHARE: f64 = 0.15;

/// Stiffness of joints, as natural frequency (Hz) and damping ratio. With rapier's defaults (1 MHz, 1), a joint
/// corrects its whole error in each sub-step; at steps of 10 ms, a two-wheeled robot then chatters about its caster and
/// drifts by 70 mm in 4 m. With these values, a joint corrects about 40 %, the robot stands still, and the two sides of
/// a joint stay within 0.5 mm of each other. Half the frequency, or a third of the damping ratio, would also work.
pub const JOINT_SOFTNESS: (f64, f64) = (400.0, 5.0);

/// Mass ratio of the two bodies of a joint above which iterations are added.
pub const UNEVEN_MASS_RATIO: f64 = 32.0;

/// Maximum number of iterations added for one joint. A weight at the end of a light pole would need hundreds.
pub const MAX_ADDED_ITERATIONS: f64 = 60.0;

/// Iterations added for a driven joint that carries other joints: without them, a car with steered wheels creeps at 3
/// mm/s.
pub const CARRIER_ITERATIONS: usize = 6;

/// Damping of motors, N m s/rad or N s/m. A motor below its limit misses its speed by its load divided by this: 1e-6
/// rad/s at 1000 N m. It acts like a hard constraint, but remains well within the range of f64.
pub const MOTOR_DAMPING: f64 = 1e9;

/// A speed that no joint reaches, rad/s or m/s. A motor with this target is therefore always at its limit.
pub const UNREACHABLE_SPEED: f64 = 1e6;

/// Time constant of a position drive near its target, s: it covers 1 - 1/e of the remaining distance in this time,
/// unless limited by its maximum velocity. V-REP's controller has the same time constant: P = 0.1 at steps of 5 ms.
pub const SETTLE_TIME: f64 = 0.05;

/// Maximum motion of a joint in a sub-step before sub-steps are halved, rad or m.
pub const MAX_SUBSTEP_MOTION: f64 = 0.005;

/// Time for which sub-steps remain halved afterwards, s: longer than half a swing of a 50 m pendulum.
pub const HALVED_SUBSTEPS_TIME_S: f64 = 10.0;

/// Mechanisms are considered to be at rest, and sub-steps are no longer halved, once no joint has been faster than this
/// fraction of the speed at which halving begins, for at least `REST_TIME_S` (s). A swing is also slow at its turning
/// points, but only briefly.
pub const REST_SPEED_SHARE: f64 = 0.05;

/// Time for which all mechanisms must be that slow, s.
pub const REST_TIME_S: f64 = 1.0;
