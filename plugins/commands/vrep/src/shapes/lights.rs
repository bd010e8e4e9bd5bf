//! Commands on lights. Values set by scripts are only stored and returned; rendered images use a fixed light.

use crate::kit::*;

/// Tag under which a light's values are stored: state, diffuse red, green and blue, specular red, green and blue.
/// Properties of a light object take precedence.
const TAG: &str = "light";

/// Default values of a light, in the same order: on, with grey colours.
const DEFAULT_LIGHT: [f64; 7] = [1.0, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5];

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let only_kept = "Values are only stored and returned; rendered images use a fixed light.";
    offer.command(
        both(["sim.getLightParameters", "simGetLightParameters"], MINUS_ONE, |c| {
            let light = light(c, existing_object(c, 0)?.id)?;
            c.ret(light[0] as i64);
            c.ret(&[0.0; 3][..]);
            c.ret(&light[1..4]);
            c.ret(&light[4..7]);
            Ok(())
        })
        .param(object("light"))
        .returns(Param::int("state").text("1: on"))
        .returns(Param::floats("reserved", 3).text("zeros"))
        .returns(Param::floats("diffuse", 3).text("red, green, blue, 0 to 1"))
        .returns(Param::floats("specular", 3).text("likewise"))
        .text("Returns whether a light is on, and its colours.")
        .partial(only_kept),
    );
    offer.command(
        both(["sim.setLightParameters", "simSetLightParameters"], MINUS_ONE, |c| {
            let id = existing_object(c, 0)?.id;
            let mut light = light(c, id)?;
            if let Some(state) = c.has(1).then(|| c.i64(1)).transpose()?.filter(|s| *s >= 0) {
                light[0] = state as f64;
            }
            for (argument, at) in [(3, 1), (4, 4)] {
                if c.has(argument) {
                    light[at..at + 3].copy_from_slice(&numbers::<3>(c, argument)?);
                }
            }
            let p = &c.plugin().p;
            if c.world().look(id)?.kind == TATU_KIND_LIGHT {
                c.world().set(id, p.light_on, &Value::Bool(light[0] > 0.0))?;
                let color = [light[1], light[2], light[3]].map(|x| x.clamp(0.0, 1.0));
                c.world().set(id, p.light_color, &Value::Floats(color.to_vec()))?;
            }
            let text: Vec<String> = light.iter().map(f64::to_string).collect();
            tags::set_private(c, id, TAG, Some(text.join(" ").as_bytes()))?;
            c.ret(1_i64);
            Ok(())
        })
        .param(object("light"))
        .param(Param::int("state").optional().text("1: on; 0: off; negative: unchanged"))
        .param(Param::any("reserved").optional())
        .param(Param::any("diffuse").optional().text("red, green, blue, 0 to 1"))
        .param(Param::any("specular").optional().text("likewise"))
        .returns(Param::int("result").text("1"))
        .text("Switches a light on or off, and sets its colours.")
        .partial(only_kept),
    );
}

fn light(c: &Ctx<'_>, id: tatu_object) -> Result<[f64; 7]> {
    let kept = tags::private(c, id, TAG)?.and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default();
    let mut out = DEFAULT_LIGHT;
    for (place, number) in out.iter_mut().zip(kept.split(' ')) {
        *place = number.parse().unwrap_or(*place);
    }
    if c.world().look(id)?.kind == TATU_KIND_LIGHT {
        let p = &c.plugin().p;
        out[0] = f64::from(u8::from(bool_of(c, id, p.light_on)?));
        if let [r, g, b] = c.world().get(id, p.light_color)?.numbers().unwrap_or_default()[..] {
            out[1..4].copy_from_slice(&[r, g, b]);
        }
    }
    Ok(out)
}
