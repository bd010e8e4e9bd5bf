//! Filter chains, which vision sensors had before V-REP 4.0: each filter changes a working image, outputs the image, or
//! reports what it finds in it.
//!
//! A chain is a string in the custom data of the sensor under the tag `vision.filters`. It consists of filters
//! separated by `;`, each written as `type:options:bytes:integers:floats` with numbers separated by commas. Trailing
//! parts can be omitted: `2;35::0:256,1;38`. The default chain is `1;4`, which outputs the unchanged image.

use super::{
    results::VisionResult,
    view::VisionView,
    work::{ImageProjection, WorkingImage, blobs, coordinates},
};
use crate::kit::*;

/// The tag under which a chain is stored.
const FILTERS_TAG: &[u8] = b"vision.filters";

/// A filter: its type (`sim_filtercomponent_...`) and parameters.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct VisionFilter {
    pub kind: i64,
    /// Bits: 1: the filter is enabled. V-REP's bits 2 (its packet is not added to the results) and 4 (it does not
    /// trigger the sensor) are stored, but have no effect.
    pub options: i64,
    pub bytes: Vec<i64>,
    pub ints: Vec<i64>,
    pub floats: Vec<f64>,
}

/// Bit of a filter's options that enables the filter.
const FILTER_ENABLED: i64 = 1;

/// Returns the default chain, `1;4`, which outputs the unchanged image.
fn default_chain() -> Vec<VisionFilter> {
    [1, 4].map(|kind| VisionFilter { kind, options: FILTER_ENABLED, ..VisionFilter::default() }).into()
}

fn parse_chain(text: &str) -> Result<Vec<VisionFilter>> {
    fn numbers<T: std::str::FromStr>(part: Option<&str>, whole: &str) -> Result<Vec<T>> {
        let part = part.unwrap_or_default().trim();
        let wrong = || {
            Fail::argument(format!(
                "`vision.filters`, filter `{whole}`: expected numbers separated by commas, found `{part}`"
            ))
        };
        let parts = part.split(',').filter(|p| !p.trim().is_empty());
        parts.map(|p| p.trim().parse().map_err(|_| wrong())).collect()
    }
    let filters = text.split([';', '\n']).map(str::trim).filter(|f| !f.is_empty());
    filters
        .map(|whole| {
            let mut parts = whole.split(':');
            let kind: Vec<i64> = numbers(parts.next(), whole)?;
            let options: Vec<i64> = numbers(parts.next(), whole)?;
            Ok(VisionFilter {
                kind: *kind.first().ok_or_else(|| {
                    Fail::argument(
                        "`vision.filters`: a filter has no type; expected `type:options:bytes:integers:floats`",
                    )
                })?,
                options: options.first().copied().unwrap_or(FILTER_ENABLED),
                bytes: numbers(parts.next(), whole)?,
                ints: numbers(parts.next(), whole)?,
                floats: numbers(parts.next(), whole)?,
            })
        })
        .collect()
}

fn format_chain(chain: &[VisionFilter]) -> String {
    fn list<T: ToString>(v: &[T]) -> String {
        v.iter().map(T::to_string).collect::<Vec<_>>().join(",")
    }
    let one =
        |f: &VisionFilter| format!("{}:{}:{}:{}:{}", f.kind, f.options, list(&f.bytes), list(&f.ints), list(&f.floats));
    chain.iter().map(one).collect::<Vec<_>>().join(";")
}

/// Returns the chain of a sensor, or `None` if the sensor has the default chain.
fn chain_of(c: &Ctx<'_>, sensor: tatu_object) -> Result<Option<Vec<VisionFilter>>> {
    match tags::get(c, sensor, FILTERS_TAG)? {
        Some(text) => parse_chain(&String::from_utf8_lossy(&text)).map(Some),
        None => Ok(None),
    }
}

/// Applies the sensor's filter chain to an image.
pub(super) fn run(c: &Ctx<'_>, view: &VisionView, mut seen: VisionResult) -> Result<VisionResult> {
    let Some(chain) = chain_of(c, view.id)? else { return Ok(seen) };
    let (rgb, depth) = (seen.rgb(c, view).into_owned(), seen.depth(c, view).into_owned());
    let given = FilterInput { rgb: &rgb, depth: &depth, lens: view.lens(c) };
    let found = apply(&chain, &given, WorkingImage::new(view.columns, view.rows))?;
    seen.rgb = found.rgb.or(seen.rgb);
    seen.depth = found.depth.or(seen.depth);
    seen.trigger |= found.trigger;
    seen.packets.extend(found.packets);
    Ok(seen)
}

/// The image that a chain filters, and how the sensor projects it.
pub(super) struct FilterInput<'a> {
    pub rgb: &'a [u8],
    pub depth: &'a [f32],
    pub lens: ImageProjection,
}

/// What a chain outputs: the filtered image and depths, if any, and results of its filters.
#[derive(Debug, Default, PartialEq)]
pub(super) struct FilterOutput {
    pub rgb: Option<Vec<u8>>,
    pub depth: Option<Vec<f32>>,
    pub trigger: bool,
    pub packets: Vec<Vec<f64>>,
}

fn apply(chain: &[VisionFilter], given: &FilterInput<'_>, mut work: WorkingImage) -> Result<FilterOutput> {
    let mut found = FilterOutput::default();
    for f in chain.iter().filter(|f| f.options & FILTER_ENABLED != 0) {
        step(f, given, &mut work, &mut found)?;
    }
    Ok(found)
}

/// Applies one filter to the working image, and stores what it outputs in `found`.
pub(super) fn step(
    f: &VisionFilter,
    given: &FilterInput<'_>,
    work: &mut WorkingImage,
    found: &mut FilterOutput,
) -> Result {
    let float = |k: usize, otherwise: f64| f.floats.get(k).copied().unwrap_or(otherwise) as f32;
    let three = |k: usize, otherwise: f64| [0, 1, 2].map(|i| float(k + i, otherwise));
    let bit = |n: i64| f.bytes.first().is_some_and(|b| b & n != 0);
    let (columns, rows) = (work.columns as f64, work.rows as f64);
    match f.kind {
        1 => work.set_rgb(given.rgb),
        2 => work.set_depth(given.depth),
        3 => work.uniform(three(0, 0.0)),
        4 => found.rgb = Some(work.rgb()),
        5 | 6 => work.buffers[f.kind as usize - 5] = work.image.clone(),
        7 | 8 => work.image = work.buffers[f.kind as usize - 7].clone(),
        9 => work.buffers.swap(0, 1),
        10 => work.with_buffer(0, |x, b| x + b),
        11 => work.with_buffer(0, |x, b| x - b),
        12 => work.with_buffer(0, |x, b| x * b),
        13 => work.flip(true, false),
        14 => work.flip(false, true),
        18 | 19 => {
            let side = if f.kind == 18 { 3 } else { 5 };
            let factor = f.floats.get(side * side).copied().unwrap_or(1.0);
            for _ in 0..f.ints.first().map_or(1, |n| (*n).clamp(1, 100)) {
                work.kernel(side, &f.floats, factor);
            }
        }
        20 => work.kernel(3, &[0.0, -1.0, 0.0, -1.0, 5.0, -1.0, 0.0, -1.0, 0.0], 1.0),
        21 => work.edges(float(0, 0.2)),
        22 => {
            let (w, h) = (f64::from(float(0, 1.0)) * columns / 2.0, f64::from(float(1, 1.0)) * rows / 2.0);
            let inside = |c: usize, r: usize| {
                (c as f64 + 0.5 - columns / 2.0).abs() <= w && (r as f64 + 0.5 - rows / 2.0).abs() <= h
            };
            work.keep_pixels(bit(1), |c, r, _| inside(c, r));
        }
        23 => {
            let radius = f64::from(float(0, 1.0)) * columns.min(rows) / 2.0;
            work.keep_pixels(bit(1), |c, r, _| {
                libm::hypot(c as f64 + 0.5 - columns / 2.0, r as f64 + 0.5 - rows / 2.0) <= radius
            });
        }
        24 => work.normalize(),
        25 => work.intensity_scale(float(0, 0.0), float(1, 1.0), f.ints.first().is_none_or(|n| n & 1 == 0)),
        26 if bit(2) => {
            let (color, tolerance, keep) = (three(0, 0.0), three(3, 0.0), bit(1));
            work.keep_pixels(bit(4), |_, _, p| (0..3).all(|k| (p[k] - color[k]).abs() <= tolerance[k]) == keep);
        }
        27 if bit(2) => work.scale_and_offset(three(0, 0.0), three(3, 1.0), three(6, 0.0)),
        26 | 27 => {
            return Err(Fail::unsupported("filtering by hue is not supported; filter by red, green and blue"));
        }
        28 => {
            work.binary(float(0, 0.5));
            let found_here = work.moments();
            // Each expected value is followed by its tolerance. Roundness has only a lower bound.
            let near = |k: usize| {
                let (wanted, off) = (f64::from(float(4 + 2 * k, 0.0)), f64::from(float(5 + 2 * k, 1e9)));
                (found_here[k] - wanted).abs() <= off
            };
            let round = found_here[4] >= f64::from(float(12, 0.0));
            found.trigger |= bit(4) && (0..4).all(near) && round;
            found.packets.push(found_here.to_vec());
        }
        29 => std::mem::swap(&mut work.image, &mut work.buffers[0]),
        30 => work.write_buffer(0, |b, x| b + x),
        31 => work.write_buffer(0, |b, x| b - x),
        34 => {
            let (packet, label) = blobs(work, float(0, 0.5), f.floats.get(1).copied().unwrap_or(0.0));
            found.trigger |= packet[0] > 0.0;
            found.packets.push(packet);
            if bit(1) {
                work.image.iter_mut().zip(label).for_each(|(p, l)| *p = blob_color(l));
            }
        }
        35 => {
            let side = |k: usize| f.ints.get(k).map_or([work.columns, work.rows][k], |n| (*n).clamp(1, 4096) as usize);
            let count = [side(0), side(1)];
            found.packets.push(coordinates(&work.depth(), work.columns, work.rows, &given.lens, count, bit(1)));
        }
        36 => {
            let share = work.mark_changed(float(0, 0.1));
            found.trigger |= share > 0.0;
            found.packets.push(vec![share]);
        }
        38 => found.depth = Some(work.depth()),
        kind => {
            return Err(Fail::unsupported(format!("filters of type {kind} are not supported"))
                .help("remove it from the sensor's data `vision.filters`, or implement it in sysCall_vision"));
        }
    }
    Ok(())
}

/// Returns the colour in which a blob is shown; the background (label 0) is black.
fn blob_color(label: u32) -> [f32; 3] {
    match label {
        0 => [0.0; 3],
        n => {
            let bits = (n - 1) % 7 + 1;
            [0, 1, 2].map(|k| if bits >> k & 1 == 1 { 1.0 } else { 0.0 })
        }
    }
}

/// Returns the zero-based index of the filter that argument 1 selects.
fn filter_at(c: &Ctx<'_>, chain: &[VisionFilter]) -> Result<usize> {
    let n = c.i64(1)?;
    usize::try_from(n)
        .ok()
        .filter(|i| *i < chain.len())
        .ok_or_else(|| Fail::argument(format!("argument 2: the sensor has {} filters, but no filter {n}", chain.len())))
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let missing = "Filters 15 to 17 (rotate, shift, resize), 32, 33, 37 and 1000 are not available, and 26 and 27 do \
                   not support hue; roundness is the ratio of a spot's sides, which may differ from the original.";
    offer.command(
        both(["sim.getVisionSensorFilter", "simGetVisionSensorFilter"], MINUS_ONE, |c| {
            let view = VisionView::of(c, 0)?;
            let chain = chain_of(c, view.id)?.unwrap_or_else(default_chain);
            let f = &chain[filter_at(c, &chain)?];
            c.ret(f.kind);
            c.ret(f.options);
            c.ret(&f.bytes[..]);
            c.ret(&f.ints[..]);
            c.ret(&f.floats[..]);
            c.ret("");
            Ok(())
        })
        .param(flagged("sensor"))
        .param(Param::int("index").text("from 0"))
        .returns(Param::int("type").text("a number of sim.filtercomponent_..."))
        .returns(Param::int("options").text("1: enabled"))
        .returns(Param::list("bytes"))
        .returns(Param::list("integers"))
        .returns(Param::floats("floats", 0))
        .returns(Param::string("custom").text("empty"))
        .text("Returns a filter of a vision sensor.")
        .partial(missing),
    );
    offer.command(
        both(["sim.setVisionSensorFilter", "simSetVisionSensorFilter"], MINUS_ONE, |c| {
            let view = VisionView::of(c, 0)?;
            let mut chain = chain_of(c, view.id)?.unwrap_or_else(default_chain);
            let i = filter_at(c, &chain)?;
            let whole = |k: usize| c.arg(k).numbers().map(|v| v.iter().map(|x| *x as i64).collect::<Vec<_>>());
            let f = &mut chain[i];
            f.options = c.i64(2)?;
            f.bytes = whole(3).unwrap_or_else(|| f.bytes.clone());
            f.ints = whole(4).unwrap_or_else(|| f.ints.clone());
            f.floats = c.arg(5).numbers().unwrap_or_else(|| f.floats.clone());
            let kind = f.kind;
            tags::set(c, view.id, FILTERS_TAG, Some(format_chain(&chain).as_bytes()))?;
            c.ret(kind);
            Ok(())
        })
        .param(flagged("sensor"))
        .param(Param::int("index").text("from 0"))
        .param(Param::int("options").text("1: enabled"))
        .param(Param::any("bytes").optional().text("nil: unchanged"))
        .param(Param::any("integers").optional().text("nil: unchanged"))
        .param(Param::any("floats").optional().text("nil: unchanged"))
        .param(Param::any("custom").optional().text("ignored"))
        .returns(Param::int("type").text("a number of sim.filtercomponent_..."))
        .text("Sets the parameters of a filter of a vision sensor.")
        .partial(missing),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: ImageProjection =
        ImageProjection { intrinsics: [1.0, 1.0, 0.5, 0.5], parallel: false, planes: [0.0, 2.0] };

    fn apply_to_image(chain: &str, rgb: &[u8], depth: &[f32]) -> FilterOutput {
        let given = FilterInput { rgb, depth, lens: LENS };
        apply(&parse_chain(chain).unwrap(), &given, WorkingImage::new(2, 2)).unwrap()
    }

    #[test]
    fn chains_are_parsed_and_formatted() {
        let chain = parse_chain("2; 35:1:0:256,1 ;28:1:::0.25\n38").unwrap();
        assert_eq!(chain.iter().map(|f| f.kind).collect::<Vec<_>>(), [2, 35, 28, 38]);
        assert_eq!((chain[1].ints.as_slice(), chain[2].floats.as_slice()), ([256, 1].as_slice(), [0.25].as_slice()));
        assert_eq!(parse_chain(&format_chain(&chain)).unwrap(), chain);
        assert!(parse_chain("two").is_err() && parse_chain("1:x").is_err());
        assert!(
            apply(
                &parse_chain("37").unwrap(),
                &FilterInput { rgb: &[], depth: &[], lens: LENS },
                WorkingImage::new(1, 1)
            )
            .is_err()
        );
    }

    #[test]
    fn buffers_and_outputs_of_filters() {
        let rgb = [51, 102, 153, 0, 0, 0, 255, 255, 255, 10, 20, 30];
        assert_eq!(apply_to_image("1;4", &rgb, &[0.0; 4]).rgb.unwrap(), rgb);
        assert_eq!(apply_to_image("1;5;3::::0,0,0;7;4", &rgb, &[0.0; 4]).rgb.unwrap(), rgb);
        assert_eq!(apply_to_image("1;5;11;4", &rgb, &[0.0; 4]).rgb.unwrap(), [0; 12]);
        // A disabled filter has no effect.
        assert_eq!(apply_to_image("1;3:0;4", &rgb, &[0.0; 4]).rgb.unwrap(), rgb);
        assert_eq!(apply_to_image("2;38", &rgb, &[0.0, 0.25, 0.5, 1.0]).depth.unwrap(), [0.0, 0.25, 0.5, 1.0]);
        let flipped = apply_to_image("2;13;14;38", &rgb, &[0.0, 0.25, 0.5, 1.0]).depth.unwrap();
        assert_eq!(flipped, [1.0, 0.5, 0.25, 0.0]);
    }

    /// Pixels near a colour (26) or in the middle (22) remain; if requested, removed pixels are copied to the buffer.
    #[test]
    fn filters_select_colours_and_central_pixels() {
        let rgb = [255, 0, 0, 0, 255, 0, 250, 5, 0, 0, 0, 255];
        let near_red = apply_to_image("1;26:1:3::1,0,0,0.1,0.1,0.1;4", &rgb, &[0.0; 4]).rgb.unwrap();
        assert_eq!(near_red, [255, 0, 0, 0, 0, 0, 250, 5, 0, 0, 0, 0]);
        let rest = apply_to_image("1;26:1:7::1,0,0,0.1,0.1,0.1;7;4", &rgb, &[0.0; 4]).rgb.unwrap();
        assert_eq!(rest, [0, 0, 0, 0, 255, 0, 0, 0, 0, 0, 0, 255]);
        assert_eq!(apply_to_image("1;22::::0.4,0.4;4", &rgb, &[0.0; 4]).rgb.unwrap(), [0; 12]);
        assert_eq!(apply_to_image("1;22::::1,1;4", &rgb, &[0.0; 4]).rgb.unwrap(), rgb);
        let f = apply_to_image("3;5;1;36::::0.2;4", &[255, 255, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0], &[0.0; 4]);
        assert_eq!((f.trigger, f.packets), (true, vec![vec![0.25]]));
    }

    /// Two of four pixels are brighter than 0.5.
    #[test]
    fn threshold_filter_counts_bright_pixels() {
        let f = apply_to_image("1;28::::0.5;4", &[255, 255, 255, 0, 0, 0, 127, 127, 127, 200, 150, 100], &[0.0; 4]);
        assert_eq!(f.packets.len(), 1);
        assert_eq!(f.packets[0][0], 0.5);
        assert_eq!(f.rgb.unwrap(), [255, 255, 255, 0, 0, 0, 0, 0, 0, 255, 255, 255]);
    }
}
