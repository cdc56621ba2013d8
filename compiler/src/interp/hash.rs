//! OSL's integer hash (specification ch. 7.6): Bob Jenkins' lookup3 (2006, public domain) of a few 32-bit words.
//!
//! In: words, or constants: ints, and floats by the bits of their rounding to 32 bits. Out: 32 bits.

use super::{float, triple};
use crate::ir::Const;

fn mix(v: &mut [u32; 3]) {
    for (i, by) in [4, 6, 8, 16, 19, 4].into_iter().enumerate() {
        // The roles rotate: a with c, b with a, c with b.
        let (p, before, after) = (i % 3, (i + 2) % 3, (i + 1) % 3);
        v[p] = v[p].wrapping_sub(v[before]) ^ v[before].rotate_left(by);
        v[before] = v[before].wrapping_add(v[after]);
    }
}

/// The last mixing; the result is the third word.
pub(super) fn finish(mut v: [u32; 3]) -> u32 {
    for (i, by) in [14, 11, 25, 16, 4, 14, 24].into_iter().enumerate() {
        // c with b, a with c, b with a, ...
        let (p, before) = ((i + 2) % 3, (i + 1) % 3);
        v[p] = (v[p] ^ v[before]).wrapping_sub(v[before].rotate_left(by));
    }
    v[2]
}

/// The hash of a few words.
pub(super) fn hash(words: &[u32]) -> u32 {
    let seed = 0xdead_beef_u32.wrapping_add(4 * words.len() as u32).wrapping_add(13);
    let mut v = [seed; 3];
    let mut chunks = words.chunks(3).peekable();
    while let Some(chunk) = chunks.next() {
        for (to, word) in v.iter_mut().zip(chunk) {
            *to = to.wrapping_add(*word);
        }
        if chunks.peek().is_some() {
            mix(&mut v);
        }
    }
    finish(v)
}

/// The word that stands for a float.
pub(super) fn bits(x: f64) -> u32 {
    (x as f32).to_bits()
}

/// The value of the row `name`.
pub(super) fn call(name: &str, args: &[Const]) -> Option<Const> {
    if name != "hash_value" {
        return None;
    }
    let mut words = Vec::with_capacity(4);
    for (i, arg) in args.iter().enumerate() {
        match arg {
            Const::Int(v) => words.push(*v as u32),
            Const::Triple(_) => words.extend(triple(args, i)?.map(bits)),
            _ => words.push(bits(float(args, i)?)),
        }
    }
    Some(Const::Int(hash(&words) as i32))
}
