// The camera and the tile being rendered. Spaces: world (cm); film, the sample grid of the whole
// film (samples, y down); tile (samples from the tile's corner).

struct Frame {
    eye: vec3f,          // world, on the lens
    near: f32,           // cm
    right: vec3f,
    tan_x: f32,          // tangent of half the horizontal field of view
    up: vec3f,
    tan_y: f32,
    forward: vec3f,
    seed: u32,
    film_size: vec2f,    // samples
    jitter: vec2f,       // displacement of the sample grid, samples
    lens_shear: vec2f,   // lens position / focus distance
    tile_origin: vec2i,  // samples
    tile_size: vec2u,    // samples
    flags: u32,
    node_capacity: u32,  // fragments that the list buffer holds
}

@group(0) @binding(0) var<uniform> frame: Frame;

const FLAG_MARCH_JITTER: u32 = 1u;
const FLAG_SORTED_LISTS: u32 = 2u;   // the lists of fragments are linked in order of depth

// Number of samples of the tile.
fn tile_samples() -> u32 {
    return frame.tile_size.x * frame.tile_size.y;
}

// Position of sample number i in the tile.
fn tile_xy(i: u32) -> vec2u {
    return vec2u(i % frame.tile_size.x, i / frame.tile_size.x);
}

// Number of a sample of the tile.
fn tile_index(xy: vec2u) -> u32 {
    return xy.y * frame.tile_size.x + xy.x;
}

// Unit vector from a point towards the camera (the point on the lens).
fn to_eye(x: vec3f) -> vec3f {
    return normalize(frame.eye - x);
}

// Ray through the centre of a sample. Its forward component is 1, so that the ray parameter is the
// depth z (cm).
fn sample_ray(xy: vec2u) -> vec3f {
    let s = vec2f(frame.tile_origin + vec2i(xy)) + 0.5 + frame.jitter;
    let ndc = vec2f(2.0, -2.0) * s / frame.film_size + vec2f(-1.0, 1.0);
    let slope = ndc * vec2f(frame.tan_x, frame.tan_y) - frame.lens_shear;
    return frame.forward + slope.x * frame.right + slope.y * frame.up;
}

// World to film space: xy in samples (sample centres at half integers), z depth in cm. Independent
// of the tile.
fn film_from_world(p: vec3f) -> vec3f {
    let v = p - frame.eye;
    let z = dot(v, frame.forward);
    let slope = vec2f(dot(v, frame.right), dot(v, frame.up)) / z + frame.lens_shear;
    let ndc = slope / vec2f(frame.tan_x, frame.tan_y);
    return vec3f((ndc * vec2f(0.5, -0.5) + 0.5) * frame.film_size - frame.jitter, z);
}

// Samples around the tile that the viewport also covers: the new edges of a clipped triangle are
// rounded to the rasteriser's grid, and a sample on such an edge would depend on the tile. Must
// equal `RASTER_MARGIN` of pelage-gpu.
const RASTER_MARGIN: f32 = 1024.0;

// World to clip space of the tile, reversed depth: 1 at the near plane, 0 at infinity. Positions
// are rounded to the rasteriser's grid of 1/256 sample in film space, so that a triangle covers the
// same samples in whatever tile it is drawn.
fn clip_from_world(p: vec3f) -> vec4f {
    let v = p - frame.eye;
    let z = dot(v, frame.forward);
    let corner = vec2f(frame.tile_origin) - RASTER_MARGIN;
    let size = vec2f(frame.tile_size) + 2.0 * RASTER_MARGIN;
    if z < frame.near {
        let slope_z = vec2f(dot(v, frame.right), dot(v, frame.up)) + frame.lens_shear * z;
        let s_z = (slope_z / vec2f(frame.tan_x, frame.tan_y) * vec2f(0.5, -0.5) + 0.5 * z) * frame.film_size;
        let tile_z = s_z - (corner + frame.jitter) * z;
        return vec4f((2.0 * tile_z / size - z) * vec2f(1.0, -1.0), frame.near, z);
    }
    let s = round(film_from_world(p).xy * 256.0) / 256.0 - corner;
    let ndc = (2.0 * s / size - 1.0) * vec2f(1.0, -1.0);
    return vec4f(ndc * z, frame.near, z);
}

// Samples per cm at a depth of 1 cm.
fn samples_per_slope() -> f32 {
    return 0.5 * frame.film_size.y / frame.tan_y;
}
