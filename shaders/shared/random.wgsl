// Random numbers: integer hashes of stable ids, so that nothing depends on the order of threads.

#import shared/angles
#import shared/constants

// "lowbias32" integer hash. [Wellons2018]
fn hash(value: u32) -> u32 {
    var x = value;
    x = (x ^ (x >> 16u)) * 0x7feb352du;
    x = (x ^ (x >> 15u)) * 0x846ca68bu;
    return x ^ (x >> 16u);
}

fn hash2(a: u32, b: u32) -> u32 {
    return hash(a ^ hash(b + 0x9e3779b9u));
}

// Uniform in [0, 1) with 24 bits.
fn unit_float(h: u32) -> f32 {
    return f32(h >> 8u) * 5.9604645e-8;
}

// The k-th uniform number of a seed.
fn random(seed: u32, k: u32) -> f32 {
    return unit_float(hash2(seed, k));
}

// Uniform numbers k and k + 1 of a seed.
fn random2(seed: u32, k: u32) -> vec2f {
    return vec2f(random(seed, k), random(seed, k + 1u));
}

// Uniform numbers k to k + 2 of a seed.
fn random3(seed: u32, k: u32) -> vec3f {
    return vec3f(random(seed, k), random(seed, k + 1u), random(seed, k + 2u));
}

// Point k of the R2 sequence in the unit square, displaced by `start`. [Roberts2018]
fn r2_point(start: vec2f, k: u32) -> vec2f {
    return fract(start + f32(k) * vec2f(0.7548777, 0.5698403));
}

// Uniform on the unit sphere, from numbers k and k + 1 of a seed.
fn random_direction(seed: u32, k: u32) -> vec3f {
    let z = 1.0 - 2.0 * random(seed, k);
    let phi = TAU * random(seed, k + 1u);
    return vec3f(complement(z) * vec2f(cos(phi), sin(phi)), z);
}
