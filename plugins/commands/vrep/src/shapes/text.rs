//! A command that creates a shape in the form of a text.

use crate::{
    kit::{algebra as al, *},
    meshes::create_from_triangles,
};

/// Bitmaps of the characters from the space to the tilde: seven rows from top to bottom, each with five columns, of
/// which bit 4 is the leftmost.
#[rustfmt::skip]
const LETTERS: [[u8; 7]; 95] = [
    [0, 0, 0, 0, 0, 0, 0], [4, 4, 4, 4, 4, 0, 4], [10, 10, 10, 0, 0, 0, 0], [10, 10, 31, 10, 31, 10, 10],
    [4, 15, 20, 14, 5, 30, 4], [24, 25, 2, 4, 8, 19, 3], [12, 18, 20, 8, 21, 18, 13], [4, 4, 8, 0, 0, 0, 0],
    [2, 4, 8, 8, 8, 4, 2], [8, 4, 2, 2, 2, 4, 8], [0, 4, 21, 14, 21, 4, 0], [0, 4, 4, 31, 4, 4, 0],
    [0, 0, 0, 0, 12, 4, 8], [0, 0, 0, 31, 0, 0, 0], [0, 0, 0, 0, 0, 12, 12], [0, 1, 2, 4, 8, 16, 0],
    [14, 17, 19, 21, 25, 17, 14], [4, 12, 4, 4, 4, 4, 14], [14, 17, 1, 2, 4, 8, 31], [31, 2, 4, 2, 1, 17, 14],
    [2, 6, 10, 18, 31, 2, 2], [31, 16, 30, 1, 1, 17, 14], [6, 8, 16, 30, 17, 17, 14], [31, 1, 2, 4, 8, 8, 8],
    [14, 17, 17, 14, 17, 17, 14], [14, 17, 17, 15, 1, 2, 12], [0, 12, 12, 0, 12, 12, 0], [0, 12, 12, 0, 12, 4, 8],
    [2, 4, 8, 16, 8, 4, 2], [0, 0, 31, 0, 31, 0, 0], [8, 4, 2, 1, 2, 4, 8], [14, 17, 1, 2, 4, 0, 4],
    [14, 17, 1, 13, 21, 21, 14], [14, 17, 17, 17, 31, 17, 17], [30, 17, 17, 30, 17, 17, 30], [14, 17, 16, 16, 16, 17, 14],
    [28, 18, 17, 17, 17, 18, 28], [31, 16, 16, 30, 16, 16, 31], [31, 16, 16, 30, 16, 16, 16], [14, 17, 16, 23, 17, 17, 15],
    [17, 17, 17, 31, 17, 17, 17], [14, 4, 4, 4, 4, 4, 14], [7, 2, 2, 2, 2, 18, 12], [17, 18, 20, 24, 20, 18, 17],
    [16, 16, 16, 16, 16, 16, 31], [17, 27, 21, 21, 17, 17, 17], [17, 17, 25, 21, 19, 17, 17], [14, 17, 17, 17, 17, 17, 14],
    [30, 17, 17, 30, 16, 16, 16], [14, 17, 17, 17, 21, 18, 13], [30, 17, 17, 30, 20, 18, 17], [15, 16, 16, 14, 1, 1, 30],
    [31, 4, 4, 4, 4, 4, 4], [17, 17, 17, 17, 17, 17, 14], [17, 17, 17, 17, 17, 10, 4], [17, 17, 17, 21, 21, 21, 10],
    [17, 17, 10, 4, 10, 17, 17], [17, 17, 17, 10, 4, 4, 4], [31, 1, 2, 4, 8, 16, 31], [14, 8, 8, 8, 8, 8, 14],
    [0, 16, 8, 4, 2, 1, 0], [14, 2, 2, 2, 2, 2, 14], [4, 10, 17, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 31],
    [8, 4, 2, 0, 0, 0, 0], [0, 0, 14, 1, 15, 17, 15], [16, 16, 22, 25, 17, 17, 30], [0, 0, 14, 16, 16, 17, 14],
    [1, 1, 13, 19, 17, 17, 15], [0, 0, 14, 17, 31, 16, 14], [6, 9, 8, 28, 8, 8, 8], [0, 15, 17, 17, 15, 1, 14],
    [16, 16, 22, 25, 17, 17, 17], [4, 0, 12, 4, 4, 4, 14], [2, 0, 6, 2, 2, 18, 12], [16, 16, 18, 20, 24, 20, 18],
    [12, 4, 4, 4, 4, 4, 14], [0, 0, 26, 21, 21, 17, 17], [0, 0, 22, 25, 17, 17, 17], [0, 0, 14, 17, 17, 17, 14],
    [0, 0, 30, 17, 30, 16, 16], [0, 0, 13, 19, 15, 1, 1], [0, 0, 22, 25, 16, 16, 16], [0, 0, 14, 16, 14, 1, 30],
    [8, 8, 28, 8, 8, 9, 6], [0, 0, 17, 17, 17, 19, 13], [0, 0, 17, 17, 17, 10, 4], [0, 0, 17, 17, 21, 21, 10],
    [0, 0, 17, 10, 4, 10, 17], [0, 0, 17, 17, 15, 1, 14], [0, 0, 31, 2, 4, 8, 31], [2, 4, 4, 8, 4, 4, 2],
    [4, 4, 4, 4, 4, 4, 4], [8, 4, 4, 2, 4, 4, 8], [0, 0, 8, 21, 2, 0, 0],
];

/// Height of a letter, in rows of dots.
const ROWS: usize = 7;
/// Distance from one letter to the next, in columns of dots.
const STEP: usize = 6;

/// Maximum number of characters of a text.
const MAX_LETTERS: usize = 1000;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.generateTextShape", |c| {
            let text = c.text(0)?;
            let color = match c.arg(1).numbers().as_deref() {
                Some(&[r, g, b]) => [r, g, b],
                _ => [1.0; 3],
            };
            let height = if c.has(2) { c.f64(2)? } else { 0.1 };
            if !(height > 0.0 && height.is_finite()) {
                return Err(Fail::argument(format!("the height of the text is {height} m; expected more than 0")));
            }
            let (points, places) = triangles(&text, height)?;
            let shape = create_from_triangles(c, points, places)?;
            let (w, p) = (c.world(), &c.plugin().p);
            w.set_f64s(shape, p.color, &color.map(|x| x.clamp(0.0, 1.0)))?;
            if c.arg(3).truthy() {
                w.set_pose(shape, 0, &al::pose([0.0; 3], [0.0, 0.0, 0.0, 1.0]))?;
            }
            c.ret(handle(shape));
            Ok(())
        })
        .param(Param::string("text"))
        .param(Param::list("color").optional().text("red, green, blue; white if omitted"))
        .param(Param::float("height").unit("m").default(0.1).optional())
        .param(
            Param::bool("centered").default(false).optional().text("whether the middle of the text is at the origin"),
        )
        .param(Param::any("alphabet").optional().text("ignored"))
        .returns(Param::int("shape"))
        .text("Creates a static shape in the form of a text, which runs along x and is upright along y.")
        .partial("The letters consist of 5 x 7 dots, and the text is one shape, not a model of one shape per letter."),
    );
}

/// Returns the points and triangles of a text, in which each run of adjacent dots in a row becomes a bar. Characters
/// without a bitmap are replaced by a question mark.
fn triangles(text: &str, height: f64) -> Result<(Vec<f64>, Vec<f64>)> {
    let dot = height / ROWS as f64;
    let (mut points, mut places) = (Vec::new(), Vec::new());
    if text.chars().count() > MAX_LETTERS {
        return Err(Fail::argument(format!("the text has more than {MAX_LETTERS} characters")));
    }
    for (i, letter) in text.chars().enumerate() {
        let index = (letter as usize).wrapping_sub(' ' as usize);
        let dots = LETTERS.get(index).unwrap_or(&LETTERS['?' as usize - ' ' as usize]);
        for (row, bits) in dots.iter().enumerate() {
            let is_set = |column: usize| column < 5 && bits >> (4 - column) & 1 == 1;
            let mut column = 0;
            while column < 5 {
                let begin = column;
                while is_set(column) {
                    column += 1;
                }
                if column > begin {
                    let x = [i * STEP + begin, i * STEP + column].map(|x| x as f64 * dot);
                    let y = [ROWS - 1 - row, ROWS - row].map(|y| y as f64 * dot);
                    add_bar(&mut points, &mut places, x, y, dot);
                }
                column += 1;
            }
        }
    }
    if points.is_empty() {
        return Err(Fail::argument("the text contains no visible character"));
    }
    Ok((points, places))
}

fn add_bar(points: &mut Vec<f64>, places: &mut Vec<f64>, x: [f64; 2], y: [f64; 2], depth: f64) {
    let first = points.len() / 3;
    for corner in 0..8_usize {
        points.extend([x[corner & 1], y[corner >> 1 & 1], if corner & 4 == 0 { 0.0 } else { depth }]);
    }
    const FACES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for [a, b, c, d] in FACES {
        places.extend([a, b, c, a, c, d].map(|corner| (first + corner) as f64));
    }
}
