//! Tests of textures: images of vision sensors, pictures, scene files, and invalid textures.

use crate::kit::*;

/// Returns an image of 2 x 2 squares with a side of `size` pixels: red and green above, blue and white below.
fn squares(size: u32) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, 2 * size, 2 * size);
    encoder.set_color(png::ColorType::Rgb);
    let colors = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255; 3]];
    let places = (0..2 * size).flat_map(|row| (0..2 * size).map(move |column| 2 * (row / size) + column / size));
    let pixels: Vec<u8> = places.flat_map(|i| colors[i as usize]).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    out
}

/// Returns a floor of 6 m x 6 m whose image repeats every 2 m; `more` contains further keys of the texture.
fn floor(more: &str) -> String {
    format!(
        "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nsize_m = [6, 6, 0.2]\nposition_m = [0, 0, -0.1]\n\
         color = [1, 1, 1]\ntexture = {{ image = \"squares.png\", size_m = [2, 2], smooth = false{more} }}\n"
    )
}

/// A camera 2 m above the floor, whose image of 32 x 32 pixels shows 4 m x 4 m of it. In the image +x is to the left,
/// and +y is down.
const EYE: &str = r#"
[[object]]
kind = "sensor"
alias = "eye"
sensor = "depth_camera"
columns = 32
rows = 32
perspective_angle_deg = 90
near_m = 0.1
far_m = 5
position_m = [0, 0, 2]
orientation_deg = [180, 0, 0]
script = { text = '''
function sysCall_init() eye = sim.getObject('/eye') end
function sysCall_sensing()
    local image = sim.getVisionSensorImg(eye)
    for row = 0, 31 do
        for column = 0, 31 do
            -- In squares of 1 m, from the middle of an image that has its lowest row below.
            local x, y = 2 - (column + 0.5) / 8, 2 - (row + 0.5) / 8
            local right, up = math.floor(x + 1) % 2, math.floor(y + 1) % 2
            local at = 3 * (32 * row + column)
            local seen = {}
            for i = 1, 3 do seen[i] = image:byte(at + i) > 60 and 1 or 0 end
            local names = {['00'] = '001', ['01'] = '100', ['10'] = '111', ['11'] = '010'}
            local wanted = names[right .. up]
            if table.concat(seen) ~= wanted then
                error(string.format('%g %g: %s, not %s', x, y, table.concat(seen), wanted))
            end
        end
    end
    print('all squares')
end
''' }
"#;

fn place(scene: &str) -> TestFolder {
    let place = TestFolder::scene(scene);
    std::fs::write(place.path().join("squares.png"), squares(1)).unwrap();
    place
}

#[test]
fn a_vision_sensor_sees_the_squares_where_they_are() {
    let place = place(&format!("{}{EYE}", floor("")));
    let done = place.tatu(&["run", "scene.toml", "--steps", "2"]).good();
    assert!(done.out.contains("all squares") || done.err.contains("all squares"), "{}", done.err);
    // The converted scene produces a bit-identical run.
    place.tatu(&["convert", "scene.toml", "again.toml"]).good();
    let again = place.tatu(&["run", "again.toml", "--steps", "2"]).good();
    let hash = |done: &RunOutput| done.err.split("hash ").nth(1).map(|t| t[..16].to_owned());
    assert_eq!(hash(&again), hash(&done));
    assert!(hash(&done).is_some());
}

#[test]
fn a_turned_projection_turns_the_image() {
    // If the texture is rotated by 180 degrees, red replaces white.
    let place = place(&format!("{}{EYE}", floor(", orientation_deg = [0, 0, 180]")));
    let done = place.tatu(&["run", "scene.toml", "--steps", "2"]);
    assert!(done.err.contains("not 0"), "{}", done.err);
}

#[test]
fn a_snapshot_contains_images() {
    let place = place(&format!("{}{EYE}", floor("")));
    place.run(&["--steps", "2", "--snapshot-at", "0.05", "half.snap"]).good();
    let done = place.tatu(&["run", "scene.toml", "--from", "half.snap", "--steps", "2"]).good();
    assert!(done.out.contains("all squares") || done.err.contains("all squares"), "{}", done.err);
}

/// The floor as an OBJ file with two triangles and texture coordinates.
const FLOOR: &str = "mtllib floor.mtl\nv -3 -3 0\nv 3 -3 0\nv 3 3 0\nv -3 3 0\nvt -1 -1\nvt 2 -1\nvt 2 2\nvt -1 2\n\
    usemtl tiles\nf 1/1 2/2 3/3 4/4\n";

#[test]
fn coordinates_of_a_mesh_file_place_the_image() {
    let place = TestFolder::scene(&format!("[[import]]\nfile = \"floor.obj\"\n{EYE}"));
    for (name, bytes) in [
        ("floor.obj", FLOOR.into()),
        ("floor.mtl", "newmtl tiles\nKd 1 1 1\nmap_Kd squares.png\n".into()),
        ("squares.png", squares(32)),
    ] {
        std::fs::write(place.path().join(name), bytes).unwrap();
    }
    let done = place.tatu(&["run", "scene.toml", "--steps", "2"]).good();
    assert!(done.out.contains("all squares") || done.err.contains("all squares"), "{}", done.err);
    // In a converted scene, the mesh is a PLY file with texture coordinates.
    place.tatu(&["convert", "scene.toml", "again.toml"]).good();
    let again = place.tatu(&["run", "again.toml", "--steps", "2"]).good();
    assert!(again.out.contains("all squares") || again.err.contains("all squares"), "{}", again.err);
    // `tatu look` can render a mesh file without a scene.
    place.tatu(&["look", "floor.obj", "-o", "floor.png"]).good();
}

#[test]
fn pieces_of_a_mesh_file_have_their_colors() {
    let place = TestFolder::scene(
        "[[import]]
        file = \"two.obj\"
        [[object]]
        kind = \"shape\"
        alias = \"one\"
        primitive = \"mesh\"
        mesh = \"two.obj\"
        script = { text = '''
        function sysCall_init()
            local points, triangles = sim.getShapeMesh(sim.getObject('/one'))
            assert(#points == 24 and #triangles == 12, #points .. ' ' .. #triangles)
            print('two pieces')
        end
        ''' }",
    );
    let square = |x: i32| format!("v {x} 0 0\nv {0} 0 0\nv {0} 1 0\nv {x} 1 0\n", x + 1);
    let faces = "usemtl red\nf 1 2 3 4\nusemtl green\nf 5 6 7 8\n";
    let text = format!("mtllib two.mtl\n{}{}{faces}", square(0), square(2));
    std::fs::write(place.path().join("two.obj"), text).unwrap();
    std::fs::write(place.path().join("two.mtl"), "newmtl red\nKd 1 0 0\nnewmtl green\nKd 0 1 0\n").unwrap();
    let done = place.tatu(&["run", "scene.toml", "--steps", "1"]).good();
    assert!(done.out.contains("two pieces") || done.err.contains("two pieces"), "{}", done.err);
    place.tatu(&["convert", "scene.toml", "again.toml"]).good();
    let again = place.read("again.toml");
    assert!(again.contains("color = [1.0, 0.0, 0.0]") && again.contains("color = [0.0, 1.0, 0.0]"), "{again}");
    std::fs::remove_file(place.path().join("two.mtl")).unwrap();
    let done = place.tatu(&["look", "two.obj", "-o", "two.png"]).good();
    assert!(done.err.contains("the materials in `two.mtl` are ignored"), "{}", done.err);
}

/// A floor sensor with three spots, which are above blue, white and blue squares.
#[test]
fn beams_that_report_colors_see_the_image() {
    let spots = "
        [[object]]
        kind = \"sensor\"
        alias = \"spots\"
        sensor = \"floor\"
        count = 3
        pitch_m = 1.0
        position_m = [0.5, -0.5, 0.01]
        orientation_deg = [0.0, 180.0, 0.0]
        script = { text = '''
        function sysCall_sensing()
            local v = tatu.read(sim.getObject('/spots')).value
            print(string.format('spots %.2f %.2f %.2f', v[1], v[2], v[3]))
        end
        ''' }
        ";
    let place = place(&format!("{}{spots}", floor("")));
    let done = place.tatu(&["run", "scene.toml", "--steps", "2"]).good();
    assert!(format!("{}{}", done.out, done.err).contains("spots 0.33 1.00 0.33"), "{} {}", done.out, done.err);
}

#[test]
fn errors_of_a_texture_are_reported() {
    let refused = |texture: &str| {
        let scene = format!("[[object]]\nkind = \"shape\"\nalias = \"a\"\ntexture = {texture}\n");
        let place = place(&scene);
        std::fs::write(place.path().join("bad.png"), "no image").unwrap();
        let done = place.tatu(&["run", "scene.toml", "--steps", "1"]);
        assert_eq!(done.code, 2, "{texture}");
        done.err
    };
    for (texture, told) in [
        ("{ image = \"nothing.png\" }", "cannot read the image `nothing.png`"),
        ("{ image = \"bad.png\" }", "cannot be read as an image"),
        ("{ image = \"../elsewhere.png\" }", "elsewhere.png"),
        ("{ mapping = \"box\" }", "`image` must be"),
        ("{ image = \"squares.png\", mapping = \"cube\" }", "one of plane, cylinder, sphere, box, mesh"),
        ("{ image = \"squares.png\", size_m = [0, 1] }", "`size` must be"),
        ("{ image = \"squares.png\", sise_m = [1, 1] }", "size_m"),
        ("{ image = 7 }", "image 7, but the last image is 0"),
    ] {
        let err = refused(texture);
        assert!(err.contains(told) && err.contains("scene.toml:"), "{texture}: {err}");
    }
}

#[test]
fn scripts_change_and_remove_a_texture() {
    let script = "script = { text = '''
function sysCall_init()
    local floor = sim.getObject('/floor')
    local has = tatu.get(floor, 'shape.texture')
    assert(has.image == 1 and has.smooth == false)
    assert(not pcall(tatu.set, floor, 'shape.texture', {image = 2}))
    tatu.set(floor, 'shape.texture', {})
    assert(next(tatu.get(floor, 'shape.texture')) == nil)
    tatu.set(floor, 'shape.texture', {image = 1, size = {2, 2}, smooth = false})
end
''' }
";
    // The image of the camera shows that the texture has been restored.
    let place = place(&format!("{}{script}{EYE}", floor("")));
    let done = place.tatu(&["run", "scene.toml", "--steps", "2"]).good();
    assert!(done.out.contains("all squares") || done.err.contains("all squares"), "{}", done.err);
}
