//! Chains of filters, as vision sensors had before 4.0: each changes a working image, writes it out, or tells what it found.
//!
//! A chain is a text in the free data of the sensor under the tag `vision.filters`, filters divided by `;`, each
//! `type:options:bytes:integers:floats` with numbers divided by commas; what stands last may be left out:
//! `2;35::0:256,1;38`. Without one the chain is `1;4`: the image as it was taken.

use super::{
    handle::Seen,
    view::View,
    work::{Lens, Work, blobs, coordinates, intensity},
};
use crate::{Vrep, kit::*, notes};

/// The tag under which a chain stands.
const TAG: &[u8] = b"vision.filters";

/// A filter: its type (`sim_filtercomponent_...`) and parameters.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Filter {
    pub kind: i64,
    /// 1: it is on. 2: its packet is not added. 4: it does not trigger.
    pub options: i64,
    pub bytes: Vec<i64>,
    pub ints: Vec<i64>,
    pub floats: Vec<f64>,
}

/// Bits of a filter's options.
const ON: i64 = 1;

/// What a sensor without a chain does.
fn trivial() -> Vec<Filter> {
    [1, 4].map(|kind| Filter { kind, options: ON, ..Filter::default() }).into()
}

fn parse(text: &str) -> Result<Vec<Filter>> {
    fn numbers<T: std::str::FromStr>(part: Option<&str>, whole: &str) -> Result<Vec<T>> {
        let part = part.unwrap_or_default().trim();
        let wrong = || Fail::argument(format!("`{whole}` of the data `vision.filters`: `{part}` are no numbers"));
        let parts = part.split(',').filter(|p| !p.trim().is_empty());
        parts.map(|p| p.trim().parse().map_err(|_| wrong())).collect()
    }
    let filters = text.split([';', '\n']).map(str::trim).filter(|f| !f.is_empty());
    filters
        .map(|whole| {
            let mut parts = whole.split(':');
            let kind: Vec<i64> = numbers(parts.next(), whole)?;
            let options: Vec<i64> = numbers(parts.next(), whole)?;
            Ok(Filter {
                kind: *kind
                    .first()
                    .ok_or_else(|| Fail::argument("a filter of the data `vision.filters` has no type"))?,
                options: options.first().copied().unwrap_or(ON),
                bytes: numbers(parts.next(), whole)?,
                ints: numbers(parts.next(), whole)?,
                floats: numbers(parts.next(), whole)?,
            })
        })
        .collect()
}

fn print(chain: &[Filter]) -> String {
    fn list<T: ToString>(v: &[T]) -> String {
        v.iter().map(T::to_string).collect::<Vec<_>>().join(",")
    }
    let one = |f: &Filter| format!("{}:{}:{}:{}:{}", f.kind, f.options, list(&f.bytes), list(&f.ints), list(&f.floats));
    chain.iter().map(one).collect::<Vec<_>>().join(";")
}

/// The chain of a sensor; `None`: the trivial one.
fn chain_of(c: &Ctx<'_>, sensor: tatu_object) -> Result<Option<Vec<Filter>>> {
    match notes::get(c, sensor, TAG)? {
        Some(text) => parse(&String::from_utf8_lossy(&text)).map(Some),
        None => Ok(None),
    }
}

/// Lets an image run through its sensor's chain.
pub(super) fn run(c: &Ctx<'_>, view: &View, mut seen: Seen) -> Result<Seen> {
    let Some(chain) = chain_of(c, view.id)? else { return Ok(seen) };
    let (rgb, depth) = (seen.rgb(c, view).into_owned(), seen.depth(c, view).into_owned());
    let given = Given { rgb: &rgb, depth: &depth, lens: view.lens(c) };
    let found = apply(&chain, &given, Work::new(view.columns, view.rows))?;
    seen.rgb = found.rgb.or(seen.rgb);
    seen.depth = found.depth.or(seen.depth);
    seen.trigger |= found.trigger;
    seen.packets.extend(found.packets);
    Ok(seen)
}

/// What a chain begins with.
struct Given<'a> {
    rgb: &'a [u8],
    depth: &'a [f32],
    lens: Lens,
}

/// What a chain makes of it.
#[derive(Debug, Default, PartialEq)]
struct Found {
    rgb: Option<Vec<u8>>,
    depth: Option<Vec<f32>>,
    trigger: bool,
    packets: Vec<Vec<f64>>,
}

fn apply(chain: &[Filter], given: &Given<'_>, mut work: Work) -> Result<Found> {
    let mut found = Found::default();
    for f in chain.iter().filter(|f| f.options & ON != 0) {
        let float = |k: usize, otherwise: f64| f.floats.get(k).copied().unwrap_or(otherwise) as f32;
        match f.kind {
            1 => work.set_rgb(given.rgb),
            2 => work.set_depth(given.depth),
            3 => work.uniform([0, 1, 2].map(|k| float(k, 0.0))),
            4 => found.rgb = Some(work.rgb()),
            5 | 6 => work.buffers[f.kind as usize - 5] = work.image.clone(),
            7 | 8 => work.image = work.buffers[f.kind as usize - 7].clone(),
            9 => work.buffers.swap(0, 1),
            10 => work.with_buffer(0, |x, b| x + b),
            11 => work.with_buffer(0, |x, b| x - b),
            12 => work.with_buffer(0, |x, b| x * b),
            13 => work.flip(true, false),
            14 => work.flip(false, true),
            18 | 19 => work.kernel(if f.kind == 18 { 3 } else { 5 }, &f.floats, 1.0),
            21 => work.edges(float(0, 0.2)),
            24 => work.normalize(),
            25 => work.intensity_scale(float(0, 0.0), float(1, 1.0)),
            27 => work.scale_and_offset([0, 1, 2].map(|k| float(k, 1.0)), [3, 4, 5].map(|k| float(k, 0.0))),
            28 => {
                work.binary(float(0, 0.5));
                let white = work.image.iter().filter(|p| intensity(p) > 0.5).count();
                found.packets.push(vec![white as f64 / work.image.len().max(1) as f64]);
            }
            29 => std::mem::swap(&mut work.image, &mut work.buffers[0]),
            30 => work.into_buffer(0, |b, x| b + x),
            31 => work.into_buffer(0, |b, x| b - x),
            34 => {
                let (packet, label) = blobs(&work, float(0, 0.5), f.floats.get(1).copied().unwrap_or(0.0));
                found.trigger |= packet[0] > 0.0;
                found.packets.push(packet);
                for (p, l) in work.image.iter_mut().zip(label) {
                    *p = blob_color(l);
                }
            }
            35 => {
                let count = [0, 1]
                    .map(|k| f.ints.get(k).map_or([work.columns, work.rows][k], |n| (*n).clamp(1, 4096) as usize));
                let even = f.bytes.first().is_some_and(|b| *b != 0);
                found.packets.push(coordinates(&work.depth(), work.columns, work.rows, &given.lens, count, even));
            }
            38 => found.depth = Some(work.depth()),
            kind => {
                return Err(Fail::unsupported(format!("there are no filters of type {kind} here"))
                    .help("take it out of the sensor's data `vision.filters`, or do its work in sysCall_vision"));
            }
        }
    }
    Ok(found)
}

/// A color for each spot, black between them.
fn blob_color(label: u32) -> [f32; 3] {
    match label {
        0 => [0.0; 3],
        n => {
            let bits = (n - 1) % 7 + 1;
            [0, 1, 2].map(|k| if bits >> k & 1 == 1 { 1.0 } else { 0.0 })
        }
    }
}

/// The number of the filter that argument 1 tells, from 0.
fn filter_at(c: &Ctx<'_>, chain: &[Filter]) -> Result<usize> {
    let n = c.i64(1)?;
    usize::try_from(n)
        .ok()
        .filter(|i| *i < chain.len())
        .ok_or_else(|| Fail::argument(format!("argument 2: there is no filter {n}; the sensor has {}", chain.len())))
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let missing = "Filters 15 to 17, 20, 22, 23, 26, 32, 33, 36, 37 and 1000 are not there; what parameters of the others \
        mean beyond the documented ones is our reading.";
    offer.command(
        both("getVisionSensorFilter", MINUS, |c| {
            let view = View::of(c, 0)?;
            let chain = chain_of(c, view.id)?.unwrap_or_else(trivial);
            let f = &chain[filter_at(c, &chain)?];
            c.ret(f.kind);
            c.ret(f.options);
            c.ret::<[i64]>(&f.bytes[..]);
            c.ret::<[i64]>(&f.ints[..]);
            c.ret::<[f64]>(&f.floats[..]);
            c.ret::<str>("");
            Ok(())
        })
        .param(flagged("sensor"))
        .param(Param::int("index").text("from 0"))
        .returns(Param::int("type").text("a number of sim.filtercomponent_..."))
        .returns(Param::int("options").text("1: it is on"))
        .returns(Param::list("bytes"))
        .returns(Param::list("integers"))
        .returns(Param::floats("floats", 0))
        .returns(Param::string("custom").text("empty"))
        .text("Gives a filter of a vision sensor.")
        .partial(missing),
    );
    offer.command(
        both("setVisionSensorFilter", MINUS, |c| {
            let view = View::of(c, 0)?;
            let mut chain = chain_of(c, view.id)?.unwrap_or_else(trivial);
            let i = filter_at(c, &chain)?;
            let whole = |k: usize| c.arg(k).numbers().map(|v| v.iter().map(|x| *x as i64).collect::<Vec<_>>());
            let f = &mut chain[i];
            f.options = c.i64(2)?;
            f.bytes = whole(3).unwrap_or_else(|| f.bytes.clone());
            f.ints = whole(4).unwrap_or_else(|| f.ints.clone());
            f.floats = c.arg(5).numbers().unwrap_or_else(|| f.floats.clone());
            let kind = f.kind;
            notes::set(c, view.id, TAG, Some(print(&chain).as_bytes()))?;
            c.ret(kind);
            Ok(())
        })
        .param(flagged("sensor"))
        .param(Param::int("index").text("from 0"))
        .param(Param::int("options").text("1: it is on"))
        .param(Param::any("bytes").optional().text("nil: they stay"))
        .param(Param::any("integers").optional().text("nil: they stay"))
        .param(Param::any("floats").optional().text("nil: they stay"))
        .param(Param::any("custom").optional().text("ignored"))
        .returns(Param::int("type").text("a number of sim.filtercomponent_..."))
        .text("Sets the parameters of a filter of a vision sensor.")
        .partial(missing),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: Lens = Lens { intrinsics: [1.0, 1.0, 0.5, 0.5], parallel: false, planes: [0.0, 2.0] };

    fn found(chain: &str, rgb: &[u8], depth: &[f32]) -> Found {
        let given = Given { rgb, depth, lens: LENS };
        apply(&parse(chain).unwrap(), &given, Work::new(2, 2)).unwrap()
    }

    #[test]
    fn chains_are_texts() {
        let chain = parse("2; 35:1:0:256,1 ;28:1:::0.25\n38").unwrap();
        assert_eq!(chain.iter().map(|f| f.kind).collect::<Vec<_>>(), [2, 35, 28, 38]);
        assert_eq!((chain[1].ints.as_slice(), chain[2].floats.as_slice()), ([256, 1].as_slice(), [0.25].as_slice()));
        assert_eq!(parse(&print(&chain)).unwrap(), chain);
        assert!(parse("two").is_err() && parse("1:x").is_err());
        assert!(apply(&parse("37").unwrap(), &Given { rgb: &[], depth: &[], lens: LENS }, Work::new(1, 1)).is_err());
    }

    #[test]
    fn buffers_and_outputs() {
        let rgb = [51, 102, 153, 0, 0, 0, 255, 255, 255, 10, 20, 30];
        assert_eq!(found("1;4", &rgb, &[0.0; 4]).rgb.unwrap(), rgb);
        assert_eq!(found("1;5;3::::0,0,0;7;4", &rgb, &[0.0; 4]).rgb.unwrap(), rgb);
        assert_eq!(found("1;5;11;4", &rgb, &[0.0; 4]).rgb.unwrap(), [0; 12]);
        // A filter that is off does nothing.
        assert_eq!(found("1;3:0;4", &rgb, &[0.0; 4]).rgb.unwrap(), rgb);
        assert_eq!(found("2;38", &rgb, &[0.0, 0.25, 0.5, 1.0]).depth.unwrap(), [0.0, 0.25, 0.5, 1.0]);
        let flipped = found("2;13;14;38", &rgb, &[0.0, 0.25, 0.5, 1.0]).depth.unwrap();
        assert_eq!(flipped, [1.0, 0.5, 0.25, 0.0]);
    }

    /// Half of four pixels are brighter than 0.5.
    #[test]
    fn thresholds() {
        let f = found("1;28::::0.5;4", &[255, 255, 255, 0, 0, 0, 127, 127, 127, 200, 150, 100], &[0.0; 4]);
        assert_eq!(f.packets, [vec![0.5]]);
        assert_eq!(f.rgb.unwrap(), [255, 255, 255, 0, 0, 0, 0, 0, 0, 255, 255, 255]);
    }
}
