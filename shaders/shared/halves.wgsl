// Vectors packed as half floats. Values beyond the largest half become that: bright lights must
// not turn into infinities.

fn within_half2(v: vec2f) -> vec2f {
    return clamp(v, vec2f(-65504.0), vec2f(65504.0));
}

fn pack_half4(v: vec4f) -> vec2u {
    return vec2u(pack2x16float(within_half2(v.xy)), pack2x16float(within_half2(v.zw)));
}

fn unpack_half4(words: vec2u) -> vec4f {
    return vec4f(unpack2x16float(words.x), unpack2x16float(words.y));
}

// Two vectors of three components in three words.
fn pack_half3x2(a: vec3f, b: vec3f) -> vec3u {
    return vec3u(pack2x16float(within_half2(a.xy)), pack2x16float(within_half2(vec2f(a.z, b.x))),
        pack2x16float(within_half2(b.yz)));
}

// The two vectors, one per column.
fn unpack_half3x2(words: vec3u) -> mat2x3f {
    let middle = unpack2x16float(words.y);
    return mat2x3f(vec3f(unpack2x16float(words.x), middle.x), vec3f(middle.y, unpack2x16float(words.z)));
}
