// A sample of the film, packed in two vectors of four words; with FEATURES, in four.

#import shared/halves
#import shared/features

struct FilmSample {
    guard: vec3f,       // premultiplied linear RGB radiance of the guard hairs
    undercoat: vec3f,   // that of the undercoat
    base: vec3f,        // that of the skin or of an object
    through: f32,       // transmittance
    z: f32,             // mean depth weighted by opacity, cm; NO_BASE where nothing is hit
    normal: u32,        // of the skin, a packed direction; 0: none
    fragments: u32,     // length of the list
}

fn pack_film_sample(s: FilmSample) -> array<vec4u, 2> {
    return array<vec4u, 2>(vec4u(pack_half3x2(s.guard, s.undercoat), pack2x16float(within_half2(s.base.rg))),
        vec4u(pack2x16float(within_half2(vec2f(s.base.b, s.through))), bitcast<u32>(s.z), s.normal, s.fragments));
}

fn unpack_film_sample(first: vec4u, second: vec4u) -> FilmSample {
    let fur_radiance = unpack_half3x2(first.xyz);
    let last = unpack2x16float(second.x);
    return FilmSample(fur_radiance[0], fur_radiance[1], vec3f(unpack2x16float(first.w), last.x), last.y,
        bitcast<f32>(second.y), second.z, second.w);
}

// Number of the first vector of a sample.
fn sample_vector(i: u32) -> u32 {
    return i * select(2u, 4u, FEATURES);
}

// With FEATURES, what follows in a sample: sums over what is visible, weighted by opacity.
struct FeatureSample {
    albedo: vec3f,
    normal: vec3f,
    tangent: vec3f,   // direction of the hairs, from root to tip
    coverage: vec3f,  // of guard hairs, undercoat and base: their sum is the sample's alpha
    object: u32,      // what the base is: 0 for the skin, else 1 + number of the object
}

fn pack_feature_sample(s: FeatureSample) -> array<vec4u, 2> {
    return array<vec4u, 2>(vec4u(pack_half3x2(s.albedo, s.normal), pack2x16float(s.tangent.xy)),
        vec4u(pack2x16float(vec2f(s.tangent.z, 0.0)) | (s.object << 16u), bitcast<vec3u>(s.coverage)));
}

fn unpack_feature_sample(first: vec4u, second: vec4u) -> FeatureSample {
    let two = unpack_half3x2(first.xyz);
    let tangent = vec3f(unpack2x16float(first.w), unpack2x16float(second.x).x);
    return FeatureSample(two[0], two[1], tangent, bitcast<vec3f>(second.yzw), second.x >> 16u);
}
