//! Tests of graphs and drawings: the recorded values and files equal closed forms of the motion.

use crate::{kit::*, scripts::lives::started};

/// Parses a table of `--graphs` into column names and rows; an empty cell is NaN.
pub fn table(text: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut lines = text.lines();
    let heads = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let number = |cell: &str| if cell.is_empty() { f64::NAN } else { cell.parse().unwrap() };
    (heads, lines.map(|l| l.split(',').map(number).collect()).collect())
}

/// Returns a scene with a ball that falls from 10 m, and a graph that records its height and a value set by a script.
fn falling(more: &str) -> String {
    format!(
        "[[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\ndynamic = true\nposition_m = [0, 0, 10]\n\
         [[object]]\nkind = \"graph\"\nalias = \"Fall\"\n{more}\nstreams = [\n\
         {{ name = \"height\", unit = \"m\", of = \"/ball\", data = \"z\" }},\n\
         {{ name = \"v\", unit = \"m/s\", of = \"/ball\", data = \"z\", transform = \"derivative\" }},\n\
         {{ name = \"twice\", of = \"/ball\", data = \"object.world_pose[2]\", factor = 2.0, offset = 1.0 }},\n\
         {{ name = \"told\" }},\n]\ncurves = [{{ name = \"phase\", x = \"height\", y = \"v\" }}]\n{}",
        watcher(
            "teller",
            "function sysCall_actuation()
                local t = sim.getSimulationTime()
                if t < 0.5 then sim.setGraphUserData(sim.getObject('/Fall'), 'told', t) end
            end"
        )
    )
}

#[test]
fn a_fall_is_recorded_as_it_was() {
    let place = TestFolder::scene(&falling(""));
    place.run(&["--seconds", "1", "--graphs", "out", "--snapshot-at", "0.5", "half.tatu"]).good();
    let (heads, rows) = table(&place.read("out/Fall.csv"));
    assert_eq!(heads, ["time [s]", "height [m]", "v [m/s]", "twice", "told", "phase.x", "phase.y"]);
    assert_eq!(rows.len(), 20);
    for (i, r) in rows.iter().enumerate() {
        let t = 0.05 * (i + 1) as f64;
        // Samples are taken at the end of a step, with the time at its end.
        assert!((r[0] - t).abs() < 1e-9);
        // Free fall: physics steps of h = 2.5 ms cause an error of g t h / 2.
        assert!((r[1] - (10.0 - 9.81 / 2.0 * t * t)).abs() < 0.015 * t + 1e-6, "{r:?}");
        assert!((r[3] - (2.0 * r[1] + 1.0)).abs() < 1e-12);
        match i {
            0 => assert!(r[2].is_nan(), "a derivative must start with the second sample"),
            // The mean speed of a step equals the speed at its middle.
            _ => assert!((r[2] + 9.81 * (t - 0.025)).abs() < 0.02, "{r:?}"),
        }
        // The value that the script has set at the start of the step; no value when it no longer sets one.
        if i < 10 {
            assert!((r[4] - (t - 0.05)).abs() < 1e-6, "{r:?}")
        } else {
            assert!(r[4].is_nan(), "{r:?}")
        }
        assert!(r[5] == r[1] && (r[6] == r[2] || r[2].is_nan()));
    }
    let png = std::fs::read(place.path().join("out/Fall.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG") && png.len() < 200 * 1024, "{} bytes", png.len());
    // A run that is continued from a snapshot also has the samples before the snapshot.
    place.run(&["--steps", "20", "--from", "half.tatu", "--graphs", "again"]).good();
    assert_eq!(place.read("again/Fall.csv"), place.read("out/Fall.csv"));
}

#[test]
fn explicit_graphs_record_on_request_and_drop_the_oldest() {
    let place = TestFolder::scene(&format!(
        "{}{}",
        falling("explicit = true\nbuffer = 3"),
        watcher("handler", "function sysCall_sensing() sim.handleGraph(sim.getObject('/Fall'), 7) end")
    ));
    place.run(&["--steps", "5", "--graphs", "out"]).good();
    let (_, rows) = table(&place.read("out/Fall.csv"));
    assert_eq!(rows.iter().map(|r| r[0]).collect::<Vec<_>>(), [7.0; 3]);
}

#[test]
fn a_graph_that_makes_no_sense_is_refused_with_its_place() {
    let graph = |inner: &str| TestFolder::scene(&format!("[[object]]\nkind = \"graph\"\nalias = \"G\"\n{inner}\n"));
    let refused = |inner: &str, words: &[&str]| graph(inner).run(&["--steps", "1"]).refused(words);
    refused("streams = [{ name = \"a\", unti = \"m\" }]", &["unti", "unit"]);
    refused("streams = [{ name = \"a\", transform = \"slope\" }]", &["transform", "derivative"]);
    refused("streams = [{ name = \"a\" }, { name = \"a\" }]", &["already"]);
    refused("curves = [{ name = \"c\", x = \"a\", y = \"b\" }]", &["`a`"]);
    refused("buffer = 0", &["1000000"]);
    let lost = graph("streams = [{ name = \"a\", of = \"/nobody\", data = \"x\" }]");
    lost.run(&["--steps", "1"]).good().reports(&["/nobody", "remains empty"]);
}

#[test]
fn streams_find_readings_joints_and_speeds() {
    // A cart on a rail drives towards a wall whose face is at 3 m; its sensor points ahead from 0.1 m in front of it.
    let scene = format!(
        "[[object]]\nkind = \"shape\"\nalias = \"rail\"\n\
         [[object]]\nkind = \"joint\"\nalias = \"drive\"\nparent = \"/rail\"\ntype = \"prismatic\"\n\
         orientation_deg = [0, 90, 0]\ncontrol = \"velocity\"\ntarget_velocity_m_s = 0.5\nmax_force_n = 1000\n\
         [[object]]\nkind = \"shape\"\nalias = \"cart\"\nparent = \"/rail/drive\"\ndynamic = true\norientation_deg = [0, -90, 0]\n\
         [[object]]\nkind = \"sensor\"\nsensor = \"proximity\"\nalias = \"feeler\"\nparent = \"/rail/drive/cart\"\n\
         position_m = [0.1, 0, 0]\norientation_deg = [0, 90, 0]\nrange_m = 5\n{}\
         [[object]]\nkind = \"graph\"\nalias = \"G\"\nstreams = [\n\
         {{ name = \"far\", of = \"/rail/drive/cart/feeler\", data = \"proximity.distance\" }},\n\
         {{ name = \"q\", of = \"/drive\", data = \"joint.position\" }},\n\
         {{ name = \"v\", of = \"/cart\", data = \"speed\" }},\n]\n",
        cuboid("wall", [0.2, 1.0, 1.0], [3.1, 0.0, 0.0], "")
    );
    let place = TestFolder::scene(&scene);
    place.run(&["--seconds", "2", "--graphs", "out"]).good();
    let (_, rows) = table(&place.read("out/G.csv"));
    for r in &rows[4..] {
        // The distance is measured at the end of the step, with the joint position at that time: 3 m minus 0.1 m minus
        // the distance travelled.
        assert!((r[1] + r[2] - 2.9).abs() < 1e-3, "{r:?}");
        assert!((r[3] - 0.5).abs() < 1e-3, "{r:?}");
    }
}

/// Runs a script, which must not raise an error.
fn lua(script: &str) {
    let graph = "[[object]]\nkind = \"graph\"\nalias = \"G\"\nexplicit = true\n";
    TestFolder::scene(&format!("{graph}{}", watcher("tester", script))).run(&["--steps", "3"]).good();
}

#[test]
fn scripts_add_streams_and_curves_and_read_them() {
    lua("
        local function same(a, b) if math.abs(a - b) > 1e-6 then error(a .. ' instead of ' .. b, 2) end end
        function sysCall_init()
            g = sim.getObject('/G')
            a = sim.addGraphStream(g, 'a', 'm', 0, {1, 0, 0})
            b = sim.addGraphStream(g, 'b', 'm', 1)
            c = sim.addGraphCurve(g, 'c', 2, {a, -1}, {0, 5}, 'm')
            for i = 1, 4 do
                sim.setGraphStreamValue(g, a, i * i)
                sim.handleGraph(g, i / 10)
            end
            local label, kind, color, x, y, z, bounds, id = sim.getGraphCurve(g, 0, 0)
            if label ~= 'a' or kind ~= 0 or id ~= a or #x ~= 4 or #z ~= 0 then error(label) end
            same(color[1], 1) same(x[3], 0.3) same(y[3], 9) same(bounds[4], 16)
            local _, _, _, _, none = sim.getGraphCurve(g, 0, 1)
            if #none ~= 0 then error('b was never told') end
            local name, _, _, cx, cy = sim.getGraphCurve(g, 1, 0)
            if name ~= 'c' then error(name) end
            same(cx[4], 16) same(cy[4], 5)
            local d = sim.duplicateGraphCurveToStatic(g, c, 'd')
            sim.resetGraph(g)
            local _, _, _, old = sim.getGraphCurve(g, 1, 1)
            local _, _, _, gone = sim.getGraphCurve(g, 1, 0)
            if #old ~= 4 or #gone ~= 0 then error('a static curve stays') end
            sim.destroyGraphCurve(g, c)
            if sim.getGraphCurve(g, 1, 1) ~= nil then error('one curve is left') end
            sim.setGraphStreamTransformation(g, a, 3, 10, 1)
            for i = 1, 3 do sim.setGraphStreamValue(g, a, i) sim.handleGraph(g, i) end
            local _, _, _, _, sum = sim.getGraphCurve(g, 0, 0)
            same(sum[3], 61)
            if pcall(sim.setGraphStreamValue, g, 99, 1) then error('there is no stream 99') end
            if pcall(sim.setGraphUserData, g, 'nobody', 1) then error('there is no stream nobody') end
        end");
}

#[test]
fn drawings_accept_items_until_they_are_full() {
    lua("
        function sysCall_init()
            local function is(a, b) if a ~= b then error(tostring(a) .. ' instead of ' .. tostring(b), 2) end end
            local red = {1, 0, 0}
            local points = sim.addDrawingObject(sim.drawing_points, 3, 0, -1, 2, red)
            is(sim.addDrawingObjectItem(points, {0, 0, 0}), 1)
            is(sim.addDrawingObjectItem(points, {1, 0, 0}), 1)
            is(sim.addDrawingObjectItem(points, {2, 0, 0}), 0)
            is(sim.addDrawingObjectItem(points, nil), 1)
            is(sim.addDrawingObjectItem(points, {2, 0, 0}), 1)
            local ring = sim.addDrawingObject(sim.drawing_lines + sim.drawing_cyclic, 3, 0, sim.getObject('/G'), 2, red)
            for i = 1, 5 do is(sim.addDrawingObjectItem(ring, {0, 0, 0, i, 0, 0}), 1) end
            local apart = sim.addDrawingObject(sim.drawing_spherepoints, 0.1, 0.5, -1, 0, red)
            is(sim.addDrawingObjectItem(apart, {0, 0, 0}), 1)
            is(sim.addDrawingObjectItem(apart, {0.4, 0, 0}), 0)
            -- Items of faces have a normal, and in this object also a colour.
            local faces = simAddDrawingObject(sim_drawing_quadpoints + sim_drawing_itemcolors, 0.1, 0, -1, 0, red)
            is(simAddDrawingObjectItem(faces, {0, 0, 0, 0, 0, 1, 1, 1, 0}), 1)
            if pcall(sim.addDrawingObjectItem, faces, {0, 0, 0}) then error('an item of 3 numbers') end
            sim.removeDrawingObject(points)
            if pcall(sim.addDrawingObjectItem, points, {0, 0, 0}) then error('it is gone') end
            local dust = sim.addParticleObject(0, 0.01, 1000, nil, 1, 100, {1, 1, 0})
            sim.addParticleObjectItem(dust, {0, 0, 1, 0, 0, 0})
            sim.removeParticleObject(dust)
        end");
}

#[test]
fn views_are_counted_without_a_window() {
    lua("
        function sysCall_init()
            local function is(a, b) if a ~= b then error(tostring(a) .. ' instead of ' .. tostring(b), 2) end end
            local view = simFloatingViewAdd(0.5, 0.5, 0.3, 0.3, 0)
            is(simAdjustView(view, simGetObjectHandle('G'), 64, 'graph'), 1)
            is(simAdjustView(view, -1, 256), 2)
            is(simAdjustView(view, -1, 512), simGetObjectHandle('G'))
            is(simFloatingViewRemove(view), 1)
            is(simFloatingViewRemove(view), 0)
            is(simAdjustView(view, -1, 256), 1)
        end");
}

#[test]
fn streams_that_a_customization_script_adds_remain_when_runs_start() {
    let text = "function sysCall_init()
            graph = sim.getObject('.')
            own = sim.addGraphStream(graph, 'own', 'm', 0, {1, 0, 0})
            assert(own == sim.addGraphStream(graph, 'own', 'm', 0, {1, 0, 0}), 'added again')
            curve = sim.addGraphCurve(graph, 'way', 2, {own, own}, {0, 0}, 'm')
        end
        function sysCall_sensing()
            sim.setGraphStreamValue(graph, own, sim.getSimulationTime())
            if not once then once = sim.addGraphStream(graph, 'of the run') end
        end";
    let scene = format!(
        "[[object]]\nkind = \"graph\"\nalias = \"G\"\nstreams = [{{ name = \"declared\" }}]\n\
         script = {{ kind = \"customization\", dialect = \"4.6\", text = '''{text}''' }}\n"
    );
    let place = TestFolder::scene(&scene);
    place.run(&["--steps", "3", "--graphs", "out"]).good();
    let (heads, rows) = table(&place.read("out/G.csv"));
    assert_eq!(heads, ["time [s]", "declared", "own [m]", "of the run", "way.x [m]", "way.y [m]"]);
    let own: Vec<f64> = rows.iter().map(|r| r[2]).collect();
    assert_eq!(own.len(), 3);
    assert!(own.iter().enumerate().all(|(i, x)| (x - 0.05 * i as f64).abs() < 1e-9), "{own:?}");
    // In the next run, the stream that was added during the first one is gone.
    let (_place, world) = started(&scene);
    world.step();
    world.request_stop();
    while world.step() {}
    world.start();
    world.step();
    assert!(world.faults().is_empty(), "{:?}", world.faults());
}
