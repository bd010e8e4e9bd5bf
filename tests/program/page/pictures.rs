//! Generates the pictures of the page for the guide.

use serde_json::json;

use super::program::PageServer;
use crate::{
    kit::browser::{BrowserPage, browser},
    kit::*,
};

/// An RGB picture with 8 bits per channel.
pub struct RgbImage {
    pub columns: usize,
    pub rows: usize,
    pub bytes: Vec<u8>,
}

impl RgbImage {
    pub fn read(png: &[u8]) -> RgbImage {
        let mut reader = png::Decoder::new(png).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size()];
        let info = reader.next_frame(&mut bytes).unwrap();
        bytes.truncate(info.buffer_size());
        if info.color_type == png::ColorType::Rgba {
            bytes = bytes.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        }
        RgbImage { columns: info.width as usize, rows: info.height as usize, bytes }
    }
    /// Encodes the picture as PNG. The lowest two bits of each colour are dropped to keep the file small.
    pub fn png(&self) -> Vec<u8> {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, self.columns as u32, self.rows as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::Best);
        encoder.set_adaptive_filter(png::AdaptiveFilterType::Adaptive);
        let rounded: Vec<u8> = self.bytes.iter().map(|x| (x & 0xFC) | (x >> 6)).collect();
        encoder.write_header().unwrap().write_image_data(&rounded).unwrap();
        out
    }
}

fn small(png: &[u8]) -> Vec<u8> {
    RgbImage::read(png).png()
}

#[test]
#[ignore = "makes the picture of the guide: docs/pictures.sh"]
fn picture_for_the_guide() {
    let served = PageServer::new(root(), &["open", "scenes/first/pioneer_looks_around.toml", "--no-browser"]);
    let mut page = BrowserPage::open(&browser(), &format!("{}#select=eye&script&play", served.url));
    page.until("(document.querySelector('.cm-content')?.textContent ?? '').includes('cruise')");
    std::fs::write(root().join("docs/images/page.png"), small(&page.picture([1180, 680]))).unwrap();
}

#[test]
#[ignore = "makes the picture of the guide: docs/pictures.sh"]
fn picture_of_windows() {
    let served = PageServer::new(root(), &["open", "scenes/first/pioneer_looks_around.toml", "--no-browser"]);
    let mut page = BrowserPage::open(&browser(), &format!("{}#select=Pioneer_p3dx", served.url));
    page.send(
        "Emulation.setDeviceMetricsOverride",
        json!({ "width": 1366, "height": 690, "deviceScaleFactor": 1, "mobile": false }),
    );
    page.until("document.querySelectorAll('#rows .row').length > 20");
    let open = "Promise.all(['windows/open_windows', 'windows/camera_window', 'scene/store'] \
                .map((m) => import('tatu/' + m))).then(([p, c, s]) => { \
                const of = (a) => [...s.scene.objects.values()].find((o) => o.alias === a).id; \
                p.openWindow('sensors', {}); p.openWindow('camera', c.cameraSpec(of('eye'))); })";
    page.js(open);
    page.js("document.querySelector('.row[data-key=\"object.position\"] .chart').click()");
    page.click("#play");
    page.until("(document.getElementById('time')?.textContent ?? '').includes(':08.')");
    page.click("#pause");
    std::fs::write(root().join("docs/images/windows.png"), small(&page.picture([1366, 690]))).unwrap();
}

#[test]
#[ignore = "makes the picture of the guide: docs/pictures.sh"]
fn picture_of_an_exercise() {
    let served = PageServer::new(root(), &["open", "scenes/learn/exercise_reach_the_flag.toml", "--no-browser"]);
    let mut page = BrowserPage::open(&browser(), &format!("{}#select=Pioneer_p3dx&script", served.url));
    page.until("document.querySelectorAll('.goals li').length === 3");
    page.until("(document.querySelector('.cm-content')?.textContent ?? '').includes('leftMotor')");
    std::fs::write(root().join("docs/images/exercise.png"), small(&page.picture([1280, 700]))).unwrap();
}

#[test]
#[ignore = "makes the picture of the guide: docs/pictures.sh"]
fn picture_of_a_window() {
    let served = PageServer::new(root(), &["open", "plugins/commands/simui/demo.toml", "--no-browser"]);
    let mut page = BrowserPage::open(&browser(), &format!("{}#select=Pioneer_p3dx&play", served.url));
    page.until("(document.getElementById('time')?.textContent ?? '').includes(':06.')");
    page.click("#pause");
    page.click("#fit");
    // The view is shifted so that the window does not hide the robot.
    page.js(
        "import('tatu/view/renderer').then((v) => { v.camera.setViewOffset(100, 100, -26, 0, 100, 100); v.redraw(); })",
    );
    std::fs::write(root().join("docs/images/window.png"), small(&page.picture([1180, 620]))).unwrap();
}
