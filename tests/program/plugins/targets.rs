//! Tests of targets and contacts as inputs of sensors and actuators.

use crate::{kit::plugin_sources::*, kit::*};

/// A sensor of each moment that reports its first target, and an actuator that reports the contacts of its mount and
/// pushes its targets with the force `(0, 0, lift)`.
const FOLLOW: &str = r#"
#include "tatu.h"
static tatu_status TATU_CALL measure(void *self, const tatu_sensor_batch *b, tatu_error *e) {
  (void)self, (void)e;
  for (uint32_t i = 0; i < b->n; i++) {
    double *place = tatu_field_of(b, i, 0), *speed = tatu_field_of(b, i, 1);
    for (uint64_t k = 0, t = b->first_target[i]; t < b->first_target[i + 1]; k++, t++) {
      place[k] = b->target[t] ? b->target_pose[7 * t + 2] : -1;
      speed[k] = b->target[t] ? b->target_twist[6 * t + 2] : -1;
      if (!b->target[t] && b->target_pose[7 * t] == b->target_pose[7 * t]) b->status[i] = TATU_ERR;
    }
    *(double *)tatu_field_of(b, i, 2) = b->time;
  }
  return TATU_OK;
}
#define FOLLOWER(Id, Flags) {.size = sizeof(tatu_sensor), .id = Id, .text = "Follows.", .inputs = TATU_IN_TARGETS, \
  .schemas = TATU_TEXTS("follow/1"), .measure = measure, .flags = Flags, .fields = TATU_FIELDS( \
    TATU_FIELD_ARRAY(TATU_ELEM_F64, TATU_DIM_TARGETS, "follow.place", "m", "Height."), \
    TATU_FIELD_ARRAY(TATU_ELEM_F64, TATU_DIM_TARGETS, "follow.speed", "m/s", "Speed upwards."), \
    TATU_FIELD(TATU_ELEM_F64, "follow.time", "s", "Time."))}
static const tatu_sensor late = FOLLOWER("late", 0), often = FOLLOWER("often", TATU_SENSOR_EVERY_PHYSICS_STEP);

static tatu_status TATU_CALL apply(void *self, const tatu_actuator_batch *b, tatu_error *e) {
  (void)self, (void)e;
  for (uint32_t i = 0; i < b->n; i++) {
    double *told = b->fields[i * b->n_fields];
    for (uint64_t c = b->first_contact[i]; c < b->first_contact[i + 1]; c++) {
      told[0] += 1;
      told[1] += b->contact[c].force * b->contact[c].normal[2] + b->friction[3 * c + 2];
    }
    for (uint64_t t = b->first_target[i]; t < b->first_target[i + 1]; t++) {
      told[2] += b->target[t] != 0;
      b->target_wrench[6 * t + 2] = b->command[i][0];
      if (b->command[i][1] > 0 && t == b->first_target[i]) b->target_wrench[6 * t] = HUGE_VAL;
    }
    if (b->command[i][1] > 1) b->target_wrench[6 * b->first_target[b->n]] = 1;
  }
  return TATU_OK;
}
#define FEELER(Id, Flags) {.size = sizeof(tatu_actuator), .id = Id, .text = "Feels.", .n_commands = 2, .apply = apply, \
  .flags = Flags, .inputs = TATU_IN_TARGETS | TATU_IN_CONTACTS, \
  .commands = TATU_PARAMS(TATU_PARAM(TATU_F64, "lift", "N", "Force.", TATU_DEFAULT_F64(0)), \
                          TATU_PARAM(TATU_F64, "fail", NULL, "How it fails.", TATU_DEFAULT_F64(0))), \
  .schemas = TATU_TEXTS("feel/1"), .fields = TATU_FIELDS( \
    TATU_FIELD_ARRAY(TATU_ELEM_F64, 3, "feel.told", NULL, "Contacts, force upwards, targets."))}
static const tatu_actuator once = FEELER("once", 0), inner = FEELER("inner", TATU_ACTUATOR_EVERY_SUBSTEP);
TATU_PLUGIN(TATU_OFFERS(TATU_SENSORS(&late, &often), TATU_ACTUATORS(&once, &inner)), .id = "org.test.follow",
            .name = "Follow", .version = "1", .licence = "MIT");
"#;

/// Creates a scene with a plate on the floor, a falling ball, and a mark half a metre above it.
fn scene(more: &str) -> TestFolder {
    let place = place(&format!(
        "[[object]]\nkind = \"shape\"\nalias = \"plate\"\nsize_m = [0.4, 0.4, 0.1]\nposition_m = [0.0, 0.0, 0.05]\n\
         dynamic = true\nrespondable = true\nmass_kg = 2.0\n\
         [[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\nsize_m = [0.2, 0.2, 0.2]\n\
         position_m = [3.0, 0.0, 9.0]\ndynamic = true\nmass_kg = 1.0\n\
         [[object]]\nkind = \"dummy\"\nalias = \"mark\"\nparent = \"ball\"\nposition_m = [0.0, 0.0, 0.5]\n{more}"
    ));
    compile(&place, "follow", FOLLOW);
    place
}

fn device(kind: &str, id: &str, more: &str) -> String {
    format!("[[object]]\nkind = \"{kind}\"\n{kind} = \"{id}\"\nalias = \"{id}\"\nparent = \"plate\"\n{more}\n")
}

#[test]
fn targets_have_the_motion_of_the_moment_of_measurement() {
    let targets = "targets = [\"/ball/mark\", \"../../floor\"]";
    let place = scene(&format!(
        "{}{}{}",
        device("sensor", "late", targets),
        device("sensor", "often", targets),
        watcher(
            "d",
            "local late, often, n = nil, nil, 0
            function sysCall_init() late, often = sim.getObject('/late'), sim.getObject('/often') end
            function sysCall_sensing()
                n = n + 1
                local t, mark = sim.getSimulationTime() + sim.getSimulationTimeStep(), sim.getObject('/mark')
                local r, p = tatu.read(late), tatu.read(often)
                assert(math.abs(r.place[1] - sim.getObjectPosition(mark)[3]) < 1e-12 and r.place[2] == 0)
                assert(math.abs(r.speed[1] - sim.getObjectVelocity(sim.getObject('/ball'))[3]) < 0.3 and r.speed[2] == 0)
                -- Free fall; the physics step has its pose in the middle.
                assert(math.abs(p.place[1] - (9.5 - 0.5 * 9.81 * p.time ^ 2)) < 0.03, p.place[1])
                assert(math.abs(p.speed[1] + 9.81 * p.time) < 0.03, p.speed[1] .. ' at ' .. p.time)
                assert(p.time < t and p.time > t - 0.01 and p.place[1] > r.place[1])
            end
            function sysCall_cleanup() assert(n >= 10) end"
        )
    ));
    place.run(&["--steps", "10"]).good();
}

#[test]
fn a_removed_target_is_missing_until_its_path_leads_to_an_object_again() {
    let place = scene(&format!(
        "{}{}",
        device("sensor", "late", "targets = [\"/ball\", \"/post\"]"),
        watcher(
            "d",
            "local late, n = nil, 0
            function sysCall_init() late = sim.getObject('/late') end
            function sysCall_actuation()
                if n == 1 then sim.removeObjects({sim.getObject('/ball')}) end
                if n == 2 then
                    local post = sim.createDummy(0.1)
                    sim.setObjectAlias(post, 'post')
                    sim.setObjectPosition(post, -1, {0, 0, 4})
                end
                if n == 3 then tatu.set(late, 'sensor.targets', {'/post', '/plate', '/post'}) end
                if n == 4 then tatu.set(late, 'sensor.targets', {}) end
            end
            function sysCall_sensing()
                n = n + 1
                local place = tatu.read(late).place
                if n == 1 then assert(place[1] > 8 and place[2] == -1) end
                if n == 2 then assert(place[1] == -1 and place[2] == -1) end
                if n == 3 then assert(place[1] == -1 and place[2] == 4) end
                if n == 4 then assert(#place == 3 and place[1] == 4 and place[3] == 4) end
                if n == 5 then assert(#place == 0) end
            end
            function sysCall_cleanup() assert(n >= 6) end"
        )
    ));
    let done = place.run(&["--steps", "6"]).good();
    let told = "there is no object `/post`, which is one of the `targets` of /plate/late";
    assert!(done.err.contains(told), "{}", done.err);
    assert!(!done.err.contains("`/ball`"), "{}", done.err);
}

#[test]
fn an_actuator_feels_the_contacts_of_its_mount_and_pushes_its_targets() {
    for id in ["once", "inner"] {
        let place = scene(&format!(
            "{}{}",
            device("actuator", id, "lift_n = 9.81\ntargets = [\"/ball/mark\", \"/floor\", \"/plate\"]"),
            watcher(
                "d",
                &format!(
                    "local n, device = 0, nil
                    function sysCall_init() device = sim.getObject('/{id}') end
                    function sysCall_sensing()
                        n = n + 1
                        local told = tatu.read(device).told
                        assert(told[3] == 3)
                        -- The ball hovers; the plate, of 2 kg, is relieved of half its weight.
                        local ball = sim.getObjectVelocity(sim.getObject('/ball'))[3]
                        assert(math.abs(ball) < 1e-9, 'the ball falls with ' .. ball .. ' m/s')
                        if n < 5 then return end
                        assert(told[1] > 0 and math.abs(told[2] - 9.81) < 0.2, told[1] .. ' contacts, ' .. told[2] .. ' N')
                    end
                    function sysCall_cleanup() assert(n >= 20) end"
                )
            )
        ));
        let done = place.run(&["--steps", "20"]).good();
        assert!(!done.err.contains("acts on nothing"), "{}", done.err);
    }
}

#[test]
fn faulty_wrenches_on_targets_switch_the_actuator_off() {
    for (fail, told) in [(1, "on target 0; expected finite numbers"), (2, "outside `target_wrench` of its batch")] {
        let place = scene(&device("actuator", "once", &format!("fail = {fail}.0\ntargets = [\"/ball\"]")));
        let done = place.run(&["--steps", "2"]);
        done.reports(&["`org.test.follow`", told]);
    }
}

#[test]
fn targets_for_other_kinds_are_refused() {
    let place = scene(&format!(
        "{}{}",
        device("actuator", "plain", ""),
        watcher(
            "d",
            "function sysCall_init()
                local ok, why = pcall(tatu.set, sim.getObject('/plain'), 'actuator.targets', {'/ball'})
                assert(not ok and why:find('the actuator kind `plain` takes no targets', 1, true), why)
                tatu.set(sim.getObject('/plain'), 'actuator.targets', {})
            end"
        )
    ));
    // The table ends before `inputs`, as that of a plugin for ABI 0.7.
    let old = "{.size = offsetof(tatu_actuator, inputs), .id = \"plain\", .text = \"Plain.\", .apply = none, \
               .inputs = TATU_IN_TARGETS}";
    let none = "static tatu_status TATU_CALL none(void *self, const tatu_actuator_batch *b, tatu_error *e) {
  (void)self, (void)b;
  return b->first_target || b->first_contact ? tatu_fail(e, TATU_ERR, \"given what it cannot know\") : TATU_OK;
}\n#define FEELER";
    compile(&place, "follow", &FOLLOW.replace("FEELER(\"once\", 0)", old).replacen("#define FEELER", none, 1));
    place.run(&["--steps", "2"]).good();
    let listed = std::fs::read_to_string(place.path().join("scene.toml")).unwrap();
    place.write("scene.toml", &listed.replace("alias = \"plain\"\n", "alias = \"plain\"\ntargets = [\"/ball\"]\n"));
    place.run(&["--steps", "1"]).refused(&["E102", "`targets`", "the actuator kind `plain` takes no targets"]);
}

#[test]
fn declarations_of_inputs_are_checked() {
    let base = place("");
    for (from, to, told) in [
        (".inputs = TATU_IN_TARGETS, ", "", "has an element per target"),
        ("TATU_IN_TARGETS | TATU_IN_CONTACTS", "TATU_IN_POSE", "requests inputs other than targets and contacts"),
    ] {
        compile(&base, "follow", &FOLLOW.replace(from, to));
        base.run(&["--steps", "1"]).good().reports(&["E303", "`org.test.follow`", told]);
    }
}

#[test]
fn runs_with_targets_are_equal_from_snapshots_and_on_any_number_of_threads() {
    let targets = "targets = [\"/ball/mark\", \"/plate\"]";
    let more = [
        device("sensor", "late", targets),
        device("sensor", "often", targets),
        device("actuator", "once", &format!("lift_n = 4.0\n{targets}")),
        device("actuator", "inner", &format!("lift_n = 3.0\n{targets}")),
    ];
    let place = scene(&more.concat());
    let hash = |more: &[&str]| {
        let done = place.run(&[&["--steps", "40"], more].concat()).good();
        assert!(!done.err.contains("replay"), "{}", done.err);
        done.json()["hash"].clone()
    };
    let whole = hash(&["--snapshot-at", "1", "half"]);
    assert_eq!(hash(&["--threads", "1"]), whole);
    assert_eq!(hash(&["--threads", "4"]), whole);
    assert_eq!(hash(&["--from", "half"]), whole);
}
