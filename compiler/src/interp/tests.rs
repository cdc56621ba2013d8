//! The host library against the values of the reference implementation and of the documentation.

mod special;
