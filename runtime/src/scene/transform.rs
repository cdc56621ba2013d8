//! Transforms of a scene file.
//!
//! In: a table, or a list of them, first applied first. Out: an affine map, object to world. It must not know meshes.

use super::error::Error;
use super::value::{Table, Value};
use glam::{DAffine3, DMat3, DVec3};

/// Reads the key `transform` of a mesh or an instance; the identity without one.
pub(super) fn read(owner: &Table<'_>) -> Result<DAffine3, Error> {
    let Some(value) = owner.get("transform") else { return Ok(DAffine3::IDENTITY) };
    let mut whole = DAffine3::IDENTITY;
    let steps = match value.items() {
        Some(items) => items,
        None => vec![value.clone()],
    };
    for step in steps {
        let table = step.table().map_err(|_| step.wrong_type("a table or a list of tables"))?;
        whole = one(&table)? * whole;
    }
    if is_singular(&whole) {
        return Err(Error::Singular { at: value.at(), object: owner.name.clone() });
    }
    Ok(whole)
}

/// Whether a map has no inverse worth the name, whatever its scale: one axis shrinks a trillion times more than another, so that
/// rounding in f64 leaves its inverse a digit or three. By the condition number, not the determinant: that is as small when two axes
/// shrink a million times, which has an inverse to ten digits.
pub(super) fn is_singular(map: &DAffine3) -> bool {
    let largest = |m: DMat3| m.to_cols_array().iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let size = largest(map.matrix3);
    let unit = map.matrix3 * (1.0 / size);
    // The negation is true of NaN too.
    !(size > 0.0 && map.is_finite() && unit.determinant() != 0.0 && largest(unit.inverse()) < 1e12)
}

/// One table: scale, then rotate, then translate; or a matrix.
fn one(table: &Table<'_>) -> Result<DAffine3, Error> {
    table.only(&["translate", "rotate", "scale", "matrix"])?;
    if let Some(value) = table.get("matrix") {
        table.only(&["matrix"]).map_err(|_| Error::Conflict {
            at: table.at(),
            cause: format!("`{}` has a matrix and more\n  help: write a list of transforms", table.name),
        })?;
        return matrix(&value);
    }
    let scale = match table.get("scale") {
        None => DVec3::ONE,
        Some(value) if value.items().is_some() => value.vector()?,
        Some(value) => DVec3::splat(value.number().map_err(|error| match error {
            Error::WrongType { .. } => value.wrong_type("a number or a list of 3 numbers"),
            other => other,
        })?),
    };
    let rotation = match table.get("rotate") {
        None => DMat3::IDENTITY,
        Some(value) => rotation(&value.table()?)?,
    };
    let translation = match table.get("translate") {
        None => DVec3::ZERO,
        Some(value) => value.vector()?,
    };
    Ok(DAffine3 { matrix3: rotation * DMat3::from_diagonal(scale), translation })
}

/// By the right-hand rule: seen against the axis, counter-clockwise.
fn rotation(table: &Table<'_>) -> Result<DMat3, Error> {
    table.only(&["axis", "degrees"])?;
    let axis = table.need("axis")?;
    let degrees = table.need("degrees")?.number()?;
    let unit = axis.vector()?.try_normalize().ok_or_else(|| axis.out_of_range("an axis of some length"))?;
    Ok(DMat3::from_axis_angle(unit, degrees.to_radians()))
}

/// Sixteen numbers, row by row, for column vectors: the translation is the fourth of each row.
fn matrix(value: &Value<'_>) -> Result<DAffine3, Error> {
    let m = value.numbers::<16>()?;
    if m[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err(value.out_of_range("a matrix whose last row is 0, 0, 0, 1"));
    }
    let column = |c: usize| DVec3::new(m[c], m[4 + c], m[8 + c]);
    Ok(DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) })
}
