//! The structs of `layout.rs` have the memory layout of their WGSL counterparts.

use pelage_fur::layout::STRUCTS;
use pelage_gpu::shader;
use pelage_render::shaders;
use std::collections::{BTreeMap, BTreeSet};

/// Least number of structs that Rust and WGSL share.
const LEAST: usize = 15;

/// Name -> (size, fields) of the structs of all shaders, with naga's layout.
fn wgsl_structs() -> BTreeMap<String, (u32, Vec<(String, u32)>)> {
    let mut found = BTreeMap::new();
    for name in shaders::names().iter().filter(|name| !name.starts_with("shared/")) {
        let (_, module, _) = shader::validate(shaders::text, name).unwrap();
        for (_, ty) in module.types.iter() {
            if let (Some(name), naga::TypeInner::Struct { members, span }) = (&ty.name, &ty.inner) {
                let fields: Vec<(String, u32)> =
                    members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect();
                let earlier = found.insert(name.clone(), (*span, fields.clone()));
                // What a stage hands to the next is each pass's own affair.
                let bound = STRUCTS.iter().any(|(known, ..)| known == name);
                assert!(
                    !bound || earlier.is_none_or(|e| e == (*span, fields)),
                    "{name} is declared in two ways"
                );
            }
        }
    }
    found
}

/// Names of the structs that shaders declare as uniforms or in storage buffers.
fn bound_structs() -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for name in shaders::names().iter().filter(|name| !name.starts_with("shared/")) {
        let (_, module, _) = shader::validate(shaders::text, name).unwrap();
        for (_, variable) in module.global_variables.iter().filter(|(_, v)| v.binding.is_some()) {
            let mut ty = &module.types[variable.ty];
            while let naga::TypeInner::Array { base, .. } = ty.inner {
                ty = &module.types[base];
            }
            if let (naga::TypeInner::Struct { .. }, Some(name)) = (&ty.inner, &ty.name) {
                found.insert(name.clone());
            }
        }
    }
    found
}

#[test]
fn every_bound_struct_stands_in_the_layout() {
    let known: BTreeSet<String> = STRUCTS.iter().map(|(name, ..)| (*name).to_owned()).collect();
    assert_eq!(known.len(), STRUCTS.len(), "a name stands twice");
    let bound = bound_structs();
    assert!(bound.len() >= 20, "{bound:?}");
    let missing: Vec<&String> = bound.difference(&known).collect();
    assert!(missing.is_empty(), "structs of shaders that layout.rs lacks: {missing:?}");
}

#[test]
fn words_of_records_agree_with_wgsl() {
    let (_, module, _) = shader::validate(shaders::text, "resolve").unwrap();
    let constant = |name: &str| {
        let found = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name));
        let (_, constant) = found.unwrap_or_else(|| panic!("no WGSL constant {name}"));
        match module.global_expressions[constant.init] {
            naga::Expression::Literal(naga::Literal::U32(value)) => value,
            ref other => panic!("{name} is {other:?}"),
        }
    };
    assert_eq!(constant("NODE_WORDS"), pelage_fur::layout::NODE_WORDS);
    assert_eq!(constant("NODE_FEATURE_WORDS"), pelage_fur::layout::NODE_FEATURE_WORDS);
}

#[test]
fn structs_agree_with_wgsl() {
    let wgsl = wgsl_structs();
    let structs = STRUCTS;
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
