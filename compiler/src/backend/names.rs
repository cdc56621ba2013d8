//! Names in the emitted text.
//!
//! Users' names get a prefix (`p_` parameters, `g_` globals that the shader writes, `l_` variables), so that none can be
//! a keyword, a macro or a function of OpenCL C or of the kernels. The text's own names: `tN` values, `leaveN` flags.

use crate::ir::{LocalKind, Shader, Ty};
use std::collections::{HashMap, HashSet};

/// Longer names are cut.
const MAX_NAME: usize = 48;

/// A name with only letters, digits and underscores.
pub(in crate::backend) fn sanitise(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    name.chars().take(MAX_NAME).map(safe).collect()
}

/// One unique name per local of the shader.
pub(in crate::backend) fn of_locals(shader: &Shader) -> Vec<String> {
    let mut taken: HashSet<String> = HashSet::new();
    let mut counts: HashMap<String, u32> = HashMap::new();
    let mut name = |local: &crate::ir::Local| {
        let prefix = match local.kind {
            LocalKind::Param(_) => 'p',
            LocalKind::Global(_) => 'g',
            LocalKind::Input(_) => 'i',
            LocalKind::Variable => 'l',
        };
        let base = format!("{prefix}_{}", sanitise(&local.name));
        let count = counts.entry(base.clone()).or_insert(0);
        loop {
            *count += 1;
            let name = if *count == 1 { base.clone() } else { format!("{base}_{count}") };
            if taken.insert(name.clone()) {
                return name;
            }
        }
    };
    shader.locals.iter().map(&mut name).collect()
}

/// The C type of a single value.
pub(in crate::backend) fn ctype(ty: Ty) -> &'static str {
    match ty {
        Ty::Int | Ty::Str => "int",
        Ty::Float => "real",
        Ty::Triple => "real3",
        Ty::Matrix => "mat4",
        Ty::Closure => "closure",
    }
}

/// `osl_NAME_RET_ARGS`, the kernel function of a built-in (see [`crate::builtins`]); without arguments `osl_NAME_RET_`.
pub(in crate::backend) fn kernel_function(name: &str, result: Option<Ty>, codes: &str) -> String {
    let result = result.map_or('n', Ty::code);
    format!("osl_{name}_{result}_{codes}")
}

/// `closure_NAME_CODES`, the constructor of a lobe; without arguments `closure_NAME`. `args` as in the table of closures.
pub(in crate::backend) fn lobe_constructor(name: &str, args: &str) -> String {
    let code = |arg: &str| match arg.trim() {
        "int" => 'i',
        "float" => 'f',
        "string" => 's',
        "matrix" => 'm',
        "closure color" => 'c',
        _ => 'v',
    };
    let codes: String = args.split(',').filter(|a| !a.is_empty()).map(code).collect();
    if codes.is_empty() { format!("closure_{name}") } else { format!("closure_{name}_{codes}") }
}

/// The name of a program-scope function: readable, and different for different text (64-bit FNV-1a).
pub(in crate::backend) fn entry(prefix: &str, shader: &str, text: &str) -> String {
    let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
    format!("{prefix}_{}_{hash:016x}", sanitise(shader))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::{Block, Local};

    #[test]
    fn locals_get_unique_names() {
        let local = |name: &str, kind| Local { name: name.into(), ty: Ty::Int, len: None, kind };
        let names = ["kernel", "kernel", "kernel_2", "a.x"].map(|n| local(n, LocalKind::Variable));
        let shader = Shader {
            name: "s".into(),
            kind: "surface".into(),
            params: Vec::new(),
            locals: names.into_iter().chain([local("Kd", LocalKind::Param(0))]).collect(),
            values: Vec::new(),
            body: Block::default(),
            slots: Vec::new(),
            inputs: Vec::new(),
            derivative_uses: Vec::new(),
        };
        assert_eq!(of_locals(&shader), ["l_kernel", "l_kernel_2", "l_kernel_2_2", "l_a_x", "p_Kd"]);
    }

    #[test]
    fn functions_follow_the_rule_of_the_table() {
        assert_eq!(kernel_function("dot", Some(Ty::Float), "vv"), "osl_dot_f_vv");
        assert_eq!(kernel_function("sincos", None, "fofof"), "osl_sincos_n_fofof");
        assert_eq!(kernel_function("backfacing", Some(Ty::Int), ""), "osl_backfacing_i_");
        assert_eq!(lobe_constructor("microfacet", "string,normal,float,float,int"), "closure_microfacet_svffi");
        assert_eq!(lobe_constructor("transparent", ""), "closure_transparent");
    }
}
