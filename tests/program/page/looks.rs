//! Compares images of the page with pictures of `tatu look` from the same camera, in a browser.

use base64::{Engine as _, engine::general_purpose::STANDARD};

use super::{pictures::RgbImage, program::PageServer};
use crate::{
    kit::browser::{BrowserPage, browser},
    kit::*,
};

/// The scenes that are shown in the guide.
const SCENES: [&str; 10] = [
    "scenes/first/pioneer_avoids_walls.toml",
    "scenes/course/kinect_capture.toml",
    "scenes/showcase/maze.toml",
    "scenes/showcase/line_following.toml",
    "scenes/showcase/conveyor_sorting.toml",
    "scenes/showcase/drone_course.toml",
    "scenes/showcase/humanoid_pushed.toml",
    "scenes/showcase/balancing.toml",
    "scenes/showcase/pick_and_place.toml",
    "scenes/showcase/quadruped_over_bumps.toml",
];

/// Converts an sRGB pixel to CIE L*a*b* with the white point of sRGB.
fn lab(pixel: [u8; 3]) -> [f64; 3] {
    let [r, g, b] = pixel.map(|x| f64::from(x) / 255.0).map(|x| match x <= 0.04045 {
        true => x / 12.92,
        false => ((x + 0.055) / 1.055).powf(2.4),
    });
    let xyz = [
        (0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047,
        0.2126729 * r + 0.7151522 * g + 0.0721750 * b,
        (0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883,
    ];
    let [x, y, z] = xyz.map(|t| if t > 0.008856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Returns two pictures of a scene, one by the page and one by `tatu look`.
fn both(scene: &str, size: [u32; 2]) -> [RgbImage; 2] {
    let served = PageServer::new(root(), &["open", scene, "--no-browser"]);
    let mut page = BrowserPage::open(&browser(), &served.url);
    page.until("document.readyState === 'complete' && (document.getElementById('name')?.textContent ?? '') !== ''");
    let [columns, rows] = size;
    // Drawings of sensors are hidden, and the size of the image does not depend on the window.
    let shown = page.js(&format!(
        "(async () => {{ const v = await import('tatu/view/renderer'); const frame = () => new Promise(requestAnimationFrame); \
         for (let i = 0; i < 100 && v.camera.position.x === 3; i++) await frame(); \
         document.getElementById('rays').click(); \
         Object.assign(v.host.style, {{ width: '{columns}px', height: '{rows}px' }}); \
         for (let i = 0; i < 100 && v.renderer.domElement.width !== {columns}; i++) await frame(); \
         v.redraw(); await frame(); await frame(); \
         return [v.camera.position.toArray(), v.controls.target.toArray(), v.camera.fov, \
         v.renderer.domElement.toDataURL('image/png').split(',')[1]]; }})()"
    ));
    let place = TestFolder::new();
    let numbers = |i: usize| {
        let all: Vec<String> = shown[i].as_array().unwrap().iter().map(|x| x.as_f64().unwrap().to_string()).collect();
        all.join(",")
    };
    let upright = (shown[2].as_f64().unwrap().to_radians() / 2.0).tan();
    let fov = 2.0 * (upright * f64::from(columns) / f64::from(rows)).atan().to_degrees();
    let out = place.path().join("look.png");
    let args = [
        format!("--from={}", numbers(0)),
        format!("--to={}", numbers(1)),
        format!("--fov={fov}"),
        format!("--size={columns}x{rows}"),
        format!("-o={}", out.display()),
    ];
    let mut look = std::process::Command::new(env!("CARGO_BIN_EXE_tatu"));
    succeed(look.current_dir(root()).args(["look", scene]).args(args));
    let png = STANDARD.decode(shown[3].as_str().unwrap()).unwrap();
    [RgbImage::read(&png), RgbImage::read(&std::fs::read(out).unwrap())]
}

/// Returns the median and the 90th percentile of the colour differences (CIE76) of the pixels.
fn difference([page, look]: &[RgbImage; 2]) -> [f64; 2] {
    assert_eq!((page.columns, page.rows), (look.columns, look.rows));
    let pixels = |p: &RgbImage| p.bytes.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect::<Vec<_>>();
    let mut all: Vec<f64> = pixels(page)
        .into_iter()
        .zip(pixels(look))
        .map(|(a, b)| lab(a).iter().zip(lab(b)).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt())
        .collect();
    all.sort_by(f64::total_cmp);
    [0.5, 0.9].map(|share| all[(share * all.len() as f64) as usize])
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn the_page_looks_like_the_pictures() {
    for scene in ["scenes/first/pioneer_avoids_walls.toml", "scenes/course/kinect_capture.toml"] {
        let [median, most] = difference(&both(scene, [480, 300]));
        assert!(median < 3.0 && most < 12.0, "{scene}: {median:.1}, {most:.1}");
    }
}

#[test]
#[ignore = "makes the picture of the guide: docs/pictures.sh"]
fn sheet_for_the_guide() {
    let (columns, rows) = (224, 140);
    let (across, down) = (4, SCENES.len().div_ceil(2));
    let mut sheet = vec![255; across * columns * down * rows * 3];
    for (i, scene) in SCENES.iter().enumerate() {
        let pair = both(scene, [columns as u32, rows as u32]);
        let [median, most] = difference(&pair);
        println!("{scene}: median {median:.1}, 90 % below {most:.1}");
        for (k, picture) in pair.iter().enumerate() {
            let (x, y) = ((2 * (i % 2) + k) * columns, i / 2 * rows);
            for row in 0..rows {
                let to = ((y + row) * across * columns + x) * 3;
                sheet[to..to + 3 * columns].copy_from_slice(&picture.bytes[3 * row * columns..][..3 * columns]);
            }
        }
    }
    let sheet = RgbImage { columns: across * columns, rows: down * rows, bytes: sheet };
    std::fs::write(root().join("docs/images/page_looks.png"), sheet.png()).unwrap();
}
