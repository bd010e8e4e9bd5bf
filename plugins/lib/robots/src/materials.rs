//! The materials of Gazebo that files refer to by name.

/// Returns red, green, blue and opacity of a material such as `Gazebo/Orange`, or `None` for one that is not a plain
/// colour. Values: estimate, of the usual colours with these names.
pub fn gazebo_color(name: &str) -> Option<[f64; 4]> {
    let name = name.trim().strip_prefix("Gazebo/").unwrap_or(name);
    let [r, g, b] = match name {
        "Black" | "FlatBlack" => [0.05, 0.05, 0.05],
        "DarkGrey" | "DarkGray" => [0.18, 0.18, 0.18],
        "Grey" | "Gray" => [0.5, 0.5, 0.5],
        "LightGrey" | "LightGray" => [0.75, 0.75, 0.75],
        "White" => [1.0, 1.0, 1.0],
        "Red" => [0.9, 0.05, 0.05],
        "Green" => [0.05, 0.7, 0.05],
        "Blue" | "SkyBlue" => [0.05, 0.1, 0.9],
        "Yellow" => [1.0, 0.9, 0.05],
        "Orange" => [1.0, 0.5, 0.05],
        "Purple" => [0.6, 0.1, 0.7],
        "Turquoise" => [0.1, 0.8, 0.8],
        "Gold" => [0.8, 0.65, 0.15],
        "Wood" => [0.55, 0.38, 0.2],
        _ => return None,
    };
    Some([r, g, b, 1.0])
}
