//! Terms: small pure functions shared by bakes. Each file has a GLSL twin at `shaders/term/<same name>.glsl` with
//! functions of the same names and arguments.

pub mod cube;
