// Octahedral map of unit vectors, -1..1 in both coordinates. [Meyer2010], [Cigolle2014]

fn octahedral_encode(v: vec3f) -> vec2f {
    let p = v.xy / (abs(v.x) + abs(v.y) + abs(v.z));
    let folded = (1.0 - abs(p.yx)) * select(vec2f(-1.0), vec2f(1.0), p >= vec2f(0.0));
    return select(folded, p, v.z >= 0.0);
}

fn octahedral_decode(e: vec2f) -> vec3f {
    var v = vec3f(e, 1.0 - abs(e.x) - abs(e.y));
    let fold = max(-v.z, 0.0);
    v.x += select(fold, -fold, v.x >= 0.0);
    v.y += select(fold, -fold, v.y >= 0.0);
    return normalize(v);
}

// A direction in one word: two signed normalised 16-bit numbers.
fn pack_direction(v: vec3f) -> u32 {
    return pack2x16snorm(octahedral_encode(v));
}

fn unpack_direction(word: u32) -> vec3f {
    return octahedral_decode(unpack2x16snorm(word));
}
