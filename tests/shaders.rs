//! Every shader resolves and validates exactly as at run time.

#[test]
fn every_shader_validates() {
    let mut faults = Vec::new();
    for (name, _) in pelage_gpu::shader::SOURCES.iter().filter(|(name, _)| !name.starts_with("shared/")) {
        if let Err(e) = pelage_gpu::shader::validate(name) {
            faults.push(e.to_string());
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
