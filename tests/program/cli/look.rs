//! Tests of pictures of scenes and sensors: the expected pixels follow from the camera, the lamp and the scene.

use std::{fs, path::Path};

use crate::kit::*;

/// A picture written by the program.
struct Picture {
    columns: usize,
    rows: usize,
    rgb: Vec<u8>,
}

impl Picture {
    fn open(file: &Path) -> Self {
        let mut reader = png::Decoder::new(fs::File::open(file).unwrap()).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size()];
        let info = reader.next_frame(&mut rgb).unwrap();
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
        Picture { columns: info.width as usize, rows: info.height as usize, rgb }
    }
    fn at(&self, column: usize, row: usize) -> [u8; 3] {
        let i = (row * self.columns + column) * 3;
        [self.rgb[i], self.rgb[i + 1], self.rgb[i + 2]]
    }
    fn grey(&self, [x, y]: [f64; 2]) -> f64 {
        self.at(x as usize, y as usize).iter().map(|c| f64::from(*c)).sum::<f64>() / 3.0
    }
    fn grey_at(&self, column: usize, row: usize) -> u8 {
        (self.at(column, row).iter().map(|c| u32::from(*c)).sum::<u32>() / 3) as u8
    }
    fn is_red(&self, column: usize, row: usize) -> bool {
        let [r, g, b] = self.at(column, row).map(i32::from);
        r > 100 && r > 2 * g && r > 2 * b
    }
    /// Returns whether the picture has at least this number of colours.
    fn is_colorful(&self, least: usize) -> bool {
        let mut all: Vec<&[u8]> = self.rgb.chunks_exact(3).collect();
        all.sort_unstable();
        all.dedup();
        all.len() >= least
    }
}

impl TestFolder {
    /// Runs `tatu look scene.toml`, which writes `out.png`.
    fn look(&self, args: &[&str]) -> RunOutput {
        self.tatu(&[&["look", "scene.toml", "-o", "out.png"], args].concat())
    }
    fn picture(&self, args: &[&str]) -> Picture {
        self.look(args).good();
        Picture::open(&self.path().join("out.png"))
    }
}

/// Returns the number of red pixels, and whether some are at the edge.
fn red(picture: &Picture) -> (usize, bool) {
    let all = (0..picture.rows).flat_map(|r| (0..picture.columns).map(move |c| (c, r)));
    let red: Vec<_> = all.filter(|(c, r)| picture.is_red(*c, *r)).collect();
    let edge = |(c, r): &(usize, usize)| *c == 0 || *r == 0 || c + 1 == picture.columns || r + 1 == picture.rows;
    (red.len(), red.iter().any(edge))
}

#[test]
fn a_camera_that_sees_less_than_half_of_the_scene_is_not_used() {
    let camera = "[[object]]\nkind = \"camera\"\nalias = \"eye\"\nposition_m = [-2.0, 0.0, 0.5]\norientation_deg = [0, 90, 90]\n";
    let at = |y: f64| cuboid(&format!("box{}", y.abs()), [0.4, 0.4, 0.4], [0.0, y, 0.5], RED);
    // The boxes at 5 and 6 m to the right are outside of the camera's view.
    for (boxes, wanted) in
        [(&[0.0, -5.0, -6.0][..], "less than half"), (&[0.0, 0.5, -5.0], "shows the view of the camera")]
    {
        let place = TestFolder::scene(&format!("{}{camera}", boxes.iter().map(|y| at(*y)).collect::<String>()));
        let done = place.look(&["--size", "160x90"]).good();
        assert!(done.err.contains(wanted), "{}", done.err);
        if wanted == "less than half" {
            assert!(!red(&Picture::open(&place.path().join("out.png"))).1, "all boxes are in the picture");
        }
    }
}

/// Without `--from` the scene's camera is used. If there is none, the view is chosen so that it contains all objects.
#[test]
fn a_picture_uses_the_camera_of_the_scene_or_shows_all_objects() {
    for (at, size) in [([0.0; 3], 1.0), ([40.0, -7.0, 3.0], 0.1), ([-5.0, 2.0, -9.0], 30.0)] {
        let place = TestFolder::scene(&cuboid("box", [size, size / 2.0, size], at, RED));
        for args in [&["--size", "160x90"][..], &["--size", "60x120", "--fov", "80"]] {
            let picture = place.picture(args);
            let (red, edge) = red(&picture);
            assert!(!edge && red * 20 > picture.rows * picture.columns, "{at:?}: {red}");
        }
    }
    // At a distance of 1 m, a field of view of 60 degrees is 2 * 0.577 m wide, so the box, 1 m wide, covers 104 of 120
    // pixels.
    let camera = "[[object]]\nkind = \"camera\"\nalias = \"eye\"\nposition_m = [-2.0, 0.0, 0.5]\norientation_deg = [0, 90, 90]\n";
    let place = TestFolder::scene(&format!("{}{camera}", cuboid("box", [2.0, 1.0, 0.4], [0.0, 0.0, 0.5], RED)));
    let done = place.look(&["--size", "120x60"]).good();
    done.reports(&["/eye"]);
    let picture = Picture::open(&place.path().join("out.png"));
    let row = |r: usize| (0..picture.columns).filter(|c| picture.is_red(*c, r)).count();
    assert!((102..=106).contains(&row(30)), "{}", row(30));
}

/// The floor that is added to the picture hides no object, and can be left out.
#[test]
fn the_added_floor_hides_no_object() {
    let place = TestFolder::scene(&cuboid("box", [1.0; 3], [0.0; 3], RED));
    let args = ["--from", "0,-6,1", "--to", "0,0,0", "--size", "120x90", "--fov", "30"];
    let with = place.picture(&args);
    let without = place.picture(&[&args[..], &["--no-ground"]].concat());
    // With the floor, as much of the box is visible as without it, apart from blended edges.
    let (with_red, without_red) = (red(&with).0, red(&without).0);
    assert!(with_red.abs_diff(without_red) * 10 < without_red && with_red > 600, "{with_red} {without_red}");
    assert_ne!(with.at(2, 88), without.at(2, 88));
}

const RED: &str = "color = [1.0, 0.0, 0.0]";

#[test]
fn a_picture_has_its_size_and_is_the_same_on_any_number_of_threads() {
    let place = TestFolder::scene(&format!("{FLOOR}{}", pioneer("", "")));
    let args = ["--from", "-1,-1,0.8", "--to", "0,0,0.1", "--size", "160x90", "--at", "0.1"];
    let one = place.picture(&[&args[..], &["--threads", "1"]].concat());
    let bytes = fs::read(place.path().join("out.png")).unwrap();
    assert_eq!((one.columns, one.rows), (160, 90));
    assert!(one.is_colorful(200));
    place.look(&[&args[..], &["--threads", "2"]].concat()).good();
    assert!(bytes == fs::read(place.path().join("out.png")).unwrap(), "the picture depends on the number of threads");
}

#[test]
fn a_box_is_where_geometry_says() {
    // 120 pixels wide at 60 degrees: 60 / tan(30 degrees) = 103.9 pixels at distance 1. The front of the box, 3 m away
    // and 1 m wide and high, reaches 103.9 / 3 * 0.5 = 17.3 pixels to each side of the centre.
    let place = TestFolder::scene(&format!("{FLOOR}{}", cuboid("box", [1.0; 3], [0.5, 0.0, 1.0], RED)));
    let picture = place.picture(&["--from", "-3,0,1", "--to", "0,0,1", "--size", "120x80", "--fov", "60"]);
    for (dx, dy) in [(0, 0), (15, 15), (-16, 15), (15, -16), (-16, -16)] {
        assert!(picture.is_red((60 + dx) as usize, (40 + dy) as usize), "{dx} {dy}");
    }
    for (dx, dy) in [(19, 0), (-20, 0), (0, 19), (0, -20), (19, 19)] {
        assert!(!picture.is_red((60 + dx) as usize, (40 + dy) as usize), "{dx} {dy}");
    }
    // Above the horizon the sky is bluish; the floor below is grey.
    let ([r, _, b], [fr, fg, fb]) = (picture.at(5, 2), picture.at(60, 78));
    assert!(b > r && fr.abs_diff(fg) < 20 && fg.abs_diff(fb) < 20, "{r} {b} {fr} {fg} {fb}");
    // When the camera looks along +x, +y is to the left in the picture.
    let place = TestFolder::scene(&format!("{FLOOR}{}", cuboid("box", [0.5; 3], [0.0, 0.6, 1.0], RED)));
    let picture = place.picture(&["--from=-3,0,1", "--to=0,0,1", "--size=120x80", "--fov=60"]);
    // The centre of the box is 103.9 * 0.6 / 3 = 20.8 pixels to the left.
    assert!(picture.is_red(60 - 21, 40) && !picture.is_red(60 + 21, 40));
}

#[test]
fn a_shadow_is_where_the_lamp_throws_it() {
    // The lamp is in the direction (0.3, -0.6, 1): docs/guide/pictures.md. A plate 0.4 m wide, 1 m up, casts its shadow
    // around (-0.3, 0.6) on the floor.
    let scene = format!("{FLOOR}{}", cuboid("plate", [0.4, 0.4, 0.02], [0.0, 0.0, 1.0], RED));
    let place = TestFolder::scene(&scene);
    let picture = place.picture(&["--from", "0,0,4", "--to", "0,0,0", "--size", "200x200", "--fov", "60"]);
    // Seen from above, x is right and y up: 100 / tan(30 degrees) / 4 = 43.3 pixels per metre on the floor.
    let at = |x: f64, y: f64| picture.grey([100.0 + 43.3 * x, 100.0 - 43.3 * y]);
    let lit = at(0.35, -0.65);
    for (x, y) in [(-0.3, 0.6), (-0.16, 0.46), (-0.16, 0.74), (-0.44, 0.74), (-0.44, 0.46)] {
        assert!(at(x, y) < 0.75 * lit, "{x} {y}: {} in the shadow, {lit} in the light", at(x, y));
    }
    for (x, y) in [(-0.3, 0.34), (-0.3, 0.86), (-0.04, 0.6), (-0.56, 0.6)] {
        assert!(at(x, y) > 0.9 * lit, "{x} {y}: {} in the light, {lit} elsewhere", at(x, y));
    }
}

#[test]
fn the_scene_is_shown_as_it_is_at_a_time() {
    let ball = "[[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\nsize_m = [0.3, 0.3, 0.3]\n\
                dynamic = true\nposition_m = [0, 0, 2]\ncolor = [1.0, 0.0, 0.0]\n";
    let place = TestFolder::scene(&format!("{FLOOR}{ball}"));
    let look =
        |at: &str| place.picture(&["--from", "-4,0,1", "--to", "0,0,1", "--size", "120x80", "--fov", "60", "--at", at]);
    // At 103.9 / 4 = 26 pixels per metre, the box at 2 m is 26 pixels above the centre; after falling by 1.23 m in 0.5
    // s, it is 6 pixels below.
    let (before, after) = (look("0"), look("0.5"));
    assert!(before.is_red(60, 40 - 26) && !before.is_red(60, 40 + 6));
    assert!(after.is_red(60, 40 + 6) && !after.is_red(60, 40 - 26));
}

#[test]
fn hidden_objects_are_left_out_and_drawings_are_shown() {
    let drawer = watcher(
        "drawer",
        "function sysCall_init()
            local d = sim.addDrawingObject(sim.drawing_spherepoints, 0.3, 0, -1, 10, {1, 0, 0})
            sim.addDrawingObjectItem(d, {0, 0, 1})
        end",
    );
    let hidden = cuboid("ghost", [0.4; 3], [0.0, 1.0, 1.0], &format!("{RED}\nvisible = false"));
    let place = TestFolder::scene(&format!("{FLOOR}{hidden}{drawer}"));
    let args = ["--from", "-4,0,1", "--to", "0,0,1", "--size", "120x80", "--fov", "60", "--at", "0.1"];
    let picture = place.picture(&args);
    assert!(picture.is_red(60, 40), "the drawing is missing");
    assert!(!picture.is_red(60 - 26, 40), "a hidden object is shown");
}

#[test]
fn a_proximity_picture_marks_the_detected_point() {
    let scene = format!(
        "{}[[object]]\nkind = \"sensor\"\nsensor = \"proximity\"\nalias = \"feeler\"\nposition_m = [0, 0, 0.3]\n\
         orientation_deg = [0, 90, 0]\nrange_m = 1\n",
        cuboid("wall", [0.1, 1.0, 1.0], [0.8, 0.0, 0.3], "")
    );
    let place = TestFolder::scene(&scene);
    let picture = place.picture(&["--sensor", "/feeler"]);
    assert!(picture.columns > 800 && picture.rows > 400 && picture.is_colorful(100));
    // A red ball marks the detected point.
    assert!((0..picture.rows).any(|y| (0..picture.columns).any(|x| picture.is_red(x, y))));
    let again = fs::read(place.path().join("out.png")).unwrap();
    place.look(&["--sensor", "feeler", "--threads", "2"]).good();
    assert!(again == fs::read(place.path().join("out.png")).unwrap());
}

/// Returns a sensor at a height of 0.5 m that faces along the world's +x axis: its +z points forward, +y up, +x left.
fn sensor(kind: &str, more: &str) -> String {
    format!(
        "[[object]]\nkind = \"sensor\"\nsensor = \"{kind}\"\nalias = \"eye\"\nposition_m = [0, 0, 0.5]\n\
         quaternion = [0.5, 0.5, 0.5, 0.5]\n{more}\n"
    )
}

#[test]
fn a_scan_shows_a_wall_on_the_left_at_the_left() {
    // The only wall is to the left, 2 m away and 4 m long. Of 181 beams, 1 degree apart, it is hit by the 46 between 45
    // and 90 degrees.
    let wall = cuboid("wall", [4.0, 0.2, 1.0], [0.0, 2.1, 0.5], "");
    let place = TestFolder::scene(&format!("{wall}{}", sensor("laser", "range_m = 5")));
    let picture = place.picture(&["--sensor", "eye"]);
    let all = (0..picture.rows).flat_map(|y| (0..picture.columns).map(move |x| (x, y)));
    let dots: Vec<(usize, usize)> = all.filter(|(x, y)| picture.is_red(*x, *y)).collect();
    assert!(dots.len() > 46, "{} red pixels", dots.len());
    // In the picture, the visible wall is a vertical line to the left of the centre, which starts beside the sensor and
    // ends at 45 degrees. Its length therefore equals its distance.
    let range =
        |f: fn(&(usize, usize)) -> usize| (dots.iter().map(f).min().unwrap(), dots.iter().map(f).max().unwrap());
    let ((left, right), (top, bottom)) = (range(|d| d.0), range(|d| d.1));
    assert!(right < picture.columns / 2 && right - left < 8, "from {left} to {right}");
    // Beams without a hit are drawn with 1.15 times the distance of the farthest hit (2.83 m), which is 3.25 m. They
    // extend 3.25 m to the right and, at 44 degrees, 2.26 m to the left. These 5.51 m are 720 pixels wide, so the 2 m
    // of wall ahead of the sensor are 261 pixels long.
    assert!((bottom - top).abs_diff(261) < 6, "{top} to {bottom}");
}

#[test]
fn near_pixels_of_a_depth_image_are_bright_and_colours_are_beside_it() {
    // With 64 x 48 pixels and 57 degrees, 1 m at a distance of 1 m covers 32 / tan(28.5 degrees) = 58.9 pixels. The box
    // is 1 m ahead and from 0.05 to 0.55 m to the left, so it covers the columns 32 - 32.4 to 32 - 2.9 in the middle
    // rows of the image. Each pixel of the sensor is 5 pixels wide in the picture.
    let near = cuboid("box", [0.4, 0.5, 0.6], [1.2, 0.3, 0.5], RED);
    let far = cuboid("wall", [0.2, 9.0, 9.0], [3.1, 0.0, 0.5], "color = [0.2, 0.2, 1.0]");
    let place = TestFolder::scene(&format!("{near}{far}{}", sensor("depth_camera", "columns = 64\nrows = 48")));
    let picture = place.picture(&["--sensor", "eye"]);
    // The depth image starts 20 pixels from the left and 76 from the top. Its legend is 110 pixels wide, and the colour
    // image starts 20 pixels to the right of the legend.
    let (depth, color) = (20, 20 + 320 + 110 + 20);
    let middle = 76 + 120;
    let [r, g, b] = picture.at(depth + 80, middle);
    assert!(r > 200 && g > 200 && b < 100, "the near colour is {r} {g} {b}, expected yellow");
    let [r, g, b] = picture.at(depth + 240, middle);
    assert!(r < 120 && g < 60 && b > 60, "the far colour is {r} {g} {b}, expected violet");
    assert!(picture.is_red(color + 80, middle));
    let [r, _, b] = picture.at(color + 240, middle);
    assert!(b > 100 && b > 2 * r);
}

#[test]
fn any_other_sensor_is_shown_in_words() {
    let place = TestFolder::scene(&format!("{FLOOR}{}", sensor("gps", "")));
    let picture = place.picture(&["--sensor", "eye"]);
    // A title and a line for each field, dark on white.
    assert!(picture.rows > 64 + 4 * 24 && picture.columns > 300);
    let rows = (0..picture.rows).filter(|y| (0..picture.columns).any(|x| picture.grey_at(x, *y) < 128));
    assert!(rows.count() > 50);
}

#[test]
fn sensors_that_cannot_be_shown_are_refused() {
    let place = TestFolder::scene(&format!("{FLOOR}{}", pioneer("", "")));
    let from = ["--from", "-1,0,1", "--to", "0,0,0", "--size", "16x9"];
    place.look(&["--sensor", "/Pioneer_p3dx_ultrasonicSensor17"]).refused(&[
        "E110",
        "Pioneer_p3dx_ultrasonicSensor17",
        "did you mean `",
        "the scene has these sensors:",
        "Pioneer_p3dx_ultrasonicSensor16",
    ]);
    place.look(&["--sensor", "/floor"]).refused(&[
        "E110",
        "`/floor` is not a sensor",
        "Pioneer_p3dx_ultrasonicSensor1",
    ]);
    place.tatu(&[&["look", "scene.toml", "-o", "nowhere/out.png"], &from[..]].concat()).refused(&["E105", "nowhere"]);
    place.look(&["--from", "1,2,3", "--to", "1,2,3"]).refused(&["E102", "--from and --to are the same point"]);
    place.look(&["--from", "1,2", "--to", "0,0,0"]).refused(&["three numbers"]);
    place.look(&["--from", "1,2,3"]).refused(&["--to"]);
    place.look(&["--to", "1,2,3"]).refused(&["--from"]);
    place.look(&[&from[..], &["--at", "-1"]].concat()).refused(&["at least 0"]);
    place.look(&[&from[..4], &["--size", "0x10"]].concat()).refused(&["columns and rows"]);
    place.look(&[&from[..], &["--fov", "180"]].concat()).refused(&["1 to 170"]);
    let bare = TestFolder::scene(FLOOR);
    bare.look(&["--sensor", "/eye"]).refused(&["E110", "there is no sensor in this scene"]);
    assert!(!bare.path().join("out.png").exists());
}

#[test]
fn every_picture_of_the_documentation_can_be_made_again() {
    let images = root().join("docs/images");
    let script = fs::read_to_string(root().join("docs/pictures.sh")).unwrap();
    let mut count = 0;
    for entry in fs::read_dir(&images).unwrap().map(Result::unwrap) {
        let name = entry.file_name().to_string_lossy().into_owned();
        assert!(script.contains(&name), "docs/pictures.sh does not create {name}");
        let size = entry.metadata().unwrap().len();
        assert!(size < 200 * 1024, "{name} has {size} bytes");
        count += 1;
    }
    assert!(count > 2);
}
