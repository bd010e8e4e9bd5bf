//! The table through which plugins draw random numbers for the instances of a batch.

use std::marker::PhantomData;

use tatu_plugin_api::abi::tatu_random;

/// A source of random numbers, each of which is a function of its index.
pub trait RandomNumbers: Copy {
    /// Fills `out` with numbers that are uniformly distributed in [0, 1), starting at index `first`.
    fn uniforms(self, first: u64, out: &mut [f64]);
    /// Fills `out` with numbers from the standard normal distribution, starting at index `first`.
    fn normals(self, first: u64, out: &mut [f64]);
}

/// The table for a batch whose instances have these sources.
pub struct RandomTable<'a> {
    raw: tatu_random,
    sources: PhantomData<&'a ()>,
}

impl<'a> RandomTable<'a> {
    /// Creates the table.
    pub fn new<N: RandomNumbers>(sources: &'a [N]) -> Self {
        let raw = tatu_random {
            size: size_of::<tatu_random>() as u32,
            reserved: sources.len() as u32,
            ctx: sources.as_ptr().cast_mut().cast(),
            uniform: Some(draw::<N, false>),
            normal: Some(draw::<N, true>),
        };
        RandomTable { raw, sources: PhantomData }
    }

    /// Returns the table for plugins.
    pub fn raw(&self) -> &tatu_random {
        &self.raw
    }
}

unsafe extern "C" fn draw<N: RandomNumbers, const NORMAL: bool>(
    table: *const tatu_random,
    i: u32,
    first: u64,
    n: u64,
    out: *mut f64,
) {
    // SAFETY: the header requires `table` to be the table of the plugin's batch, whose sources, of type `N`, live during
    // the call, and `out` to be null or to have room for `n` numbers; `i` and `out` are checked before use. The memory
    // at `out` is initialised before a slice of it is created.
    let (source, out) = unsafe {
        if i >= (*table).reserved || n == 0 || out.is_null() {
            return;
        }
        out.write_bytes(0, n as usize);
        (*(*table).ctx.cast::<N>().add(i as usize), std::slice::from_raw_parts_mut(out, n as usize))
    };
    match NORMAL {
        true => source.normals(first, out),
        false => source.uniforms(first, out),
    }
}
