//! The structs of `layout.rs` have the memory layout of their WGSL counterparts.

use pelage_gpu::shader;
use pelage_render::shaders;
use std::collections::BTreeMap;

/// Least number of structs that Rust and WGSL share.
const LEAST: usize = 15;

/// Name -> (size, fields) of the structs of all shaders, with naga's layout.
fn wgsl_structs() -> BTreeMap<String, (u32, Vec<(String, u32)>)> {
    let mut found = BTreeMap::new();
    for name in shaders::names().iter().filter(|name| !name.starts_with("shared/")) {
        let (_, module, _) = shader::validate(shaders::text, name).unwrap();
        for (_, ty) in module.types.iter() {
            if let (Some(name), naga::TypeInner::Struct { members, span }) = (&ty.name, &ty.inner) {
                let fields = members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect();
                found.insert(name.clone(), (*span, fields));
            }
        }
    }
    found
}

#[test]
fn structs_agree_with_wgsl() {
    let wgsl = wgsl_structs();
    let structs = pelage_fur::layout::STRUCTS;
    assert!(structs.len() >= LEAST, "{} structs, expected {LEAST} or more", structs.len());
    for (name, size, fields) in structs {
        let (span, members) = wgsl.get(*name).unwrap_or_else(|| panic!("no WGSL struct {name}"));
        let rust: Vec<(String, u32)> = fields
            .iter()
            .filter(|(f, _)| *f != "padding")
            .map(|(f, o)| ((*f).to_owned(), *o as u32))
            .collect();
        let members: Vec<(String, u32)> = members.iter().filter(|(f, _)| f != "padding").cloned().collect();
        assert_eq!(rust, members, "{name}");
        assert_eq!(*size as u32, *span, "size of {name}");
    }
}
