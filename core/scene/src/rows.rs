//! The table of the core's properties, with one row per property. Scene files, `--set`, builders, scripts and services
//! all use it.

use tatu_plugin_api::{abi::*, safe::Value};

use crate::object::{LIGHT_FORMS, PRIMITIVES};

/// The objects that have a property.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// The world itself.
    World,
    /// Every object.
    Any,
    /// Objects of one kind, a `TATU_KIND_*` constant.
    Kind(i32),
}

/// The time at which a change takes effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// Immediately.
    Live,
    /// At the next stage, when bodies are recreated.
    Rebuilds,
    /// Never: the property is read-only.
    ReadOnly,
}

/// A row of the table, which describes one property.
#[derive(Debug, Clone, Copy)]
pub struct RowInfo {
    /// Key, such as "joint.position".
    pub key: &'static str,
    /// The objects that have the property.
    pub of: Of,
    /// Type of the value, `TATU_BOOL` to `TATU_OBJECT`.
    pub kind: u32,
    /// Required number of elements of an array; 0 if any number is allowed.
    pub count: u32,
    /// Unit of the value, if it has one; `|` separates the units for revolute and prismatic joints.
    pub unit: Option<&'static str>,
    /// The time at which a change takes effect.
    pub change: Change,
    /// Allowed values of a string; if empty, any string is allowed.
    pub choices: &'static [&'static str],
    /// Description in one sentence, with the default value.
    pub text: &'static str,
}

macro_rules! rows {
    ($($name:ident $key:literal $of:expr, $kind:ident $count:literal $unit:expr, $change:ident $choices:expr, $text:literal;)*) => {
        /// The core's properties by name. The discriminant of each is its interned key.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        #[repr(u32)]
        #[allow(missing_docs, reason = "the table describes each property")]
        pub enum Row { None = 0, $($name),* }

        /// All properties, in the order of [`Row`]. The first entry is a placeholder, because no key is 0.
        pub static ROWS: &[RowInfo] = &[
            RowInfo { key: "", of: Of::World, kind: TATU_NIL, count: 0, unit: None, change: Change::ReadOnly, choices: &[], text: "" },
            $(RowInfo { key: $key, of: $of, kind: $kind, count: $count, unit: $unit, change: Change::$change, choices: $choices, text: $text }),*
        ];

        const BY_NUMBER: &[Row] = &[Row::None, $(Row::$name),*];
    };
}

const SHAPE: Of = Of::Kind(TATU_KIND_SHAPE);
const JOINT: Of = Of::Kind(TATU_KIND_JOINT);
const DUMMY: Of = Of::Kind(TATU_KIND_DUMMY);
const FORCE_SENSOR: Of = Of::Kind(TATU_KIND_FORCE_SENSOR);
const SENSOR: Of = Of::Kind(TATU_KIND_SENSOR);
const ACTUATOR: Of = Of::Kind(TATU_KIND_ACTUATOR);
const GRAPH: Of = Of::Kind(TATU_KIND_GRAPH);
const SCRIPT: Of = Of::Kind(TATU_KIND_SCRIPT);
const CAMERA: Of = Of::Kind(TATU_KIND_CAMERA);
const LIGHT: Of = Of::Kind(TATU_KIND_LIGHT);
const PATH: Of = Of::Kind(TATU_KIND_PATH);
const ANY: Of = Of::Any;
const WORLD: Of = Of::World;
const M: Option<&str> = Some("m");
const RAD: Option<&str> = Some("rad");
const FREE: &[&str] = &[];
const COLLIDE: &[&str] = &["same", "box", "sphere", "cylinder", "capsule"];

rows! {
    Alias "object.alias" ANY, TATU_TEXT 0 None, Live FREE, "Name of the object in paths; siblings can share it.";
    Name "object.name" ANY, TATU_TEXT 0 None, Live FREE, "Unique name of the object: the alias, followed by `#n` on copies.";
    Path "object.path" ANY, TATU_TEXT 0 None, ReadOnly FREE, "Path of the object in the tree of objects.";
    Kind "object.kind" ANY, TATU_TEXT 0 None, ReadOnly FREE, "Kind of the object.";
    Parent "object.parent" ANY, TATU_OBJECT 0 None, Live FREE, "Parent of the object; a change preserves the pose in the world.";
    Position "object.position" ANY, TATU_F64S 3 M, Live FREE, "Position in the parent's frame; default 0 0 0.";
    Quaternion "object.quaternion" ANY, TATU_F64S 4 None, Live FREE, "Orientation in the parent's frame, x y z w.";
    Orientation "object.orientation" ANY, TATU_F64S 3 RAD, Live FREE, "Orientation in the parent's frame: intrinsic rotations about x, then y, then z.";
    Pose "object.pose" ANY, TATU_F64S 7 None, Live FREE, "Position and quaternion in the parent's frame.";
    WorldPose "object.world_pose" ANY, TATU_F64S 7 None, Live FREE, "Position and quaternion in the world frame.";
    Twist "object.twist" ANY, TATU_F64S 6 None, ReadOnly FREE, "Linear velocity, m/s, then angular velocity, rad/s, along the axes of the world; for a dynamic shape, the velocity of its centre of mass.";
    LocalTwist "object.local_twist" ANY, TATU_F64S 6 None, ReadOnly FREE, "The velocities of `object.twist` along the object's own axes.";
    ModelBase "object.model_base" ANY, TATU_BOOL 0 None, Live FREE, "Whether the object is the base of a model; default false.";
    Visible "object.visible" ANY, TATU_BOOL 0 None, Live FREE, "Whether pictures show the object; default true.";
    Layer "object.layer" ANY, TATU_I64 0 None, Live FREE, "Layers that the object belongs to, one bit each; default 1.";
    Notes "object.data" ANY, TATU_MAP 0 None, Live FREE, "Custom data: strings by tag, for scripts and plugins; a stop preserves the data, except for tags that begin with a control character; default none.";
    Drive "object.drive" ANY, TATU_MAP 0 None, Live FREE, "Wheel drive of the robot whose base the object is, for clients that steer the robot: type (differential, ackermann, omni), joints, steering, radius, track, wheelbase, axle, angles; setting an empty table removes it; default none.";
    Primitive "shape.primitive" SHAPE, TATU_TEXT 0 None, Rebuilds PRIMITIVES, "Form of the shape; default box.";
    Size "shape.size" SHAPE, TATU_F64S 3 M, Rebuilds FREE, "Full extents along x, y, z; cylinders and capsules use x as the diameter and z as the length; a sphere with different extents is an ellipsoid; default 0.1 each.";
    Mesh "shape.mesh" SHAPE, TATU_I64 0 None, Rebuilds FREE, "Number of the shape's mesh, from 1, for the primitive `mesh`.";
    Surface "shape.surface" SHAPE, TATU_LIST 0 None, Rebuilds FREE, "Points and triangles of the mesh: a list of x y z, a list of three point indices per triangle, from 0, and, for a texture with the mapping `mesh`, a list of two image coordinates per point; setting this property makes the shape a mesh.";
    Convex "shape.convex" SHAPE, TATU_BOOL 0 None, Rebuilds FREE, "Whether the mesh is replaced by its convex hull; default false.";
    Parts "shape.parts" SHAPE, TATU_LIST 0 None, Rebuilds FREE, "Parts of a compound: primitive, size, position, orientation or quaternion, color, texture, friction; mesh and convex for the primitive `mesh`.";
    Texture "shape.texture" SHAPE, TATU_MAP 0 None, Rebuilds FREE, "Texture: image, mapping (plane, cylinder, sphere, box, mesh), size, position, orientation or quaternion, repeat, smooth, blend (modulate, decal, add); setting an empty table removes it; default none.";
    Color "shape.color" SHAPE, TATU_F64S 3 None, Live FREE, "Red, green, blue, 0 to 1; default 0.7 each.";
    Mass "shape.mass" SHAPE, TATU_F64 0 Some("kg"), Rebuilds FREE, "Mass; default: 1000 kg/m^3 times the volume; of a mesh that is not closed, the volume of its convex hull.";
    Inertia "shape.inertia" SHAPE, TATU_F64S 0 Some("kg m^2"), Rebuilds FREE, "Inertia about the centre of mass: 3 (xx yy zz) or 9 by rows; default: that of the form at uniform density about this point.";
    Com "shape.com" SHAPE, TATU_F64S 3 M, Rebuilds FREE, "Centre of mass in the shape's frame; default: that of the form at uniform density.";
    Dynamic "shape.dynamic" SHAPE, TATU_BOOL 0 None, Rebuilds FREE, "Whether forces move the shape; default false.";
    Respondable "shape.respondable" SHAPE, TATU_BOOL 0 None, Rebuilds FREE, "Whether the shape collides with other shapes; default false.";
    RespondableMask "shape.respondable_mask" SHAPE, TATU_I64 0 None, Rebuilds FREE, "Mask of the shapes that the shape collides with: low byte for shapes in the same tree, high byte for others; default 65535.";
    Friction "shape.friction" SHAPE, TATU_F64 0 None, Rebuilds FREE, "Friction coefficient; `scene.friction_rule` combines the coefficients of a pair, by default as their product; default 1.";
    Restitution "shape.restitution" SHAPE, TATU_F64 0 None, Rebuilds FREE, "Restitution, 0 to 1; default 0.";
    Detectable "shape.detectable" SHAPE, TATU_BOOL 0 None, Rebuilds FREE, "Whether beams detect the shape; default true, false for planes.";
    DetectableMask "shape.detectable_mask" SHAPE, TATU_I64 0 None, Rebuilds FREE, "Mask of the beams that detect the shape, if it is detectable: those that have a bit in common with the mask (TATU_WAVES_* in tatu.h); default 65535.";
    JointSolverUsed "shape.joint_solver_used" SHAPE, TATU_TEXT 0 None, ReadOnly FREE, "Solver of the mechanism that the shape belongs to, and the reason, such as `tree: its own joint_solver`; empty if the shape does not belong to a mechanism.";
    JointSolver "shape.joint_solver" SHAPE, TATU_TEXT 0 None, Rebuilds &["auto", "reduced", "impulse", "tree"], "Solver for the joints of a mechanism, set on its first shape, or on another of its shapes if that sets none: with `tree` and `reduced`, joints cannot come apart; `tree` is several times as fast as `reduced`, and `impulse` is cheaper but softer; mechanisms with loops, gears, screws or special surfaces use `reduced` instead of `tree`; `auto`: impulse for wheeled vehicles, otherwise tree; default auto.";
    Bullet "shape.bullet" SHAPE, TATU_BOOL 0 None, Rebuilds FREE, "Whether the shape cannot pass through other moving shapes at any speed; no shape passes through shapes that do not move; default false.";
    InitialVelocity "shape.initial_velocity" SHAPE, TATU_F64S 3 Some("m/s"), Rebuilds FREE, "Initial velocity of the centre of mass, in the world frame; default 0 0 0.";
    InitialAngularVelocity "shape.initial_angular_velocity" SHAPE, TATU_F64S 3 Some("rad/s"), Rebuilds FREE, "Initial angular velocity, in the world frame; default 0 0 0.";
    SurfaceVelocity "shape.surface_velocity" SHAPE, TATU_F64S 3 Some("m/s"), Live FREE, "Velocity of the surface relative to the shape, in the shape's frame, as of a conveyor belt; default 0 0 0.";
    FrictionAxis "shape.friction_axis" SHAPE, TATU_F64S 3 None, Live FREE, "Axis in the shape's frame along which the friction differs, as for rollers, skates and tracks; default 0 0 0: no axis.";
    FrictionAxisAngle "shape.friction_axis_angle" SHAPE, TATU_F64 0 RAD, Live FREE, "Angle by which `friction_axis` is rotated about the contact normal, which points out of the shape; if the axis is the axle of a wheel, the angle of the rollers on its rim, at any point of contact; default 0.";
    AxisFriction "shape.axis_friction" SHAPE, TATU_F64 0 None, Live FREE, "Friction coefficient of a pair along `friction_axis`; default 0.";
    RollingFriction "shape.rolling_friction" SHAPE, TATU_F64 0 M, Live FREE, "Torque against rolling per newton of normal force; the greater value of a pair applies; default 0.";
    SpinningFriction "shape.spinning_friction" SHAPE, TATU_F64 0 M, Live FREE, "Torque against spinning about the normal per newton of normal force; the greater value of a pair applies; default 0.";
    Material "shape.material" SHAPE, TATU_TEXT 0 None, Live FREE, "Name of the material, for the scene's `friction_pairs`; default: none.";
    LinearDamping "shape.linear_damping" SHAPE, TATU_F64 0 None, Rebuilds FREE, "Fraction of the velocity that the shape loses per second, as in a viscous fluid; default 0.";
    AngularDamping "shape.angular_damping" SHAPE, TATU_F64 0 None, Rebuilds FREE, "Fraction of the angular velocity that the shape loses per second; default 0.";
    CollideAs "shape.collide_as" SHAPE, TATU_TEXT 0 None, Rebuilds COLLIDE, "Form for collisions; default same: that of the shape.";
    CollideSize "shape.collide_size" SHAPE, TATU_F64S 3 M, Rebuilds FREE, "Size of the form for collisions; default: that of the shape.";
    JointType "joint.type" JOINT, TATU_TEXT 0 None, Rebuilds &["revolute", "prismatic", "spherical"], "Free motion of the joint: rotation about its z axis, translation along it, or rotation about any axis; default revolute.";
    JointMode "joint.mode" JOINT, TATU_TEXT 0 None, Rebuilds &["kinematic", "dynamic"], "Whether the joint is moved by setting its position or by physics; default dynamic.";
    Control "joint.control" JOINT, TATU_TEXT 0 None, Live &["free", "velocity", "position", "force", "callback", "spring"], "Control mode of the motor, in dynamic mode; `spring`: no motor, but the spring pulls towards the target position; `callback`: a script's callback `joint` returns the drive of each physics step; default free.";
    JointPosition "joint.position" JOINT, TATU_F64 0 Some("rad|m"), Live FREE, "Position of the joint; default 0.";
    JointRotation "joint.rotation" JOINT, TATU_F64S 4 None, Live FREE, "For a spherical joint: the rotation of the moved frame, x y z w; default 0 0 0 1.";
    JointVelocity "joint.velocity" JOINT, TATU_F64 0 Some("rad/s|m/s"), ReadOnly FREE, "Velocity of the joint.";
    TargetVelocity "joint.target_velocity" JOINT, TATU_F64 0 Some("rad/s|m/s"), Live FREE, "Target of velocity control; default 0.";
    TargetPosition "joint.target_position" JOINT, TATU_F64 0 Some("rad|m"), Live FREE, "Target of position control; default 0.";
    MaxForce "joint.max_force" JOINT, TATU_F64 0 Some("N m|N"), Live FREE, "Maximum torque or force of the motor; in force control, the torque or force that the motor exerts; default 0.";
    MaxVelocity "joint.max_velocity" JOINT, TATU_F64 0 Some("rad/s|m/s"), Live FREE, "Maximum velocity of position control; default 10.";
    Effort "joint.effort" JOINT, TATU_F64 0 Some("N m|N"), ReadOnly FREE, "Torque or force that the motor exerted in the last step; 0 if the joint connects no two bodies.";
    Gains "joint.gains" JOINT, TATU_F64S 0 None, Live FREE, "Gains P (1/s), I (1/s^2) and D of position control: the joint moves at P * error + I * integral of the error + D * derivative of the error + target velocity, limited to its maximum velocity; default: none: the error decays to 1/e in 0.05 s, without overshoot. The motor exerts its maximum force if the joint is 0.002 rad/s or m/s too slow, and less in proportion; the integral does not grow while the force or the velocity is at its limit.";
    SmoothTarget "joint.smooth_target" JOINT, TATU_BOOL 0 None, Live FREE, "Whether position control follows its target smoothly if a step consists of several physics steps: targets are control points of a quadratic spline, half a step behind, which the joint follows without further lag, and a single target is reached after two steps; otherwise the target jumps once per step. Targets set between physics steps are applied directly; default true.";
    NoLoadSpeed "joint.no_load_speed" JOINT, TATU_F64 0 Some("rad/s|m/s"), Rebuilds FREE, "Speed at which the motor has no torque left: the maximum torque falls linearly from rest to 0 at this speed; default 0: the maximum is constant.";
    Lead "joint.lead" JOINT, TATU_F64 0 M, Rebuilds FREE, "Distance along its axis per full turn, which makes a revolute joint a screw; default 0.";
    Cyclic "joint.cyclic" JOINT, TATU_BOOL 0 None, Rebuilds FREE, "Whether the joint rotates without limits; default true if it has no limits.";
    Limits "joint.limits" JOINT, TATU_F64S 2 Some("rad|m"), Rebuilds FREE, "Lowest and highest position; default: none.";
    Slip "joint.slip" JOINT, TATU_F64 0 None, Live FREE, "Speed that velocity control loses under load, (rad/s)/(N m) or (m/s)/N; default 0.";
    Damping "joint.damping" JOINT, TATU_F64 0 Some("N m s/rad|N s/m"), Rebuilds FREE, "Torque or force against the motion of the joint per rad/s or m/s; default 0.";
    DryFriction "joint.dry_friction" JOINT, TATU_F64 0 Some("N m|N"), Rebuilds FREE, "Torque or force that must be overcome before the joint moves, and that acts against its motion; default 0.";
    Armature "joint.armature" JOINT, TATU_F64 0 Some("kg m^2|kg"), Rebuilds FREE, "Inertia of the motor's rotor, reflected to the joint: the rotor's own times the square of the gear ratio; default 0.";
    Stiffness "joint.stiffness" JOINT, TATU_F64 0 Some("N m/rad|N/m"), Rebuilds FREE, "Stiffness of a spring towards the rest position, in any control mode; default 0.";
    RestPosition "joint.rest_position" JOINT, TATU_F64 0 Some("rad|m"), Live FREE, "Position at which the spring is relaxed, in any control mode except `spring`; default 0.";
    Follows "joint.follows" JOINT, TATU_TEXT 0 None, Rebuilds FREE, "Path of the joint to follow, relative to this joint: in position control and kinematic mode, this joint follows the other's position, in velocity control its velocity; default: none.";
    FollowFactor "joint.follow_factor" JOINT, TATU_F64 0 None, Live FREE, "Position or velocity of this joint per unit of that of the joint that it follows; default 1.";
    FollowOffset "joint.follow_offset" JOINT, TATU_F64 0 Some("rad|m"), Live FREE, "Position of this joint when the joint that it follows is at 0; default 0.";
    Geared "joint.geared" JOINT, TATU_BOOL 0 None, Rebuilds FREE, "Whether the joint is geared to the joint that it follows: the two move together exactly, by factor and offset, and load each other; the motor of this joint, if any, follows that of the other joint, and without a motor, this joint is driven by a share of the other's; both must be dynamic and in the same mechanism; default false.";
    FollowCurve "joint.follow_curve" JOINT, TATU_F64S 0 None, Live FREE, "Pairs of the position of the joint that this joint follows and its own position, rad or m, ascending, with linear interpolation; replaces factor and offset for positions; default: none.";
    Link "dummy.link" DUMMY, TATU_TEXT 0 None, Rebuilds FREE, "Path of another dummy, relative to this one: the shapes above both are held together so that the two dummies coincide in position and orientation (all six degrees of freedom), which closes a loop; a dummy below a static shape or below none is fixed to the world; default: none.";
    SensedForce "force_sensor.force" FORCE_SENSOR, TATU_F64S 3 Some("N"), ReadOnly FREE, "Force that the objects below the sensor exert on it, in the sensor's frame, filtered.";
    SensedTorque "force_sensor.torque" FORCE_SENSOR, TATU_F64S 3 Some("N m"), ReadOnly FREE, "Torque that the objects below the sensor exert on it, about its origin, in the sensor's frame, filtered.";
    SensedCount "force_sensor.measured" FORCE_SENSOR, TATU_BOOL 0 None, ReadOnly FREE, "Whether the sensor has measured, that is, whether it connects two shapes and a step has passed.";
    ForceFilter "force_sensor.filter" FORCE_SENSOR, TATU_TEXT 0 None, Live &["mean", "median"], "How the newest values are combined; default mean.";
    ForceSamples "force_sensor.samples" FORCE_SENSOR, TATU_I64 0 None, Live FREE, "Number of values that are combined, one for each physics step, 1 to 1000; default 1.";
    BreakForce "force_sensor.break_force" FORCE_SENSOR, TATU_F64 0 Some("N"), Live FREE, "Force above which the sensor breaks; 0: never; default 0.";
    BreakTorque "force_sensor.break_torque" FORCE_SENSOR, TATU_F64 0 Some("N m"), Live FREE, "Torque above which the sensor breaks; 0: never; default 0.";
    BreakCount "force_sensor.break_count" FORCE_SENSOR, TATU_I64 0 None, Live FREE, "Number of consecutive values that must exceed the threshold; default 1.";
    Broken "force_sensor.broken" FORCE_SENSOR, TATU_BOOL 0 None, Rebuilds FREE, "Whether the sensor is broken and no longer connects its shapes; default false.";
    SensorKind "sensor.kind" SENSOR, TATU_TEXT 0 None, ReadOnly FREE, "Id of the sensor's kind.";
    Explicit "sensor.explicit" SENSOR, TATU_BOOL 0 None, Live FREE, "Whether the sensor measures only on request; sensors that measure in each physics step ignore this; default false.";
    Preset "sensor.preset" SENSOR, TATU_TEXT 0 None, Live FREE, "Name of a preset of the sensor's kind; setting it applies all settings of the preset; default: none.";
    Rate "sensor.rate" SENSOR, TATU_F64 0 Some("Hz"), Live FREE, "Maximum rate at which the sensor measures; 0: in each step; default 0.";
    Noise "sensor.noise" SENSOR, TATU_TEXT 0 None, Live FREE, "Noise of the sensor's fields, as TOML; setting it changes only the fields that the value contains; empty or `none` removes all noise; default: none.";
    SensorTargets "sensor.targets" SENSOR, TATU_LIST 0 None, Live FREE, "Paths of the objects that the sensor detects, relative to the sensor, each with all descendants; default: all.";
    SensorIgnored "sensor.ignored" SENSOR, TATU_LIST 0 None, Live FREE, "Paths of objects that the sensor does not detect, relative to the sensor, each with all descendants; if entries of both lists are nested, the innermost takes precedence; default: none.";
    SensorMeasured "sensor.measured" SENSOR, TATU_I64 0 None, ReadOnly FREE, "Number of measurements since the start, or since the reading was reset.";
    SensorBeams "sensor.beams" SENSOR, TATU_I64 0 None, ReadOnly FREE, "Number of beams that the sensor emits; a volume is one beam.";
    ActuatorKind "actuator.kind" ACTUATOR, TATU_TEXT 0 None, ReadOnly FREE, "Id of the actuator's kind.";
    GraphExplicit "graph.explicit" GRAPH, TATU_BOOL 0 None, Live FREE, "Whether the graph records only on request; default false: it records at the end of each step.";
    GraphBuffer "graph.buffer" GRAPH, TATU_I64 0 None, Live FREE, "Number of samples of each stream that the graph stores, 1 to 1000000; the oldest samples are discarded; default 10000.";
    GraphStreams "graph.streams" GRAPH, TATU_LIST 0 None, Live FREE, "Streams that the graph records: name, unit, color, of, data, transform, factor, offset, window, hidden; default: nothing.";
    GraphCurves "graph.curves" GRAPH, TATU_LIST 0 None, Live FREE, "Curves of one stream against another: name, x, y, z, unit, color; default: none.";
    CameraAngle "camera.angle" CAMERA, TATU_F64 0 RAD, Live FREE, "Angle of view along the longer side of the picture; default 60 degrees.";
    CameraOrtho "camera.ortho_size" CAMERA, TATU_F64 0 M, Live FREE, "Width of the view in parallel projection, along the longer side; 0: perspective; default 0.";
    CameraNear "camera.near" CAMERA, TATU_F64 0 M, Live FREE, "Distance of the near clipping plane; default 0.05.";
    CameraFar "camera.far" CAMERA, TATU_F64 0 M, Live FREE, "Distance of the far clipping plane; default 1000.";
    LightForm "light.form" LIGHT, TATU_TEXT 0 None, Live LIGHT_FORMS, "Directions of the light: everywhere, in a cone along its z axis, or parallel to its z axis; default omni.";
    LightOn "light.on" LIGHT, TATU_BOOL 0 None, Live FREE, "Whether the light is on; default true.";
    LightColor "light.color" LIGHT, TATU_F64S 3 None, Live FREE, "Red, green, blue of the light, 0 to 1; default 0.5 each.";
    LightAngle "light.angle" LIGHT, TATU_F64 0 RAD, Live FREE, "Half the angle of the cone of a spotlight; default 90 degrees.";
    PathPoints "path.points" PATH, TATU_F64S 0 None, Live FREE, "Control points in the path's frame: position and quaternion x y z w, 7 numbers each; default: none.";
    PathRounding "path.rounding" PATH, TATU_F64S 0 None, Live FREE, "3 numbers for each point: the fraction of half the segment before it and after it that is rounded, 0 to 1, and the number of positions on the rounding; default: none, segments are straight.";
    PathClosed "path.closed" PATH, TATU_BOOL 0 None, Live FREE, "Whether the path returns to its first point; default false.";
    ScriptLanguage "script.language" SCRIPT, TATU_TEXT 0 None, ReadOnly FREE, "Language of the script.";
    ScriptDialect "script.dialect" SCRIPT, TATU_TEXT 0 None, ReadOnly FREE, "Dialect chosen for the script.";
    ScriptKind "script.kind" SCRIPT, TATU_TEXT 0 None, ReadOnly FREE, "child, customization, main, addon or sandbox.";
    ScriptName "script.name" SCRIPT, TATU_TEXT 0 None, ReadOnly FREE, "File that the script was read from, or a name for messages.";
    ScriptCalls "script.calls" SCRIPT, TATU_I64 0 None, ReadOnly FREE, "Number of calls of the script's callbacks.";
    ScriptInstructions "script.instructions" SCRIPT, TATU_I64 0 None, ReadOnly FREE, "Number of instructions of its language that the script has executed.";
    Time "scene.time" WORLD, TATU_F64 0 Some("s"), ReadOnly FREE, "Simulation time.";
    Dt "scene.dt" WORLD, TATU_F64 0 Some("s"), ReadOnly FREE, "Length of a step; default 0.05.";
    PhysicsDt "scene.physics_dt" WORLD, TATU_F64 0 Some("s"), ReadOnly FREE, "Maximum length of a physics step; a step is divided evenly; default 0.005.";
    PhysicsSubsteps "scene.physics_substeps" WORLD, TATU_I64 0 None, ReadOnly FREE, "Sub-steps of a physics step in which velocities are solved, 1 to 64; default 4.";
    Sleep "scene.sleep" WORLD, TATU_BOOL 0 None, ReadOnly FREE, "Whether bodies at rest can sleep until they are touched; default true.";
    FrictionRule "scene.friction_rule" WORLD, TATU_TEXT 0 None, ReadOnly &["product", "mean", "least", "greatest"], "How the friction of a pair is computed from both shapes' coefficients: their product, mean, or the least or greatest of the two; default product.";
    SceneJointSolver "scene.joint_solver" WORLD, TATU_TEXT 0 None, ReadOnly &["auto", "reduced"], "The solver of mechanisms whose own `joint_solver` is `auto`: with `reduced`, those that `auto` would solve as trees of links use reduced form; default auto.";
    FrictionPairs "scene.friction_pairs" WORLD, TATU_LIST 0 None, ReadOnly FREE, "Friction by material, in place of the shapes' own: lists of two materials, friction, and optionally restitution; default: none.";
    ContactSpring "scene.contact_spring" WORLD, TATU_F64S 2 None, ReadOnly FREE, "Natural frequency, Hz, and damping ratio of contacts, at most what a sub-step can resolve (0.15 of its rate, 0.3 with objects that do not move); default 120 Hz (240 Hz) and 5.";
    Step "scene.step" WORLD, TATU_I64 0 None, ReadOnly FREE, "Index of the step, from 0.";
    Gravity "scene.gravity" WORLD, TATU_F64S 3 Some("m/s^2"), Live FREE, "Gravity; default 0 0 -9.81.";
    Origin "scene.origin" WORLD, TATU_F64S 3 None, ReadOnly FREE, "Position of the world's origin on Earth: latitude and longitude in rad (WGS 84), height above the ellipsoid in m; x points east, y north; default 0 0 0.";
    Seed "scene.seed" WORLD, TATU_I64 0 None, ReadOnly FREE, "The seed of all random numbers; default 0.";
    Allow "scene.allow" WORLD, TATU_TEXT 0 None, ReadOnly FREE, "What scripts may access outside the run, separated by commas: `exec` other programs, `native` libraries, `net=HOST:PORT` sockets; a `*` means any host or port.";
    SceneFile "scene.file" WORLD, TATU_TEXT 0 None, ReadOnly FREE, "The file of the scene.";
    SceneNotes "scene.notes" WORLD, TATU_LIST 0 None, ReadOnly FREE, "Notes about the reading of the scene, such as parts that an importer left out: a list of strings.";
    WorldNotes "scene.data" WORLD, TATU_MAP 0 None, Live FREE, "Custom data of the world: strings by tag, as in `object.data`; default none.";
    Running "scene.running" WORLD, TATU_BOOL 0 None, ReadOnly FREE, "Whether the world has been started.";
    ClockTime "scene.clock" WORLD, TATU_F64 0 Some("s"), ReadOnly FREE, "Time that clocks show, from the start: simulation time, or in a real-time run the real time up to this step.";
    Epoch "scene.epoch" WORLD, TATU_I64 0 Some("s"), ReadOnly FREE, "Date of the start, in seconds since the beginning of 1970: the first second of 2015, or in a real-time run the real date.";
    Stopping "scene.stopping" WORLD, TATU_BOOL 0 None, ReadOnly FREE, "Whether the run is in one of its last two passes.";
    Phase "scene.phase" WORLD, TATU_I64 0 None, ReadOnly FREE, "0 stopped, 1 first pass, 2 running, 3 last before a pause, 4 paused, 5 first after a pause, 6 stopping, 7 last pass.";
}

impl Row {
    /// Returns the property with an interned key, or `Row::None` if the key is not one of the core's.
    pub fn of(prop: u32) -> Row {
        BY_NUMBER.get(prop as usize).copied().unwrap_or(Row::None)
    }
    /// Returns the property's description.
    pub fn info(self) -> &'static RowInfo {
        &ROWS[self as usize]
    }
}

impl RowInfo {
    /// Returns whether objects of a kind have the property, or whether the world has it if `kind` is `None`.
    pub fn is_of(&self, kind: Option<i32>) -> bool {
        match (self.of, kind) {
            (Of::World, None) | (Of::Any, Some(_)) => true,
            (Of::Kind(k), Some(kind)) => k == kind,
            _ => false,
        }
    }

    /// Returns the part of the key after the dot.
    pub fn short(&self) -> &'static str {
        self.key.split_once('.').map_or(self.key, |(_, s)| s)
    }

    /// Returns the property in the form in which plugins declare their parameters.
    pub fn param(&self) -> tatu_plugins::Declared {
        tatu_plugins::Declared {
            key: self.short().to_owned(),
            kind: self.kind,
            count: self.count,
            flags: if self.change == Change::ReadOnly { TATU_PARAM_READ_ONLY } else { 0 },
            unit: self.unit.map(str::to_owned),
            lowest: f64::NEG_INFINITY,
            highest: f64::INFINITY,
            fallback: Value::Nil,
            unreadable_default: false,
            choices: self.choices.iter().map(|s| (*s).to_owned()).collect(),
            keys: Vec::new(),
            keys_cut: false,
            text: self.text.to_owned(),
        }
    }
}

/// Returns the properties of objects of a kind, or those of the world if `kind` is `None`.
pub fn rows_of(kind: Option<i32>) -> impl Iterator<Item = &'static RowInfo> {
    ROWS.iter().skip(1).filter(move |r| r.is_of(kind))
}

/// Kinds of objects by name, as used in scene files and by builders.
pub const KINDS: &[(&str, i32)] = &[
    ("shape", TATU_KIND_SHAPE),
    ("joint", TATU_KIND_JOINT),
    ("dummy", TATU_KIND_DUMMY),
    ("sensor", TATU_KIND_SENSOR),
    ("actuator", TATU_KIND_ACTUATOR),
    ("force_sensor", TATU_KIND_FORCE_SENSOR),
    ("graph", TATU_KIND_GRAPH),
    ("camera", TATU_KIND_CAMERA),
    ("light", TATU_KIND_LIGHT),
    ("path", TATU_KIND_PATH),
];

/// Returns the name of a kind, a `TATU_KIND_*` constant; "object" if the kind is unknown.
pub fn kind_name(kind: i32) -> &'static str {
    match kind {
        TATU_KIND_SCRIPT => "script",
        _ => KINDS.iter().find(|(_, k)| *k == kind).map_or("object", |(n, _)| n),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_page_has_every_row() {
        let page = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/properties.md");
        let page = std::fs::read_to_string(page).unwrap();
        for row in ROWS.iter().skip(1) {
            let start = format!("| `{}` |", row.key);
            let line = page.lines().find(|l| l.starts_with(&start));
            let line = line.unwrap_or_else(|| panic!("docs/reference/properties.md lacks `{}`", row.key));
            assert!(line.contains(row.text), "`{}`: the page has {line}, the row {}", row.key, row.text);
        }
    }
}
