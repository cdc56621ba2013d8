//! The two forms of a constant: for tools its bare value, for files a value that says which constant it is.
//!
//! In: constants, a serde format. Out: JSON and the like get numbers, texts and lists; formats that are not for people get the
//! variant's name too, without which an array of three numbers would come back as a triple.

use super::Const;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// What tools see.
#[derive(Serialize)]
#[serde(remote = "Const", untagged)]
enum Bare {
    Int(i32),
    Float(f64),
    Triple([f64; 3]),
    Matrix([f64; 16]),
    Str(String),
    Array(Vec<Const>),
}

/// What reads back as it was.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Const")]
enum Named {
    Int(i32),
    Float(f64),
    Triple([f64; 3]),
    Matrix([f64; 16]),
    Str(String),
    Array(Vec<Const>),
}

impl Serialize for Const {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match to.is_human_readable() {
            true => Bare::serialize(self, to),
            false => Named::serialize(self, to),
        }
    }
}

impl<'de> Deserialize<'de> for Const {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Const, D::Error> {
        if from.is_human_readable() {
            return Err(serde::de::Error::custom("the form for people does not say which constant a value is"));
        }
        Named::deserialize(from)
    }
}
