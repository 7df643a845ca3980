//! Every shader resolves and validates exactly as at run time.

use pelage_gpu::shader;
use pelage_render::shaders;

#[test]
fn every_shader_validates() {
    let names: Vec<String> =
        shaders::names().into_iter().filter(|name| !name.starts_with("shared/")).collect();
    assert!(names.len() >= 20, "{names:?}");
    let faults: Vec<String> = names
        .iter()
        .filter_map(|name| shader::validate(shaders::text, name).err())
        .map(|fault| fault.to_string())
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn faults_name_file_and_line() {
    let broken = |name: &str| match name {
        "broken" => Some("#import shared/broken\nfn f() -> f32 { return wrong(); }\n".into()),
        "shared/broken" => Some("fn wrong() -> u32 {\n    return 1.5;\n}\n".into()),
        "lost" => Some("// a line\n#import shared/lost\n".into()),
        _ => None,
    };
    let message = |name| shader::validate(broken, name).err().expect("a fault").to_string();
    assert!(message("broken").contains("shaders/shared/broken.wgsl:"), "{}", message("broken"));
    assert!(message("lost").contains("shaders/lost.wgsl:2"), "{}", message("lost"));
}
