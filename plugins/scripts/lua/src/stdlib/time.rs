//! The library `os`: date and time of the run, which are derived from simulation time unless the run is in real time.
//! The library does not query the operating system.

use std::fmt::Write;

use mlua_sys::*;

use crate::{
    errors,
    run::budget,
    stack::{bytes, push, reg, registry, set},
    state::{self, ScriptState, push_scratch},
};

/// Default start date: the first second of 2015, UTC.
const EPOCH: i64 = 1_420_070_400;

const DAY_NAMES: [&str; 7] = ["Sunday", "Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday"];
const MONTH_NAMES: [&str; 12] = [
    "January",
    "February",
    "March",
    "April",
    "May",
    "June",
    "July",
    "August",
    "September",
    "October",
    "November",
    "December",
];

/// Installs the library `os`.
///
/// # Safety
/// Must run in protected mode, while the state is created.
pub(crate) unsafe fn open(l: *mut lua_State) {
    lua_createtable(l, 0, 6);
    set(l, c"clock", clock);
    set(l, c"time", time);
    set(l, c"date", date);
    set(l, c"difftime", difftime);
    set(l, c"getenv", getenv);
    set(l, c"setlocale", setlocale);
    registry(l, reg::LOADED_MODULES);
    lua_pushvalue(l, -2);
    lua_setfield(l, -2, c"os".as_ptr());
    lua_pop(l, 1);
    lua_setglobal(l, c"os".as_ptr());
}

fn seconds(s: &ScriptState) -> i64 {
    let epoch = s.world().get(0, s.clock.epoch).ok().and_then(|v| v.as_i64()).unwrap_or(EPOCH);
    epoch + s.now().floor() as i64
}

unsafe extern "C-unwind" fn clock(l: *mut lua_State) -> i32 {
    lua_pushnumber(l, state::of(l).now());
    1
}

unsafe extern "C-unwind" fn getenv(l: *mut lua_State) -> i32 {
    lua_pushnil(l);
    1
}

unsafe extern "C-unwind" fn setlocale(l: *mut lua_State) -> i32 {
    push(l, b"C");
    1
}

unsafe extern "C-unwind" fn difftime(l: *mut lua_State) -> i32 {
    lua_pushnumber(l, luaL_checknumber(l, 1) - luaL_optnumber(l, 2, 0.0));
    1
}

unsafe extern "C-unwind" fn time(l: *mut lua_State) -> i32 {
    if lua_type(l, 1) <= LUA_TNIL {
        lua_pushinteger(l, seconds(state::of(l)));
        return 1;
    }
    luaL_checktype(l, 1, LUA_TTABLE);
    let field = |name: &std::ffi::CStr, fallback: Option<i64>| {
        lua_getfield(l, 1, name.as_ptr());
        let mut whole = 0;
        let value = lua_tointegerx(l, -1, &mut whole);
        lua_pop(l, 1);
        match (whole, fallback) {
            (0, Some(fallback)) => fallback,
            (0, None) => {
                errors::raise_text(l, "expected a date with the fields year, month and day");
                0
            }
            _ => value.clamp(-1 << 40, 1 << 40),
        }
    };
    let (year, month, day) = (field(c"year", None), field(c"month", None), field(c"day", None));
    let (hour, min, sec) = (field(c"hour", Some(12)), field(c"min", Some(0)), field(c"sec", Some(0)));
    let months = year * 12 + month - 1;
    let days = days_from_civil(months.div_euclid(12), months.rem_euclid(12) + 1, 1) + day - 1;
    lua_pushinteger(l, ((days * 24 + hour) * 60 + min) * 60 + sec);
    1
}

/// Returns the number of days from 1970-01-01 to a date of the Gregorian calendar. `civil_from_days` is the inverse
/// function (H. Hinnant, "chrono-compatible low-level date algorithms").
fn days_from_civil(year: i64, month: i64, day: i64) -> i64 {
    let y = if month <= 2 { year - 1 } else { year };
    let era = y.div_euclid(400);
    let of_era = y - era * 400;
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468
}

fn civil_from_days(days: i64) -> (i64, i64, i64) {
    let z = days + 719_468;
    let era = z.div_euclid(146_097);
    let doe = z.rem_euclid(146_097);
    let yoe = (doe - doe / 1460 + doe / 36_524 - doe / 146_096) / 365;
    let doy = doe - (365 * yoe + yoe / 4 - yoe / 100);
    let mp = (5 * doy + 2) / 153;
    let month = if mp < 10 { mp + 3 } else { mp - 9 };
    let year = yoe + era * 400 + i64::from(month <= 2);
    (year, month, doy - (153 * mp + 2) / 5 + 1)
}

struct Date {
    year: i64,
    month: i64,
    day: i64,
    hour: i64,
    min: i64,
    sec: i64,
    /// Day of the week; 0: Sunday.
    weekday: i64,
    /// Day of the year; 1: January 1st.
    yearday: i64,
}

impl Date {
    fn new(time: i64) -> Self {
        let (days, rest) = (time.div_euclid(86_400), time.rem_euclid(86_400));
        let (year, month, day) = civil_from_days(days);
        Date {
            year,
            month,
            day,
            hour: rest / 3600,
            min: rest / 60 % 60,
            sec: rest % 60,
            weekday: (days + 4).rem_euclid(7),
            yearday: days - days_from_civil(year, 1, 1) + 1,
        }
    }
    /// Appends the result of a `strftime` conversion; returns false if the conversion is unknown.
    fn add(&self, conversion: char, out: &mut String) -> bool {
        let (day, month) = (DAY_NAMES[self.weekday as usize], MONTH_NAMES[self.month as usize - 1]);
        let _ = match conversion {
            'Y' => write!(out, "{}", self.year),
            'y' => write!(out, "{:02}", self.year.rem_euclid(100)),
            'm' => write!(out, "{:02}", self.month),
            'd' => write!(out, "{:02}", self.day),
            'e' => write!(out, "{:2}", self.day),
            'H' => write!(out, "{:02}", self.hour),
            'I' => write!(out, "{:02}", (self.hour + 11) % 12 + 1),
            'M' => write!(out, "{:02}", self.min),
            'S' => write!(out, "{:02}", self.sec),
            'p' => write!(out, "{}", if self.hour < 12 { "AM" } else { "PM" }),
            'A' => write!(out, "{day}"),
            'a' => write!(out, "{}", &day[..3]),
            'B' => write!(out, "{month}"),
            'b' | 'h' => write!(out, "{}", &month[..3]),
            'j' => write!(out, "{:03}", self.yearday),
            'w' => write!(out, "{}", self.weekday),
            'Z' => write!(out, "UTC"),
            'z' => write!(out, "+0000"),
            'n' => writeln!(out),
            't' => write!(out, "\t"),
            '%' => write!(out, "%"),
            'c' => return self.format_all("%a %b %e %H:%M:%S %Y", out),
            'x' | 'D' => return self.format_all("%m/%d/%y", out),
            'X' | 'T' => return self.format_all("%H:%M:%S", out),
            'F' => return self.format_all("%Y-%m-%d", out),
            'R' => return self.format_all("%H:%M", out),
            _ => return false,
        };
        true
    }
    fn format_all(&self, format: &str, out: &mut String) -> bool {
        let mut chars = format.chars();
        while let Some(c) = chars.next() {
            if c != '%' {
                out.push(c);
            } else if !chars.next().is_some_and(|c| self.add(c, out)) {
                return false;
            }
        }
        true
    }
}

fn format(s: &ScriptState, format: &[u8], time: i64) -> bool {
    let mut out = String::new();
    let done = Date::new(time).format_all(&String::from_utf8_lossy(format), &mut out);
    *s.streams.scratch.borrow_mut() = out.into_bytes();
    done
}

unsafe extern "C-unwind" fn date(l: *mut lua_State) -> i32 {
    const MAX_ABS_TIME: i64 = 1 << 45;
    let s = state::of(l);
    let what = if lua_type(l, 1) <= LUA_TNIL {
        b"%c"
    } else {
        luaL_checklstring(l, 1, std::ptr::null_mut());
        bytes(l, 1)
    };
    let what = what.strip_prefix(b"!").unwrap_or(what);
    budget::charge(l, what.len() as u64);
    let time = if lua_type(l, 2) <= LUA_TNIL {
        seconds(s)
    } else {
        luaL_checknumber(l, 2).clamp(-MAX_ABS_TIME as f64, MAX_ABS_TIME as f64) as i64
    };
    if !what.starts_with(b"*t") {
        if !format(s, what, time) {
            return errors::raise_text(l, "bad argument #1 to 'date' (invalid conversion)");
        }
        push_scratch(l, s);
        return 1;
    }
    let d = Date::new(time);
    lua_createtable(l, 0, 9);
    for (name, value) in [
        (c"year", d.year),
        (c"month", d.month),
        (c"day", d.day),
        (c"hour", d.hour),
        (c"min", d.min),
        (c"sec", d.sec),
        (c"wday", d.weekday + 1),
        (c"yday", d.yearday),
    ] {
        lua_pushinteger(l, value);
        lua_setfield(l, -2, name.as_ptr());
    }
    lua_pushboolean(l, 0);
    lua_setfield(l, -2, c"isdst".as_ptr());
    1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_formatted_and_converted() {
        let mut out = String::new();
        assert!(Date::new(EPOCH + 3661).format_all("%c|%F %X %j %p", &mut out));
        assert_eq!(out, "Thu Jan  1 01:01:01 2015|2015-01-01 01:01:01 001 AM");
        for days in (-800_000..800_000).step_by(97) {
            let (y, m, d) = civil_from_days(days);
            assert_eq!(days_from_civil(y, m, d), days);
        }
    }
}
