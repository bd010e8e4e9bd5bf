//! Tests of commands, callbacks and globals whose form depends on the version of V-REP, or that only some versions
//! have.

use crate::{
    kit::*,
    scripts::{lives::started, order::take_line_texts},
};

/// Runs a scene and returns what its scripts print.
#[track_caller]
fn printed(scene: &str, steps: &str) -> String {
    let done = TestFolder::scene(scene).tatu(&["run", "scene.toml", "--steps", steps]).good();
    format!("{}{}", done.out, done.err)
}

/// Returns a dummy with a script for a version.
fn script(alias: &str, dialect: &str, text: &str) -> String {
    format!(
        "[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\nscript = {{ dialect = \"{dialect}\", text = '''\n{text}\n''' }}\n"
    )
}

/// Runs the code in the initialization of a script for a version; it must not fail.
#[track_caller]
fn passes(dialect: &str, more: &str, code: &str) {
    let text = format!("function sysCall_init()\n{code}\nprint('all checked')\nend");
    let out = printed(&format!("{more}{}", script("tester", dialect, &text)), "1");
    assert!(out.contains("all checked"), "{out}");
}

/// An arm whose joint is driven by a script.
fn driven_arm() -> String {
    format!(
        "physics_dt_s = 0.005\n{}[[object]]\nkind = \"joint\"\nalias = \"hinge\"\nparent = \"base\"\n\
         control = \"callback\"\ntarget_position_deg = 90\nmax_force_nm = 50\nmax_velocity_deg_s = 100\n\
         limits_deg = [-10, 170]\n{}",
        cuboid("base", [0.2, 0.2, 0.2], [3.0, 0.0, 1.0], ""),
        cuboid("arm", [0.1, 0.1, 0.1], [0.0, 0.0, 0.0], "parent = \"hinge\"\ndynamic = true\nmass_kg = 1.0"),
    )
}

#[test]
fn joint_callbacks_get_the_names_of_their_version() {
    // script-api.md, 1.3.1. The controller of the manual of 3.5 to 4.3: it needs all names of that time, and its
    // integral is set up in the first call.
    let old = script(
        "control",
        "4.1",
        "function sysCall_jointCallback(d)
            if d.first then sum, calls = 0, 0 end
            calls = calls + 1
            sum = sum + d.errorValue * d.dynStepSize
            assert(math.abs(d.errorValue - (d.targetPos - d.currentPos)) < 1e-9 and d.targetVel == 0)
            assert(d.passCnt >= 1 and d.passCnt <= d.totalPasses and d.revolute and not d.cyclic)
            assert(math.abs(d.highLimit - math.rad(170)) < 1e-6 and d.lowLimit < 0 and d.effort)
            local v = 0.1 * d.errorValue / d.dynStepSize
            v = math.max(-d.velUpperLimit, math.min(d.velUpperLimit, v))
            return {velocity = v, force = d.maxForce}
        end
        function sysCall_sensing() if calls == 400 then print('called ' .. calls .. ' times') end end",
    );
    let (_place, world) = started(&format!("{}{old}", driven_arm()));
    for _ in 0..40 {
        world.step();
    }
    assert!(world.faults().is_empty(), "{:?}", world.faults());
    assert!(take_line_texts(&world).iter().any(|l| l.contains("called 400 times")), "one `first` for all steps");
    let [position, _, _] = world.observe("/base/hinge").unwrap().joint.unwrap();
    assert!((position - std::f64::consts::FRAC_PI_2).abs() < 0.02, "{position}");
    // A joint that a script drives only later gets `first` in its first call.
    let late = script(
        "control",
        "4.9",
        "function sysCall_actuation()
            n = (n or 0) + 1
            if n == 3 then
                sim.setObjectInt32Param(sim.getObject('/hinge'), sim.jointintparam_dynctrlmode, sim.jointdynctrl_callback)
            end
        end
        function sysCall_joint(d)
            if d.first then print(string.format('first in step %d %d %g %g', n, d.passCnt, d.dt, d.maxVel)) end
            return {vel = d.error, force = d.force}
        end",
    );
    let out = printed(&format!("{}{late}", driven_arm().replace("\"callback\"", "\"velocity\"")), "5");
    assert_eq!(out.matches("first in step 3 1 0.005 1.74533").count(), 1, "{out}");
    assert_eq!(out.matches("first in step").count(), 1, "{out}");
}

#[test]
fn globals_of_the_language_exist_from_4_1_on() {
    for dialect in ["4.1", "4.6", "4.9"] {
        passes(
            dialect,
            "",
            "_S.own = 1
            __HIDDEN__.own = 2
            local m = Matrix(2, 3, {11, 12, 13, 21, 22, 23})
            assert(m:rows() == 2 and m:cols() == 3 and m[2][1] == 21 and m:get(1, 3) == 13)
            m[1][2] = 99
            assert(m:get(1, 2) == 99 and m:t():get(2, 1) == 99 and m:row(1)[2] == 99)
            local a = Matrix(2, 2, {2, 1, 1, 3})
            assert(a:inv() * a == Matrix:eye(2) or (a:inv() * a - Matrix:eye(2)):norm() < 1e-12)
            assert(math.abs(a:det() - 5) < 1e-12 and (a ^ 2):get(1, 1) == 5 and (a + 1):sum() == 11 and #a == 2)
            local v = Vector{3, 4}
            assert(v:norm() == 5 and v[2] == 4 and v:dot{1, 1} == 7 and (2 * v)[1] == 6)
            assert(tostring(Vector3{1, 0, 0}):match('Matrix%(3,1,'))
            assert(Vector3{1, 0, 0}:cross(Vector3{0, 1, 0}) == Vector3{0, 0, 1})
            local turn = Matrix3x3:fromeuler{0.1, -0.2, 0.3}
            local e = Matrix3x3:toeuler(turn)
            assert(math.abs(e[1] - 0.1) < 1e-9 and math.abs(e[2] + 0.2) < 1e-9 and math.abs(e[3] - 0.3) < 1e-9)
            -- The matrices of the API have 12 numbers.
            local place = sim.buildMatrix({1, 2, 3}, {0.1, -0.2, 0.3})
            local t = Matrix4x4(place)
            assert((Matrix4x4:torotation(t) - turn):norm() < 1e-6)
            local p = Matrix4x4:topose(t)
            local back = Matrix4x4:frompose(p)
            assert((back - t):norm() < 1e-6 and p[2] == 2)
            assert((Matrix4x4:inv(t) * t - Matrix:eye(4)):norm() < 1e-6)
            local moved = t:mult(Vector3{0, 0, 0})
            assert(moved[1] == 1 and moved[3] == 3)
            assert(Matrix:fromtable{{1, 2}, {3, 4}}:totable()[2][1] == 3 and m:max() == 99)
            assert(not pcall(function() return a * Vector3{1, 2, 3} end), 'sizes must match')",
        );
    }
    passes("3.6", "", "assert(Matrix == nil and Vector3 == nil)");
}

#[test]
fn shapes_of_all_primitive_types_are_created() {
    passes(
        "4.6",
        "",
        "local sim = require 'sim'
        for kind, name in pairs{[2] = 'disc', [6] = 'cone', [7] = 'heightfield'} do
            local h = sim.createPrimitiveShape(kind, {0.4, 0.2, name == 'cone' and 0.6 or 0})
            local size = sim.getShapeBB(h)
            assert(math.abs(size[1] - 0.4) < 1e-3 and math.abs(size[2] - 0.2) < 1e-3, name)
            assert(math.abs(size[3] - (name == 'cone' and 0.6 or 0)) < 1e-6, name)
        end
        assert(not pcall(sim.createPrimitiveShape, 9, {1, 1, 1}))
        assert(not pcall(sim.createPrimitiveShape, 6, {1, 1, 0}))",
    );
    // A cone of 1000 kg/m^3 has a third of the mass of its cylinder; its 32 sides take 0.6 % away.
    passes(
        "3.6",
        "",
        "local cone = simCreatePureShape(3, 8, {0.2, 0.2, 0.3}, 2)
        local r, mass = simGetObjectFloatParameter(cone, 3005)
        assert(mass == 2)
        simComputeMassAndInertia(cone, 1000)
        r, mass = simGetObjectFloatParameter(cone, 3005)
        local exact = 1000 * math.pi * 0.01 * 0.3 / 3
        assert(math.abs(mass - exact) < 0.01 * exact, mass)",
    );
}

#[test]
fn a_proximity_sensor_checks_the_objects_of_a_collection() {
    let scene = format!(
        "{}{}{}[[object]]\nkind = \"sensor\"\nsensor = \"proximity\"\nalias = \"ray\"\nvolume = \"ray\"\nrange_m = 5.0\n",
        cuboid("near", [0.1, 0.1, 0.1], [0.0, 0.0, 0.55], ""),
        cuboid("middle", [0.1, 0.1, 0.1], [0.0, 0.0, 1.05], ""),
        cuboid("far", [0.1, 0.1, 0.1], [0.0, 0.0, 2.05], ""),
    );
    passes(
        "4.6",
        &scene,
        "local sim = require 'sim'
        local ray, middle, far = sim.getObject('/ray'), sim.getObject('/middle'), sim.getObject('/far')
        local all = sim.createCollection(0)
        sim.addItemToCollection(all, sim.handle_single, far, 0)
        sim.addItemToCollection(all, sim.handle_single, middle, 0)
        local r, d, p, o = sim.checkProximitySensor(ray, all)
        assert(r == 1 and math.abs(d - 1) < 1e-4 and o == middle, d)
        r, d, p, o = sim.checkProximitySensorEx(ray, all, 3, 0, 0)
        assert(r == 1 and o == middle)
        assert(sim.checkProximitySensorEx(ray, all, 3, 0.5, 0) == 0, 'beyond the threshold')
        sim.addItemToCollection(all, sim.handle_single, middle, 1)
        r, d, p, o = sim.checkProximitySensor(ray, all)
        assert(r == 1 and math.abs(d - 2) < 1e-4 and o == far)
        assert(select(4, sim.readProximitySensor(ray)) == far)
        assert(sim.checkProximitySensor(ray, sim.createCollection(0)) == 0, 'an empty collection')",
    );
}

#[test]
fn items_of_drawings_have_their_own_colour_and_size() {
    passes(
        "4.5",
        "",
        "local kind = sim.drawing_discpoints + sim.drawing_itemcolors + sim.drawing_itemsizes
        local d = sim.addDrawingObject(kind, 0.1, 0, -1, 10)
        assert(sim.addDrawingObjectItem(d, {0, 0, 1, 0, 0, 1, 1, 0, 0, 0.2}) == 1)
        local facing = sim.addDrawingObject(kind + sim.drawing_facingcamera, 0.1, 0, -1, 10)
        assert(sim.addDrawingObjectItem(facing, {0, 0, 1, 1, 0, 0, 0.2}) == 1, 'without a normal')
        local turned = sim.addDrawingObject(sim.drawing_cubepts + sim.drawing_itemcolors, 0.1, 0, -1, 10)
        assert(sim.addDrawingObjectItem(turned, {0, 0, 1, 0, 0, 0, 1, 1, 0, 0}) == 1, 'with a quaternion')",
    );
}

#[test]
fn parameters_of_looks_are_stored() {
    passes(
        "4.6",
        &cuboid("box", [0.1; 3], [0.0; 3], ""),
        "local sim = require 'sim'
        local box = sim.getObject('/box')
        assert(sim.getObjectFloatParam(box, sim.shapefloatparam_texture_y) == 0)
        assert(sim.getObjectFloatParam(box, sim.shapefloatparam_texture_scaling_x) == 1)
        sim.setObjectFloatParam(box, sim.shapefloatparam_texture_y, 0.25)
        assert(sim.getObjectFloatParam(box, 3007) == 0.25)
        sim.setObjectInt32Param(box, sim.shapeintparam_edge_visibility, 1)
        assert(sim.getObjectInt32Param(box, sim.shapeintparam_edge_visibility) == 1)",
    );
}

#[test]
fn selections_and_matrices_are_set_by_the_arguments_of_each_version() {
    passes(
        "4.5",
        &cuboid("box", [0.1; 3], [0.0; 3], ""),
        "local box = sim.getObject('/box')
        sim.setObjectSelection({box})
        assert(sim.getObjectSelection()[1] == box and sim.getObjectSel()[1] == box)
        local m = {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3}
        for _, arguments in ipairs{{box, -1, m}, {box, m, -1}, {box, m}, {box, m, sim.handle_parent},
                {box, sim.handle_parent, m}, {box, -1, {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1}}} do
            sim.setObjectPosition(box, -1, {0, 0, 0})
            sim.setObjectMatrix(table.unpack(arguments))
            local p = sim.getObjectPosition(box, -1)
            assert(p[1] == 1 and p[2] == 2 and p[3] == 3)
        end",
    );
}

#[test]
fn stored_handles_of_an_imported_file_are_found_by_path() {
    let scene = format!(
        "{}{}",
        cuboid("robot", [0.1; 3], [0.0; 3], "data = { \"\\u0001paths \" = \"./arm[0]\\n\\n./arm[0]/hand[0]\" }"),
        "[[object]]\nkind = \"dummy\"\nalias = \"arm\"\nparent = \"robot\"\n\
         [[object]]\nkind = \"dummy\"\nalias = \"hand\"\nparent = \"/robot/arm\"\n"
    );
    passes(
        "4.6",
        &scene,
        "local sim = require 'sim'
        local robot, arm = sim.getObject('/robot'), sim.getObject('/arm')
        local all = sim.getReferencedHandles(robot)
        assert(#all == 3 and all[1] == arm and all[2] == -1 and all[3] == sim.getObject('/hand'))
        assert(sim.getReferencedHandlesTags(robot)[1] == '')
        -- Those of a copy are in the copy.
        local copy = sim.copyPasteObjects({robot}, 1)[1]
        local own = sim.getReferencedHandles(copy)
        assert(own[1] > 0 and own[1] ~= arm and sim.getObjectParent(own[1]) == copy)
        sim.setReferencedHandles(robot, {arm})
        assert(#sim.getReferencedHandles(robot) == 1 and #sim.getReferencedHandlesTags(robot) == 1)",
    );
}

#[test]
fn sensors_are_created_with_all_their_parameters() {
    passes(
        "4.6",
        &format!("{}{}", cuboid("wall", [2.0, 2.0, 0.1], [0.0, 0.0, 1.05], "color = [1, 0, 0]"), FLOOR),
        "local sim = require 'sim'
        local none = {0, 0, 0, 0, 0, 0, 0, 0}
        local function made(kind, options, floats, ints)
            for i = #floats + 1, 15 do floats[i] = 0 end
            return sim.createProximitySensor(kind, 16, options, ints or none, floats)
        end
        local ray = made(sim.proximitysensor_ray_subtype, 1, {0, 2})
        assert(sim.getObjectType(ray) == sim.object_proximitysensor_type)
        assert(sim.getExplicitHandling(ray) == 1)
        local r, d, p, o = sim.handleProximitySensor(ray)
        assert(r == 1 and math.abs(d - 1) < 1e-6 and o == sim.getObject('/wall'))
        assert(sim.handleProximitySensor(made(sim.proximitysensor_ray_subtype, 1, {0, 0.5})) == 0, 'its range')
        -- A cone of 60 degrees that is turned by 100 degrees does not see the wall above; one of 240 degrees does.
        for angle, wanted in pairs{[60] = 0, [240] = 1} do
            local cone = made(sim.proximitysensor_cone_subtype, 1, {0, 3, 0, 0, 0, 0, 0, 0, 0, math.rad(angle)})
            sim.setObjectPosition(cone, {0, 0, 0.5})
            sim.setObjectOrientation(cone, {math.rad(100), 0, 0})
            assert(sim.handleProximitySensor(cone) == wanted, angle)
        end
        local box = made(sim.proximitysensor_pyramid_subtype, 1, {0.2, 2, 0.1, 0.1, 0.5, 0.5})
        r, d = sim.handleProximitySensor(box)
        assert(r == 1 and math.abs(d - 1) < 1e-6)
        -- Behind the far end of the blind zone: nothing is reported.
        assert(sim.handleProximitySensor(made(34, 1 + 256, {0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1.5})) == 0)
        local random = made(33, 1 + 512, {0, 2, 0, 0, 0, 0, 0, 0, 0, 0.2}, {0, 0, 0, 0, 10, 5, 0, 0})
        assert(sim.handleProximitySensor(random) == 1)
        assert(not pcall(made, 35, 0, {0, 1}) and not pcall(made, 34, 0, {0, 0}))

        local eye = sim.createVisionSensor(1 + 2, {8, 4, 0, 0}, {0.1, 3, 1, 0.1, 0.1, 0.1, 0, 0, 1, 0, 0})
        assert(sim.getObjectType(eye) == sim.object_visionsensor_type)
        local size = sim.getVisionSensorRes(eye)
        assert(size[1] == 8 and size[2] == 4)
        sim.handleVisionSensor(eye)
        local image = sim.getVisionSensorImg(eye)
        assert(#image == 96 and image:byte(1) > 64 and image:byte(2) == 0, 'the wall is red')
        assert(not pcall(sim.createVisionSensor, 2, {8, 0, 0, 0}, {0.1, 3, 1}))
        assert(not pcall(sim.createVisionSensor, 2, {8, 8, 0, 0}, {2, 1, 1}))",
    );
}

#[test]
fn conveyors_of_all_versions_move_their_rollers() {
    for module in
        ["conveyorSystem_customization-2", "models.deprecated.conveyor_customization-2", "conveyor_customization"]
    {
        let belt = format!(
            "sim.writeCustomTableData(sim.getObject('.'), '__config__', \
             {{type = 2, rollerRadius = 0.05, targetVel = 0.1, accel = 100}})\n\
             conveyor = require('{module}')"
        );
        let scene = format!(
            "[[object]]\nkind = \"dummy\"\nalias = \"belt\"\n\
             script = {{ kind = \"customization\", dialect = \"4.5\", text = '''{belt}''' }}\n\
             [[object]]\nkind = \"joint\"\nalias = \"jrol\"\nparent = \"belt\"\nmode = \"kinematic\"\n"
        );
        let (_place, world) = started(&scene);
        for _ in 0..20 {
            world.step();
        }
        assert!(world.faults().is_empty(), "{module}: {:?}", world.faults());
        // 0.1 m/s for 1 s on a roller of 5 cm, after a start with 100 m/s^2.
        let [position, _, _] = world.observe("/belt/jrol").unwrap().joint.unwrap();
        assert!((position - 2.0).abs() < 0.06, "{module}: {position}");
    }
}
