//! Combines the images of two sensors, one for each eye, into an anaglyph for glasses with filters of two colours.

use super::{handle::take_image, set::apply_image, view::VisionView};
use crate::kit::*;

/// Default colours of the left and the right image: red and cyan.
const USUAL_COLORS: [f64; 6] = [1.0, 0.0, 0.0, 0.0, 1.0, 1.0];

/// Returns the sum of two pixels, each converted to grey and multiplied by the colour of its side.
fn mixed([left, right]: [[u8; 3]; 2], colors: &[f64; 6]) -> [u8; 3] {
    let grey = |pixel: [u8; 3]| pixel.map(f64::from).iter().sum::<f64>() / 3.0;
    let (left, right) = (grey(left), grey(right));
    // The conversion saturates: values out of range yield 0 or 255.
    [0, 1, 2].map(|i| (left * colors[i] + right * colors[3 + i]).round() as u8)
}

fn run(c: &mut Ctx<'_>) -> Result {
    let passive = VisionView::of(c, 0)?;
    let handles: [f64; 2] = numbers(c, 1)?;
    let colors = if c.has(2) { numbers(c, 2)? } else { USUAL_COLORS };
    let mut images = Vec::new();
    for handle in handles {
        let found = c.world().look((handle as i64 & HANDLE_BITS) as u64);
        let found = found.map_err(|_| Fail::missing(format!("argument 2: there is no object {handle}")))?;
        let (view, seen) = take_image(c, found.id, 0)?;
        if (view.columns, view.rows) != (passive.columns, passive.rows) {
            let text = format!(
                "the sensor `{}` has {} x {} pixels, but the sensor for the picture has {} x {}: expected equal sizes",
                path(c, found.id),
                view.columns,
                view.rows,
                passive.columns,
                passive.rows
            );
            return Err(Fail::argument(text));
        }
        images.push(seen.rgb(c, &view).into_owned());
    }
    let [left, right] = images.as_slice() else { return Err(Fail::argument("argument 2: expected two handles")) };
    let pairs = left.as_chunks::<3>().0.iter().zip(right.as_chunks::<3>().0);
    let rgb = pairs.flat_map(|(left, right)| mixed([*left, *right], &colors)).collect();
    apply_image(c, &passive, rgb, None)?;
    c.ret(1_i64);
    Ok(())
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.subject("images", |offer| {
        offer.command(
            Cmd::new("simVision.handleAnaglyphStereo", run)
                .param(Param::int("passiveSensor").text("the sensor that receives the picture"))
                .param(table("activeSensors", "two handles: the left and the right eye"))
                .param(
                    Param::list("leftAndRightColors").optional().text(
                        "red, green and blue of the left picture, then of the right one; red and cyan if omitted",
                    ),
                )
                .returns(Param::int("result").text("1"))
                .text(
                    "Takes images with two sensors and combines them into a picture for glasses with two colours: the \
                     sum of both in grey, each in its colour.",
                )
                .example(
                    "local simVision = require 'simVision'\n\
                     local left, right, out = sim.getObject('/eye'), sim.getObject('/eye'), sim.getObject('/eye')\n\
                     assert(simVision.handleAnaglyphStereo(out, {left, right}, {1, 0, 0, 0, 1, 1}) == 1)",
                ),
        );
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_eye_sees_its_own_picture_in_its_colour() {
        let (white, black) = ([255; 3], [0; 3]);
        assert_eq!(mixed([white, black], &USUAL_COLORS), [255, 0, 0]);
        assert_eq!(mixed([black, white], &USUAL_COLORS), [0, 255, 255]);
        assert_eq!(mixed([[30, 60, 90], black], &USUAL_COLORS), [60, 0, 0]);
        assert_eq!(mixed([white, white], &[1.0; 6]), [255; 3], "sums are limited");
    }
}
