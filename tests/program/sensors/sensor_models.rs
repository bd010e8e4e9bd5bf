//! Tests of models of sensors from V-REP's library: the objects to which scripts refer exist, and the scripts of the
//! models report the values that follow from the scene's geometry.
//!
//! The names, positions and values of V-REP's models and of devices are from `tests/facts/devices.md`.

use crate::kit::*;

/// Returns a room of 6 x 4 m around the origin, whose walls sensors can detect.
fn room() -> String {
    [
        cuboid("east", [0.2, 4.2, 1.0], [3.1, 0.0, 0.5], ""),
        cuboid("west", [0.2, 4.2, 1.0], [-3.1, 0.0, 0.5], ""),
        cuboid("north", [6.0, 0.2, 1.0], [0.0, 2.1, 0.5], ""),
        cuboid("south", [6.0, 0.2, 1.0], [0.0, -2.1, 0.5], ""),
    ]
    .concat()
}

/// A Lua function that returns the distance from `(x, y)` to the walls in the direction of an angle.
const WALLS: &str = "
    local function wall(x, y, angle)
        local c, s = math.cos(angle), math.sin(angle)
        local across = c > 0 and (3 - x) / c or c < 0 and (-3 - x) / c or math.huge
        local along = s > 0 and (2 - y) / s or s < 0 and (-2 - y) / s or math.huge
        return math.min(across, along)
    end
    local function same(a, b, tolerance, what)
        if not (math.abs(a - b) <= tolerance) then error(string.format('%s: %.6f instead of %.6f', what, a, b)) end
    end\n";

fn placed(model: &str, at: [f64; 3], more: &str) -> String {
    format!("[[model]]\nmodel = \"{model}\"\nposition_m = {at:?}\n{more}\n")
}

#[test]
fn the_scanner_sends_its_points_by_tube_signal_graph_and_file() {
    // The scanner returns 361 points over 180 degrees, relative to itself. Beam i has the angle -90 + i / 2 degrees.
    let reader = "
        function sysCall_init()
            scanner = sim.getObjectHandle('LaserScanner_2D')
            tube = sim.tubeOpen(0, 'LaserScanner_2D_2D_SCANNER_DATA', 1)
            for _, part in ipairs({ 'Body', 'Joint', 'Laser', 'Graph' }) do
                sim.getObjectHandle('LaserScanner' .. part .. '_2D')
            end
        end
        function sysCall_actuation()
            local data = sim.tubeRead(tube)
            if not data then return end
            local points = sim.unpackFloatTable(data)
            same(#points, 3 * 361, 0, 'numbers')
            local least = math.huge
            for i = 0, 360 do
                local angle = math.rad(i / 2 - 90)
                local x, y, z = points[3 * i + 1], points[3 * i + 2], points[3 * i + 3]
                local d = wall(0.5, -0.25, angle + math.rad(30))
                same(math.sqrt(x * x + y * y), d, 1e-5, 'beam ' .. i)
                same(y * math.cos(angle) - x * math.sin(angle), 0, 1e-5, 'direction of beam ' .. i)
                same(z, 0, 1e-6, 'height')
                least = math.min(least, d)
            end
            same(sim.getFloatSignal('LaserFrontal'), least, 1e-5, 'the signal')
            sim.addStatusbarMessage('scan')
        end";
    let scanner =
        placed("laser_scanner_2d", [0.5, -0.25, 0.3], "orientation_deg = [0.0, 0.0, 30.0]\nlog = \"scans.log\"");
    let text = format!("{}{scanner}{}", room(), watcher("reader", &format!("{WALLS}{reader}")));
    let place = TestFolder::scene(&text);
    let lines = place.trace(&[], &["--steps", "5", "--graphs", "."]);
    let told = lines.iter().filter(|l| l.status() == ["scan"]).count();
    assert_eq!(told, 4, "each scan must be available one step later");
    let log = place.read("scans.log");
    assert!(log.lines().count() >= 5 && log.lines().all(|l| l.ends_with(" 361")), "{log}");
    let picture = std::fs::read(place.path().join("LaserScannerGraph_2D.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
}

#[test]
fn parameters_of_a_model_are_those_of_its_script_and_others_may_set_them() {
    let reader = "
        function sysCall_init()
            tube = sim.tubeOpen(0, 'LaserScanner_2D_2D_SCANNER_DATA', 1)
            script = sim.getScriptAssociatedWithObject(sim.getObjectHandle('LaserScanner_2D'))
        end
        function sysCall_actuation()
            local data = sim.tubeRead(tube)
            if data then sim.addStatusbarMessage('' .. #sim.unpackFloatTable(data) / 3) end
            if sim.getSimulationTime() > 0.07 then
                sim.setScriptSimulationParameter(script, 'scanningDensity', '0.5')
            end
        end";
    let more = "scanning_angle_deg = 90.0\nscanning_density = 1.0";
    let text = format!("{}{}{}", room(), placed("sick", [0.0, 0.0, 0.3], more), watcher("reader", reader));
    let lines = TestFolder::scene(&text).trace(&[], &["--steps", "5"]);
    let told: Vec<_> = lines.iter().flat_map(TraceLine::status).map(|t| t.parse::<f64>().unwrap()).collect();
    assert_eq!(told, [91.0, 91.0, 46.0, 46.0]);
}

#[test]
fn the_hokuyo_turns_ten_times_a_second() {
    // The scanner covers 512 of 1024 directions per step, and measures in 684 directions. It returns 512 points, then
    // 172, and after each turn all distances.
    let reader = "
        function sysCall_init()
            for _, part in ipairs({ 'body', 'joint', 'laser' }) do
                sim.getObjectHandle('Hokuyo_URG_04LX_UG01_' .. part)
            end
        end
        function sysCall_actuation()
            local data = sim.getStringSignal('measuredDataAtThisTime')
            if not data then return end
            sim.addStatusbarMessage('' .. #sim.unpackFloatTable(data) / 3)
            local all = sim.getStringSignal('Hokuyo_URG_04LX_UG01_distances')
            if not all then return end
            all = sim.unpackFloatTable(all)
            same(#all, 684, 0, 'distances')
            for i, d in ipairs(all) do
                same(d, wall(0, 0, math.rad(-120 + 240 * (i - 1) / 684)), NOISE, 'distance ' .. i)
            end
        end";
    for (noise, tolerance) in [("0.0", "1e-5"), ("0.01", "0.01001")] {
        let device = placed("hokuyo", [0.0, 0.0, 0.2], &format!("noise_m = {noise}"));
        let reader = format!("local NOISE = {tolerance}\n{WALLS}{reader}");
        let text = format!("{}{device}{}", room(), watcher("reader", &reader));
        let lines = TestFolder::scene(&text).trace(&[], &["--steps", "7"]);
        let told: Vec<_> = lines.iter().flat_map(TraceLine::status).map(|t| t.parse::<f64>().unwrap()).collect();
        assert_eq!(told, [512.0, 172.0, 512.0, 172.0, 512.0, 172.0]);
    }
}

#[test]
fn errors_of_the_hokuyo_are_spread_evenly_over_a_centimetre_to_either_side() {
    let reader = "
        function sysCall_init() errors = {} end
        function sysCall_actuation()
            local all = sim.getStringSignal('Hokuyo_URG_04LX_UG01_distances')
            if not all or sim.getSimulationTime() / 0.1 % 1 > 0.25 then return end
            for i, d in ipairs(sim.unpackFloatTable(all)) do
                errors[#errors + 1] = (d - wall(0, 0, math.rad(-120 + 240 * (i - 1) / 684))) / 0.01
            end
        end
        function sysCall_cleanup()
            local n = #errors
            if n < 20000 then error('only ' .. n .. ' errors') end
            -- A uniform number from -1 to 1 has mean 0 and variance 1/3; the tolerance is 4 standard errors. The
            -- Kolmogorov-Smirnov bound 1.95 / sqrt(n) is exceeded by chance once in a thousand.
            local sum, squares, worst = 0, 0, 0
            table.sort(errors)
            for i, e in ipairs(errors) do
                sum, squares = sum + e, squares + e * e
                worst = math.max(worst, math.abs((e + 1) / 2 - i / n))
            end
            same(sum / n, 0, 4 * math.sqrt(1 / 3 / n), 'mean')
            same(squares / n, 1 / 3, 4 * math.sqrt(4 / 45 / n), 'variance')
            same(worst, 0, 1.95 / math.sqrt(n), 'Kolmogorov-Smirnov')
        end";
    let text = format!(
        "{}{}{}",
        room(),
        placed("hokuyo", [0.0, 0.0, 0.2], ""),
        watcher("reader", &format!("{WALLS}{reader}"))
    );
    TestFolder::scene(&text).run(&["--seconds", "4"]).good();
}

/// Returns the position that a GPS model reports in each step, through signals and a tube.
fn gps(model: &str, scene: &str) -> Vec<[f64; 3]> {
    let reader = "
        function sysCall_init() tube = sim.tubeOpen(0, 'gpsData' .. sim.getNameSuffix(nil), 1) sim.getObjectHandle('GPS_reference') end
        function sysCall_actuation()
            local data = sim.tubeRead(tube)
            if not data then return end
            local p = sim.unpackFloatTable(data)
            for k, axis in ipairs({ 'X', 'Y', 'Z' }) do
                if sim.getFloatSignal('gps' .. axis) ~= p[k] then error('signal and tube differ') end
            end
            sim.addStatusbarMessage(string.format('%.9f %.9f %.9f', p[1], p[2], p[3]))
        end";
    let text = format!("{scene}{}{}", placed("gps", [1.5, -2.25, 0.5], model), watcher("reader", reader));
    let lines = TestFolder::scene(&text).trace(&[], &["--steps", "401"]);
    let told = lines.iter().flat_map(TraceLine::status);
    told.map(|t| t.split(' ').map(|x| x.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap()).collect()
}

#[test]
fn a_gps_is_exact_without_errors_and_as_inexact_as_v_rep_with_them() {
    let exact = gps("noise_m = [0.0, 0.0, 0.0]\nshift_m = [0.0, 0.0, 0.0]", "");
    assert_eq!(exact.len(), 400);
    assert!(exact.iter().all(|p| *p == [1.5, -2.25, 0.5]), "these values are also exact in 32 bits");
    let (truth, noise, shift) = ([1.5, -2.25, 0.5], [0.1, 0.1, 0.05], [1.0, 1.0, 0.5]);
    let runs = ["seed = 1\n", "seed = 2\n"].map(|seed| gps("", seed));
    let means = runs.each_ref().map(|run| {
        std::array::from_fn::<f64, 3, _>(|k| run.iter().map(|p| p[k] - truth[k]).sum::<f64>() / run.len() as f64)
    });
    for (run, mean) in runs.iter().zip(&means) {
        for k in 0..3 {
            // The mean of 400 readings differs from the shift by at most 4 standard errors.
            let error = 4.0 * noise[k] / 3f64.sqrt() / 20.0;
            assert!(mean[k].abs() <= shift[k] + error, "{mean:?}");
            let far = run.iter().map(|p| (p[k] - truth[k] - mean[k]).abs()).fold(0.0, f64::max);
            assert!(far <= noise[k] + error && far > 0.9 * noise[k], "axis {k}: {far}");
        }
    }
    assert!((0..3).all(|k| (means[0][k] - means[1][k]).abs() > 1e-3), "two seeds have the same shift: {means:?}");
}

#[test]
fn the_course_shows_a_gps_with_its_error_and_without() {
    let scene = root().join("scenes/course/gps.toml");
    let place = TestFolder::new();
    let args = ["run", scene.to_str().unwrap(), "--seconds", "10", "--json", "--trace", "trace.jsonl"];
    place.tatu(&args).good();
    let told: Vec<(f64, f64)> = place
        .lines("trace.jsonl")
        .iter()
        .flat_map(|l| l.status().iter().map(|s| (l.time(), *s)).map(|(t, s)| (t, s.to_owned())).collect::<Vec<_>>())
        .map(|(t, s)| (t, s.split("off by ").nth(1).unwrap().trim_end_matches(" m").parse().unwrap()))
        .collect();
    assert_eq!(told.len(), 10, "{told:?}");
    assert!(told.iter().all(|(t, off)| if *t > 5.5 { *off <= 0.001 } else { *off > 0.01 }), "{told:?}");
}

#[test]
fn the_fast_hokuyo_measures_the_walls_in_all_its_pixels() {
    // Two cameras of 256 pixels and 120 degrees each, from -120 to 120 degrees, to 5 m; column k of a camera points to
    // atan((2 (k + 0.5) / 256 - 1) tan 60): tests/facts/devices.md. The row of pixels is not at the same height, but
    // walls are vertical: all points are on them.
    let reader = "
        function sysCall_init()
            for _, part in ipairs({ 'body', 'joint1', 'joint2', 'sensor1', 'sensor2', 'ref' }) do
                sim.getObjectHandle('fastHokuyo_' .. part)
            end
        end
        function sysCall_actuation()
            local data = sim.getStringSignal('measuredDataAtThisTime')
            if not data then return end
            local points = sim.unpackFloatTable(data)
            local n = #points / 3
            local last = -math.huge
            for i = 0, n - 1 do
                local x, y, z = points[3 * i + 1], points[3 * i + 2], points[3 * i + 3]
                local k, camera = i % 256, math.floor(i / 256)
                local angle = math.atan((2 * (k + 0.5) / 256 - 1) * math.tan(math.rad(60))) + math.rad(camera == 0 and -60 or 60)
                same(y * math.cos(angle) - x * math.sin(angle), 0, 2e-5, 'direction of pixel ' .. i)
                same(math.sqrt(x * x + y * y), wall(0, 0, angle), 2e-5, 'pixel ' .. i)
                same(z, 0.063, 1e-5, 'height')
            end
            sim.addStatusbarMessage('' .. n)
        end";
    let text = format!(
        "{}{}{}",
        room(),
        placed("fast_hokuyo", [0.0, 0.0, 0.2], ""),
        watcher("reader", &format!("{WALLS}{reader}"))
    );
    let lines = TestFolder::scene(&text).trace(&[], &["--steps", "3"]);
    let told: Vec<_> = lines.iter().flat_map(TraceLine::status).map(|t| t.parse::<f64>().unwrap()).collect();
    assert_eq!(told, [512.0, 512.0]);
}

#[test]
fn the_kinect_sees_a_plate_in_front_of_it() {
    // V-REP's kinect-color-point-cloud: the cameras are 29.2 mm before and 53.0 mm above the model's origin and point
    // along +y, 640 x 480 pixels, 57 degrees along the longer side (f 589.4 pixels), 0.01 to 3.5 m.
    let plate = cuboid("plate", [0.4, 0.1, 0.2], [0.5 - 0.0141, 2.05, 0.5 + 0.053], "color = [1.0, 0.0, 0.0]");
    let reader = "
        function sysCall_init()
            for _, part in ipairs({ 'joint', 'body', 'glass', 'depth', 'rgb' }) do sim.getObjectHandle('kinect_' .. part) end
            depth, rgb = sim.getObjectHandle('kinect_depth'), sim.getObjectHandle('kinect_rgb')
        end
        function sysCall_sensing()
            local resolution = sim.getVisionSensorResolution(depth)
            same(resolution[1], 640, 0, 'columns')
            same(resolution[2], 480, 0, 'rows')
            local depths = sim.getVisionSensorDepthBuffer(depth)
            local image = sim.getVisionSensorCharImage(rgb)
            -- The face is 2 - 0.0292 m away: the number of pixels follows from the plate's width and height there.
            local z, f = 2 - 0.029248, 320 / math.tan(math.rad(57) / 2)
            local wide, high = {}, {}
            local seen, sum = 0, 0
            for i, value in ipairs(depths) do
                if value < 1 then
                    seen, sum = seen + 1, sum + 0.01 + value * 3.49
                    local column, row = (i - 1) % 640, math.floor((i - 1) / 640)
                    wide[column], high[row] = true, true
                    local r, g, b = image:byte(3 * i - 2, 3 * i)
                    if r <= g or g ~= 0 or b ~= 0 then error('a pixel of the plate is not red') end
                end
            end
            local columns, rows = 0, 0
            for _ in pairs(wide) do columns = columns + 1 end
            for _ in pairs(high) do rows = rows + 1 end
            same(columns, 0.4 * f / z, 1, 'columns of the plate')
            same(rows, 0.2 * f / z, 1, 'rows of the plate')
            same(seen, columns * rows, 0, 'pixels of the plate')
            same(sum / seen, z, 1e-3 * z, 'depth')
            sim.addStatusbarMessage('seen')
        end";
    let kinect = placed("kinect", [0.5, 0.0, 0.5], "");
    let text = format!("{plate}{kinect}{}", watcher("reader", &format!("{WALLS}{reader}")));
    let lines = TestFolder::scene(&text).trace(&[], &["--steps", "2"]);
    assert!(lines.iter().all(|l| l.status() == ["seen"]));
    let old = "
        function sysCall_init() sensor = sim.getObjectHandle('kinect_visionSensor') end
        function sysCall_sensing()
            same(#sim.getVisionSensorDepthBuffer(sensor), 160 * 120, 0, 'pixels')
            if sim.getObjectHandle('kinect_depth@silentError') ~= -1 then error('it has both') end
        end";
    let kinect = placed("kinect", [0.5, 0.0, 0.5], "sensors = \"vision_sensor\"\ncolumns = 160\nrows = 120");
    TestFolder::scene(&format!("{plate}{kinect}{}", watcher("reader", &format!("{WALLS}{old}"))))
        .run(&["--steps", "2"])
        .good();
}

#[test]
fn the_course_saves_kinect_images_at_a_key() {
    let scene = root().join("scenes/course/kinect_capture.toml");
    let place = TestFolder::new();
    place.write("keys.txt", "1.0 w\n2.0 x\n3.0 w\n");
    let args =
        ["run", scene.to_str().unwrap(), "--seconds", "4", "--json", "--trace", "trace.jsonl", "--keys", "keys.txt"];
    place.tatu(&args).good();
    let lines = place.lines("trace.jsonl");
    let told: Vec<_> = lines.iter().flat_map(TraceLine::status).collect();
    assert_eq!(told.iter().filter(|t| t.starts_with("saved")).count(), 2, "{told:?}");
    // The side of the can is 60 mm in front of its centre, and the camera is 29.2 mm in front of the origin of the
    // model, so the distance is -0.2 - 0.06 + 2 - 0.029248 m.
    assert_eq!(told.iter().filter(|t| **t == "the middle is 1.711 m away").count(), 4, "{told:?}");
    for name in ["kinect_1_rgb.png", "kinect_1_depth.png", "kinect_2_rgb.png", "kinect_2_depth.png"] {
        let bytes = std::fs::read(place.path().join(name)).unwrap();
        let reader = png::Decoder::new(bytes.as_slice()).read_info().unwrap();
        assert_eq!((reader.info().width, reader.info().height), (640, 480), "{name}");
    }
    assert!(!place.path().join("kinect_3_rgb.png").exists());
}
