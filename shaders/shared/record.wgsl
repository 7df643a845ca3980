// Albedos packed into words, ten bits per channel.

fn pack_albedo(c: vec3f) -> u32 {
    let q = vec3u(round(clamp(c, vec3f(0.0), vec3f(1.0)) * 1023.0));
    return q.x | (q.y << 10u) | (q.z << 20u);
}

fn unpack_albedo(word: u32) -> vec3f {
    return vec3f(f32(word & 1023u), f32((word >> 10u) & 1023u), f32((word >> 20u) & 1023u)) / 1023.0;
}
