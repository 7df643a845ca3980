// A sample of the film, packed in two vectors of four words.

#import shared/halves

struct FilmSample {
    guard: vec3f,       // premultiplied linear RGB radiance of the guard hairs
    undercoat: vec3f,   // that of the undercoat
    base: vec3f,        // that of the skin
    through: f32,       // transmittance
    z: f32,             // mean depth weighted by opacity, cm; NO_BASE where nothing is hit
    normal: u32,        // of the skin, a packed direction; 0: none
    fragments: u32,     // length of the list
}

fn pack_film_sample(s: FilmSample) -> array<vec4u, 2> {
    return array<vec4u, 2>(vec4u(pack_half3x2(s.guard, s.undercoat), pack2x16float(s.base.rg)),
        vec4u(pack2x16float(vec2f(s.base.b, s.through)), bitcast<u32>(s.z), s.normal, s.fragments));
}

fn unpack_film_sample(first: vec4u, second: vec4u) -> FilmSample {
    let fur_radiance = unpack_half3x2(first.xyz);
    let last = unpack2x16float(second.x);
    return FilmSample(fur_radiance[0], fur_radiance[1], vec3f(unpack2x16float(first.w), last.x), last.y,
        bitcast<f32>(second.y), second.z, second.w);
}
