// Base records, one per sample: depth (cm), linear RGB radiance and transparency (four halves),
// normal (octahedral).

#import shared/halves
#import shared/octahedral

// Depth of a sample at which there is no skin.
const NO_BASE: f32 = 1e30;

fn pack_base(z: f32, radiance: vec3f, normal: vec3f) -> vec4u {
    return pack_translucent_base(z, radiance, 0.0, normal);
}

// `transparency`: share of the background that shows through, which only shadow catchers have.
fn pack_translucent_base(z: f32, radiance: vec3f, transparency: f32, normal: vec3f) -> vec4u {
    return vec4u(bitcast<u32>(z), pack_half4(vec4f(radiance, transparency)), pack_direction(normal));
}

fn base_transparency(record: vec4u) -> f32 {
    return unpack2x16float(record.z).y;
}

fn base_depth(record: vec4u) -> f32 {
    return bitcast<f32>(record.x);
}

fn base_radiance(record: vec4u) -> vec3f {
    return unpack_half4(record.yz).xyz;
}

// Factor on the radiance: the inner side of an open skin is dimmed.
fn side_factor(front: bool) -> f32 {
    return select(0.15, 1.0, front);
}
