//! Texture lookups: the rows' arguments become a [`Lookup`], and whoever reads files answers it.
//!
//! In: the rows that `lower::texture` writes. Out: their values. It must not know files.

use crate::ir::{Const, Ty};
use crate::textures::{Kind, Lookup, MODE_INTERP, MODE_MISSING, MODE_R, MODE_T, Texel, TextureAccess};

/// The value of the row `name`; `None` when it is no lookup or nobody reads files.
pub(super) fn call(name: &str, ret: Ty, args: &[Const], access: Option<&TextureAccess>) -> Option<Const> {
    let (function, what) = name.split_once('_')?;
    let textures = &access?.0;
    match (function, what, args) {
        ("texture", "error", [Const::Str(file), Const::Float(s), Const::Float(t), Const::Int(n), Const::Str(part)]) => {
            Some(Const::Str(textures.error(file, [*s, *t], *n, part)))
        }
        ("texture", "lookup" | "ds" | "dt", [Const::Str(file), rest @ ..]) => {
            let [s, t, dsdx, dtdx, dsdy, dtdy] = floats(rest)?;
            let lookup = Lookup { at: [s, t, 0.0], dx: [dsdx, dtdx, 0.0], dy: [dsdy, dtdy, 0.0], ..blank(file, ret) };
            result(&textures.lookup(&filtered(&rest[6..], options(&rest[6..], lookup)?)?), what, ret)
        }
        (
            "environment",
            "lookup",
            [Const::Str(file), Const::Triple(r), Const::Triple(dx), Const::Triple(dy), rest @ ..],
        ) => {
            let lookup = Lookup { kind: Kind::Environment, at: *r, dx: *dx, dy: *dy, ..blank(file, ret) };
            result(&textures.lookup(&filtered(rest, options(rest, lookup)?)?), what, ret)
        }
        ("texture3d", _, [Const::Str(file), Const::Triple(p), rest @ ..]) => {
            let lookup = Lookup { kind: Kind::Volume, at: *p, ..blank(file, ret) };
            result(&textures.lookup(&options(rest, lookup)?), what, ret)
        }
        _ => None,
    }
}

fn blank(file: &str, ret: Ty) -> Lookup<'_> {
    Lookup {
        kind: Kind::Texture,
        file,
        at: [0.0; 3],
        dx: [0.0; 3],
        dy: [0.0; 3],
        wraps: [0; 3],
        interp: 0,
        first_channel: 0,
        channels: if ret == Ty::Triple { 3 } else { 1 },
        subimage: 0,
        subimage_name: "",
        width: [1.0; 2],
        blur: [0.0; 2],
        fill: 0.0,
        missing: None,
    }
}

fn floats<const N: usize>(args: &[Const]) -> Option<[f64; N]> {
    let mut out = [0.0; N];
    for (to, from) in out.iter_mut().zip(args.get(..N)?) {
        let Const::Float(x) = from else { return None };
        *to = *x;
    }
    Some(out)
}

/// Reads mode, first channel, subimage by number and name from the front, fill and the missing colour from the back.
fn options<'a>(args: &'a [Const], lookup: Lookup<'a>) -> Option<Lookup<'a>> {
    let [
        Const::Int(mode),
        Const::Int(first),
        Const::Int(part),
        Const::Str(name),
        ..,
        Const::Float(fill),
        Const::Triple(missing),
    ] = args
    else {
        return None;
    };
    Some(Lookup {
        wraps: [mode & 7, (mode / MODE_T) & 7, (mode / MODE_R) & 7],
        interp: (mode / MODE_INTERP) & 3,
        missing: (mode & MODE_MISSING != 0).then_some(*missing),
        first_channel: *first,
        subimage: *part,
        subimage_name: name,
        fill: *fill,
        ..lookup
    })
}

/// Reads widths and blurs, behind the first four options.
fn filtered<'a>(args: &[Const], lookup: Lookup<'a>) -> Option<Lookup<'a>> {
    let [swidth, twidth, sblur, tblur] = floats(args.get(4..)?)?;
    Some(Lookup { width: [swidth, twidth], blur: [sblur, tblur], ..lookup })
}

fn result(texel: &Texel, what: &str, ret: Ty) -> Option<Const> {
    let value = match what {
        "ds" => texel.by[0],
        "dt" => texel.by[1],
        "dr" => texel.by[2],
        _ => texel.value,
    };
    Some(if ret == Ty::Triple { Const::Triple(value) } else { Const::Float(value[0]) })
}
