//! Tests of vision sensors through the V-REP API: their images of scenes with known geometry.
//!
//! The facts are from `tests/facts/script-api.md`, 4.

use crate::kit::*;

/// Returns a vision sensor at (0, 0, 1) that faces along x with z up, with 16 x 12 pixels and a range of 0.5 to 2.5 m.
fn camera(script: &str) -> String {
    format!(
        "[[object]]\nkind = \"sensor\"\nalias = \"eye\"\nsensor = \"depth_camera\"\ncolumns = 16\nrows = 12\n\
         near_m = 0.5\nfar_m = 2.5\nposition_m = [0, 0, 1]\norientation_deg = [0, 90, 90]\n\
         script = {{ text = '''\n{script}\n''' }}\n"
    )
}

/// Runs scripts of the camera in front of a wall whose face is at 1 m and fills the lower half of the image.
fn see(script: &str) -> RunOutput {
    let wall = cuboid("wall", [0.02, 6.0, 3.0], [1.01, 0.0, -0.5], "");
    TestFolder::scene(&format!("{}{wall}", camera(script))).run(&["--steps", "3"])
}

/// Rows are stored from the bottom to the top. The normalised depth of the wall is (1 - 0.5) / (2.5 - 0.5) = 0.25.
#[test]
fn depths_begin_at_the_bottom() {
    see("function sysCall_init() eye = sim.getObject('/eye') end
         function sysCall_sensing()
            local all, size = sim.getVisionSensorDepth(eye)
            assert(size[1] == 16 and size[2] == 12 and #all == 4 * 16 * 12)
            local z = sim.unpackFloatTable(all)
            for i = 1, #z do
                local wanted = i <= 16 * 6 and 0.25 or 1
                if math.abs(z[i] - wanted) > 1e-5 then error(i .. ': ' .. z[i]) end
            end
            local m = sim.unpackFloatTable((sim.getVisionSensorDepth(eye, 1)))
            assert(math.abs(m[1] - 1) < 1e-5 and math.abs(m[192] - 2.5) < 1e-5)
            local part, s = sim.getVisionSensorDepth(eye, 0, {3, 5}, {2, 2})
            part = sim.unpackFloatTable(part)
            assert(s[1] == 2 and s[2] == 2 and #part == 4)
            assert(math.abs(part[2] - 0.25) < 1e-5 and part[3] == 1)
            assert(not pcall(sim.getVisionSensorDepth, eye, 0, {15, 0}, {2, 1}))
            assert(sim.getVisionSensorRes(eye)[2] == 12)
         end")
    .good();
}

#[test]
fn old_names_return_tables() {
    see("if sim_call_type == sim_childscriptcall_initialization then
            eye = simGetObjectHandle('eye')
            if simReadVisionSensor(eye) ~= -1 then error('never handled') end
            local z = simGetVisionSensorDepthBuffer(eye)
            if #z ~= 192 or z[1] ~= 1 then error('before') end
         end
         if sim_call_type == sim_childscriptcall_sensing then
            local z = simGetVisionSensorDepthBuffer(eye)
            if #z ~= 192 or math.abs(z[1] - 0.25) > 1e-5 or z[192] ~= 1 then error('depth') end
            local packed = simUnpackFloats(simGetVisionSensorDepthBuffer(eye + sim_handleflag_codedstring))
            if #packed ~= 192 or packed[1] ~= z[1] then error('packed') end
            local image = simGetVisionSensorImage(eye)
            if #image ~= 3 * 192 or image[1] <= 0 or image[1] > 1 or image[3 * 192] ~= 0 then error('image') end
            local grey = simGetVisionSensorImage(eye + sim_handleflag_greyscale, 0, 0, 4, 2)
            if #grey ~= 8 then error('grey') end
            local bytes, w, h = simGetVisionSensorCharImage(eye, 0, 0, 0, 0, 0.5)
            if w ~= 16 or h ~= 12 or #bytes ~= 4 * 192 then error('bytes') end
            if bytes:byte(4) ~= 255 or bytes:byte(4 * 192) ~= 0 then error('alpha') end
            if simGetVisionSensorResolution(eye)[1] ~= 16 then error('resolution') end
         end")
    .good();
}

/// Half of the depths are 0.25 and half are 1, so the mean is 0.625. Intensities are between the values of the colours.
#[test]
fn the_packet_of_fifteen() {
    see("function sysCall_init() eye = sim.getObject('/eye') end
         function sysCall_sensing()
            local result, p = sim.readVisionSensor(eye)
            if result ~= 0 or #p ~= 15 then error('shape') end
            local function near(a, b) return math.abs(a - b) < 1e-5 end
            if not (near(p[5], 0.25) and near(p[10], 1) and near(p[15], 0.625)) then error(table.concat(p, ' ')) end
            local image, sum = sim.getVisionSensorImg(eye), {0, 0, 0}
            for i = 1, #image do sum[(i - 1) % 3 + 1] = sum[(i - 1) % 3 + 1] + image:byte(i) / 255 / 192 end
            for k = 1, 3 do if not near(p[11 + k], sum[k]) then error('mean of colour ' .. k) end end
            if not near(p[11], (sum[1] + sum[2] + sum[3]) / 3) then error('mean intensity') end
            if p[1] ~= 0 or p[6] < p[11] then error('extremes') end
            local n, q = sim.handleVisionSensor(eye)
            if n ~= 0 then error('count') end
            for k = 1, 15 do if p[k] ~= q[k] then error('handled otherwise') end end
            sim.resetVisionSensor(eye)
            if sim.readVisionSensor(eye) ~= -1 then error('reset') end
         end")
    .good();
}

/// Detection can be restricted to one entity. If this is not the wall, nothing is detected.
#[test]
fn detection_can_be_restricted_to_one_entity() {
    see("function sysCall_sensing()
            local eye = sim.getObject('/eye')
            local r, p = sim.checkVisionSensor(eye, sim.getObject('/wall'))
            if r ~= 0 or math.abs(p[5] - 0.25) > 1e-5 then error('the wall') end
            local z = sim.checkVisionSensorEx(eye, eye, false)
            for i = 1, 192 do if z[i] ~= 1 then error('nothing') end end
            if #sim.checkVisionSensorEx(eye, sim.handle_all, true) ~= 3 * 192 then error('image') end
         end")
    .good();
}

/// The numbered parameters are 1000 near, 1001 far, 1002 and 1003 resolution, 1004 angle, 1005 size
/// (tests/facts/script-api.md, 4).
#[test]
fn parameters_by_number() {
    see("function sysCall_sensing()
            local eye = sim.getObject('/eye')
            if sim.getObjectType(eye) ~= 9 then error('type') end
            if #sim.getObjectsInTree(sim.handle_scene, 9) ~= 1 then error('list') end
            local function float(n) return sim.getObjectFloatParam(eye, n) end
            if float(1000) ~= 0.5 or float(sim.visionfloatparam_far_clipping) ~= 2.5 then error('planes') end
            if math.abs(float(1004) - math.rad(57)) > 1e-9 then error('angle') end
            if sim.getObjectInt32Param(eye, 1002) ~= 16 or sim.getObjectInt32Param(eye, 1003) ~= 12 then error('size') end
            sim.setObjectFloatParam(eye, 1001, 4.5)
            sim.setObjectInt32Param(eye, 1002, 8)
            sim.setObjectInt32Param(eye, 1003, 6)
            sim.handleVisionSensor(eye)
            local z, size = sim.getVisionSensorDepth(eye)
            if size[1] ~= 8 or size[2] ~= 6 then error('resolution') end
            if math.abs(sim.unpackFloatTable(z)[1] - 0.125) > 1e-5 then error('far') end
            sim.setObjectFloatParam(eye, 1001, 2.5)
            sim.setObjectInt32Param(eye, 1002, 16)
            sim.setObjectInt32Param(eye, 1003, 12)
         end")
    .good();
}

/// `sysCall_vision` gets its arguments, and its return value takes effect.
#[test]
fn the_vision_callback_has_its_arguments_and_results() {
    see("function sysCall_init() eye = sim.getObject('/eye') end
         function sysCall_vision(d)
            assert(d.handle == eye and d.resolution[1] == 16 and d.resolution[2] == 12)
            assert(d.clippingPlanes[1] == 0.5 and d.clippingPlanes[2] == 2.5)
            assert(math.abs(d.viewAngle - math.rad(57)) < 1e-9 and d.perspectiveOperation == true)
            return {trigger = true, packedPackets = {sim.packFloatTable({1, 2.5}), sim.packFloatTable({7})}}
         end
         function sysCall_trigger(d)
            triggered = (triggered or 0) + 1
            assert(d.handle == eye and sim.unpackFloatTable(d.packedPackets[1])[2] == 2.5)
         end
         function sysCall_actuation()
            local n, p, a, b = sim.handleVisionSensor(eye)
            if n ~= 1 or #p ~= 15 or a[2] ~= 2.5 or b[1] ~= 7 then error('handled') end
            if not triggered then error('not triggered') end
            local r, q, c = sim.readVisionSensor(eye)
            if r ~= 1 or c[1] ~= 1 then error('read') end
         end")
    .good();
}

/// In the sensing stage `sysCall_vision` is called automatically, before `sysCall_sensing`.
#[test]
fn the_vision_callback_is_called_before_sensing() {
    let wall = cuboid("wall", [0.02, 6.0, 3.0], [1.01, 0.0, -0.5], "");
    let told = "function sysCall_trigger(d)
                    if math.abs(d.detectedPoint[3] - 1) > 1e-6 or d.detectedObjectHandle ~= sim.getObject('/wall') then
                        error('detected otherwise')
                    end
                    sim.addStatusbarMessage('sonar')
                end";
    let sonar = format!(
        "[[object]]\nkind = \"sensor\"\nalias = \"sonar\"\nsensor = \"proximity\"\nrange_m = 4\n\
         position_m = [0, 0, 0.5]\norientation_deg = [0, 90, 0]\nscript = {{ text = '''\n{told}\n''' }}\n"
    );
    let eye = camera(
        "function sysCall_vision(d) sim.addStatusbarMessage('image') return {trigger = true} end
         function sysCall_trigger(d) sim.addStatusbarMessage('trigger') end
         function sysCall_sensing()
            local n = sim.readVisionSensor(sim.getObject('/eye'))
            sim.addStatusbarMessage('sensing ' .. n)
         end",
    );
    let lines = TestFolder::scene(&format!("{eye}{sonar}{wall}")).trace(&[], &["--steps", "2"]);
    for line in &lines[..2] {
        assert_eq!(line.status(), ["image", "trigger", "sonar", "sensing 1"]);
    }
}

/// An image set by a script replaces the captured one until the next one is captured.
#[test]
fn images_from_elsewhere() {
    see("function sysCall_init() eye = sim.getObject('/eye') end
         function sysCall_vision(d) return {trigger = sim.getVisionSensorImg(eye):byte(2) == 7} end
         function sysCall_sensing()
            local mine = string.char(5, 7, 9):rep(192)
            if sim.setVisionSensorImg(eye, mine) ~= 1 then error('trigger') end
            if sim.getVisionSensorImg(eye) ~= mine then error('image') end
            sim.setVisionSensorImg(eye, string.char(0, 0, 0):rep(4), 0, {2, 1}, {2, 2})
            local now = sim.getVisionSensorImg(eye)
            local at = 3 * (16 + 2)
            if now:byte(at) ~= 9 or now:byte(at + 1) ~= 0 or now:byte(at + 7) ~= 5 then error('part') end
            if pcall(sim.setVisionSensorImg, eye, 'short') then error('short') end
            sim.handleVisionSensor(eye)
            if sim.getVisionSensorImg(eye) == mine then error('it stays') end
         end")
    .good();
}

/// A scanner as in the models of 2015 converts depths to coordinates (filter 35), which scripts read as `r, t, u`. For
/// a wall at 1 m in front of 16 columns, x = slope * 1 m and z = 1 m in the middle row of three.
#[test]
fn chains_of_filters_return_coordinates() {
    let wall = cuboid("wall", [0.02, 6.0, 6.0], [1.01, 0.0, 1.0], "");
    let eye = camera(
        "if sim_call_type == sim_childscriptcall_sensing then
            local r, t, u = simReadVisionSensor(simGetObjectHandle('eye'))
            if r ~= 0 or #t ~= 15 or u[1] ~= 4 or u[2] ~= 3 or #u ~= 2 + 4 * 12 then error('shape') end
            local f = 8 / math.tan(math.rad(57) / 2)
            for j = 0, 2 do
                for i = 0, 3 do
                    local w = 2 + 4 * (j * u[1] + i)
                    local x, y = (6 - 4 * i) / f, (4 * j - 4) / f
                    local d = math.sqrt(x * x + y * y + 1)
                    if math.abs(u[w + 1] - x) > 1e-4 or math.abs(u[w + 2] - y) > 1e-4 or math.abs(u[w + 3] - 1) > 1e-4
                        or math.abs(u[w + 4] - d) > 1e-4 then
                        error(i .. ' ' .. j .. ': ' .. u[w + 1] .. ' ' .. u[w + 2] .. ' ' .. u[w + 3])
                    end
                end
            end
            if simGetVisionSensorFilter(simGetObjectHandle('eye'), 1) ~= 35 then error('type') end
         end",
    )
    .replace("script =", "data = { \"vision.filters\" = \"2;35::0:4,3;38\" }\nscript =");
    TestFolder::scene(&format!("{eye}{wall}")).run(&["--steps", "3"]).good();
}

/// A script of 2015 writes the depths of a Kinect when the key w is pressed. Its code is 119, and 6 is the message of a
/// key (tests/facts/script-api.md, 5). The wall fills the lower half of the image at a normalised depth of 0.25.
#[test]
fn a_key_captures_depths_and_colours() {
    let wall = cuboid("wall", [0.02, 6.0, 3.0], [1.01, 0.0, -0.5], "");
    let capture = "
        if (sim_call_type==sim_childscriptcall_initialization) then
            eye=simGetObjectHandle('eye')
            simSetObjectFloatParameter(eye,sim_visionfloatparam_far_clipping,2.5)
        end
        if (sim_call_type==sim_childscriptcall_sensing) then
            message,data=simGetSimulatorMessage()
            while message~=-1 do
                if message==sim_message_keypress and data[1]==119 then
                    local res=simGetVisionSensorResolution(eye)
                    local depth=simGetVisionSensorDepthBuffer(eye)
                    local file=io.open('depth.txt','w')
                    for row=res[2],1,-1 do
                        local line={}
                        for column=1,res[1] do
                            table.insert(line,string.format('%.3f',depth[(row-1)*res[1]+column]))
                        end
                        file:write(table.concat(line,' ')..'\\n')
                    end
                    file:close()
                    local image=simGetVisionSensorCharImage(eye)
                    if simSaveImage(image,res,0,'color.png',-1)~=1 then error('not saved') end
                    simAddStatusbarMessage('captured')
                end
                message,data=simGetSimulatorMessage()
            end
        end";
    let place = TestFolder::scene(&format!("{}{wall}", camera(capture)));
    place.write("keys.txt", "0.1 w\n0.2 x\n");
    let lines = place.trace(&[], &["--steps", "8", "--keys", "keys.txt"]);
    let told: Vec<usize> = (0..lines.len()).filter(|i| lines[*i].status() == ["captured"]).collect();
    assert_eq!(told, [2]);
    let rows: Vec<String> = place.read("depth.txt").lines().map(str::to_owned).collect();
    assert_eq!(rows.len(), 12);
    assert!(rows[..6].iter().all(|r| *r == ["1.000"; 16].join(" ")), "{rows:?}");
    assert!(rows[6..].iter().all(|r| *r == ["0.250"; 16].join(" ")), "{rows:?}");
    let png = std::fs::read(place.path().join("color.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
}

/// `tatu.read` and `tatu.save` give the same image, as numbers and as files. Files are upright, in whole millimetres.
#[test]
fn readings_as_tables_and_files() {
    let place = TestFolder::scene(&format!(
        "{}{}",
        camera(
            "function sysCall_sensing()
                local eye = sim.getObject('/eye')
                local r = tatu.read(eye)
                assert(r.rows == 12 and r.columns == 16 and #r.depth == 4 * 192 and #r.rgb == 3 * 192)
                assert(r.time == sim.getSimulationTime() and r.sequence >= 1 and r.parallel == 0)
                assert(r.limits[1] == 0.5 and r.limits[2] == 2.5 and #r.points == 0)
                assert(math.abs(string.unpack('<f', r.depth) - 1) < 1e-3)
                assert(string.unpack('<f', r.depth, 4 * 191 + 1) == math.huge)
                tatu.save(eye, 'depth', 'depth.pgm')
                tatu.save(eye, 'depth_image.depth', 'depth.png')
                tatu.save(eye, 'rgb', 'color.ppm')
                tatu.save(eye, 'depth', 'depth.raw')
                assert(not pcall(tatu.save, eye, 'depth', 'depth.ppm'))
                assert(not pcall(tatu.save, eye, 'deep', 'depth.png'))
                assert(not pcall(tatu.save, eye, 'depth', '../depth.png'))
             end"
        ),
        cuboid("wall", [0.02, 6.0, 3.0], [1.01, 0.0, -0.5], "")
    ));
    place.run(&["--steps", "2"]).good();
    let file = |name: &str| std::fs::read(place.path().join(name)).unwrap();
    let pgm = file("depth.pgm");
    assert!(pgm.starts_with(b"P5\n16 12\n65535\n"));
    // The upper half is empty; the wall is at 1000 mm in the lower half.
    let data = &pgm[pgm.len() - 2 * 192..];
    let mm = |i: usize| u16::from_be_bytes([data[2 * i], data[2 * i + 1]]);
    assert_eq!((mm(0), mm(95), mm(96), mm(191)), (0, 0, 1000, 1000));
    let ppm = file("color.ppm");
    assert!(ppm.starts_with(b"P6\n16 12\n255\n") && ppm.len() == 13 + 3 * 192);
    assert!(ppm[13..16] == [0, 0, 0] && ppm[ppm.len() - 1] > 0);
    assert_eq!(file("depth.raw").len(), 4 * 192);
    assert!(file("depth.png").starts_with(b"\x89PNG"));
}

#[test]
fn objects_other_than_vision_sensors_are_refused() {
    let errors = see("function sysCall_sensing() sim.readVisionSensor(sim.getObject('/wall')) end").errors();
    assert!(errors[0].to_string().contains("is not a vision sensor"), "{errors:?}");
}

/// Six cameras of 90 degrees at one place, with walls around them at different distances: the panorama shows each wall
/// in its direction, from left to right and from the bottom to the top.
#[test]
fn six_sensors_make_an_image_of_all_around() {
    let mut scene = String::new();
    let eye = |alias: &str, sides: [u32; 2], orientation: [i32; 3]| {
        format!(
            "[[object]]\nkind = \"sensor\"\nalias = \"{alias}\"\nsensor = \"depth_camera\"\ncolumns = {}\nrows = {}\n\
             perspective_angle_deg = 90\nnear_m = 0.1\nfar_m = 10.1\norientation_deg = {orientation:?}\n",
            sides[0], sides[1]
        )
    };
    // The z axis is the viewing direction, and y points up in the image. In the world, +x is ahead, +y left, +z up.
    for (alias, orientation) in [
        ("front", [0, 90, 90]),
        ("top", [0, 0, -90]),
        ("back", [0, -90, -90]),
        ("bottom", [180, 0, -90]),
        ("left", [-90, 0, 180]),
        ("right", [90, 0, 0]),
    ] {
        scene += &eye(alias, [33, 33], orientation);
    }
    scene += &eye("all", [9, 5], [0, 0, 0]);
    scene += &eye("far", [9, 5], [0, 0, 0]);
    for (alias, size, at) in [
        ("ahead", [0.02, 40.0, 40.0], [1.01, 0.0, 0.0]),
        ("leftward", [40.0, 0.02, 40.0], [0.0, 2.01, 0.0]),
        ("behind", [0.02, 40.0, 40.0], [-3.01, 0.0, 0.0]),
        ("rightward", [40.0, 0.02, 40.0], [0.0, -4.01, 0.0]),
        ("above", [40.0, 40.0, 0.02], [0.0, 0.0, 5.01]),
        ("below", [40.0, 40.0, 0.02], [0.0, 0.0, -6.01]),
    ] {
        scene += &cuboid(alias, size, at, "");
    }
    scene += &watcher(
        "script",
        "simVision = require 'simVision'
        function sysCall_sensing()
            local six = {}
            for i, name in ipairs{'front', 'top', 'back', 'bottom', 'left', 'right'} do six[i] = sim.getObject('/' .. name) end
            local all, far = sim.getObject('/all'), sim.getObject('/far')
            assert(simVision.handleSpherical(all, six, 2 * math.pi, math.pi, far) == 1)
            local grey = sim.getVisionSensorImg(far)
            -- Distances in m, 0.1 to 10.1 in 255 levels; columns and rows are 45 degrees apart.
            local function at(column, row) return 0.1 + grey:byte(3 * (9 * row + column) + 1) / 255 * 10 end
            local function near(x, y) if math.abs(x - y) > 0.03 then error(x .. ' is not ' .. y, 2) end end
            near(at(4, 2), 1)
            near(at(2, 2), 2)
            near(at(0, 2), 3)
            near(at(8, 2), 3)
            near(at(6, 2), 4)
            near(at(4, 4), 5)
            near(at(4, 0), 6)
            -- At 45 degrees the distance is greater by the square root of 2.
            near(at(4, 3), math.sqrt(2))
            -- Angles that the front sensor alone covers: the other sensors are not measured.
            sim.resetVisionSensor(six[3])
            assert(simVision.handleSpherical(-1, six, math.pi / 3, 0.1, far) == 1)
            assert(sim.readVisionSensor(six[3]) == -1)
            local function why(...) local ok, e = pcall(simVision.handleSpherical, ...) assert(not ok) return e end
            assert(why(-1, six, 1, 1):find('both are %-1'))
            assert(why(all, {1}, 1, 1):find('6 numbers'))
            assert(why(all, six, 1, 1, six[1]):find('33 x 33: expected equal sizes'))
        end",
    );
    TestFolder::scene(&scene).run(&["--steps", "2"]).good();
}
