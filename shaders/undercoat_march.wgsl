// Step 5: the march that stores fragments of the undercoat, for the blending modes that need them:
// one shell fragment per entry, or virtual fragments. [Andersen2016] sec. 3.2 and 3.3. The exact
// mode marches in the resolve pass instead.
// In: entries in `fragment_lists`, `media_or_uv` (the volume), `node_light` (light at the lattice's
// nodes), `base_records`. Out: volume fragments in `fragment_lists`, premultiplied;
// `march_counters`.

@group(0) @binding(1) var<uniform> fur: FurParameters;
@group(0) @binding(2) var<uniform> noise: Noise;
@group(0) @binding(3) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(4) var<storage, read> prisms: array<Prism>;
@group(0) @binding(5) var<storage, read> media_or_uv: array<u32>;
@group(0) @binding(6) var<storage, read> node_light: array<vec4u>;
@group(0) @binding(7) var<storage, read> base_records: array<vec4u>;
@group(0) @binding(8) var<storage, read_write> fragment_lists: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> march_counters: array<atomic<u32>>;
@group(0) @binding(10) var<uniform> undercoat_fibre: Fibre;

#import shared/frame
#import shared/index
#import shared/random
#import shared/noise
#import shared/octahedral
#import shared/undercoat
#import shared/clumps
#import shared/shell
#import shared/uv_in_media
#import shared/volume
#import shared/lattice
#import shared/record
#import shared/source_table
#import shared/fibre
#import shared/undercoat_fibre
#import shared/march_counters
#import shared/march
#import shared/phase
#import shared/oit
#import shared/oit_write
#import shared/base
#import shared/rounds

// Unit vector along a sum of unit vectors; up where they cancel.
fn mean_direction(sum: vec3f) -> vec3f {
    let square = dot(sum, sum);
    return select(vec3f(0.0, 1.0, 0.0), sum * inverseSqrt(max(square, 1e-20)), square > 1e-12);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= tile_samples() {
        return;
    }
    let xy = tile_xy(i);
    let z_base = base_depth(base_records[i]);
    var march: March;
    var place: Place;
    begin_ray(&march, sample_ray(xy));
    let virtual_fragments = fur.undercoat.virtual_fragments;
    var z_after = 0.0;
    var source_after = 0u;
    var serial = 0u;
    // Entries in order of depth; overlapping intervals are shortened so that they count once.
    loop {
        // The next entry behind the last one.
        var z_entry = NO_BASE;
        var entry = 0u;
        var node = atomicLoad(&fragment_lists[head_word(i)]);
        while node != 0u {
            let at = node_word(node);
            let z = bitcast<f32>(atomicLoad(&fragment_lists[at + NODE_Z]));
            let key = atomicLoad(&fragment_lists[at + NODE_SOURCE]);
            if fragment_kind(key) == KIND_ENTRY && lies_before(z_after, source_after, z, key)
                && lies_before(z, key, z_entry, entry) {
                z_entry = z;
                entry = key;
            }
            node = atomicLoad(&fragment_lists[at]);
        }
        if z_entry == NO_BASE {
            break;
        }
        let consumed = march.z;
        enter_shell(&march, &place, fragment_id(entry), z_entry, first_phase(xy));
        var through = 1.0;      // transmittance of this entry
        var chunk = vec4f(0.0); // premultiplied
        var chunk_albedo = vec3f(0.0);
        var chunk_tangent = vec3f(0.0);
        var chunk_z = z_entry;
        var closed = 0u;        // virtual fragments that are full
        while march.marching && through > fur.undercoat.opacity_cut {
            next_step(&march, &place);
            if !march.marching {
                break;
            }
            let z0 = max(march.z, consumed);
            let z1 = min(march.z_end, z_base);
            march.z = march.z_end;
            if z1 <= z0 {
                if march.z >= z_base {
                    break;
                }
                continue;
            }
            // The step, split where a virtual fragment is full. Fragments have equal opacity, so
            // that none is wasted where little is visible. DEVIATION: [Andersen2016] sec. 3.3 joins
            // a fixed number of steps.
            var z = z0;
            let rest = exp(-march.sigma * (z1 - z0)); // [Max1995]
            let through_end = through * rest;
            while z < z1 {
                var z_next = z1;
                var through_next = through_end;
                if virtual_fragments > 0u {
                    let level = 1.0 - f32(closed + 1u) / f32(virtual_fragments);
                    if level >= through_end && level > 0.0 {
                        z_next = clamp(z + log(through / level) / max(march.sigma, 1e-9), z, z1);
                        through_next = level;
                    }
                }
                let part = 1.0 - through_next / through;
                let room = 1.0 - chunk.a;
                chunk += room * part * vec4f(march.radiance, 1.0);
                if FEATURES {
                    chunk_albedo += room * part * march.albedo;
                    chunk_tangent += room * part * march.tangent;
                }
                let through_half = 1.0 - (f32(closed) + 0.5) / f32(virtual_fragments);
                if chunk.a > 0.0 && virtual_fragments > 0u && through_next <= through_half && through > through_half {
                    // The fragment's depth is that at which half of its opacity is reached.
                    chunk_z = z + log(through / through_half) / max(march.sigma, 1e-9);
                }
                through = through_next;
                z = z_next;
                if virtual_fragments > 0u && z_next < z1 {
                    if chunk.a > 0.0 {
                        let node = add_fragment(i, chunk_z, fragment_source(KIND_VOLUME, serial), chunk);
                        if FEATURES {
                            add_features(node, chunk_albedo / chunk.a, mean_direction(chunk_tangent));
                        }
                        serial++;
                    }
                    chunk = vec4f(0.0);
                    chunk_albedo = vec3f(0.0);
                    chunk_tangent = vec3f(0.0);
                    chunk_z = z;
                    closed++;
                }
            }
            if march.z >= z_base {
                break;
            }
        }
        if chunk.a > 0.0 {
            let node = add_fragment(i, chunk_z, fragment_source(KIND_VOLUME, serial), chunk);
            if FEATURES {
                add_features(node, chunk_albedo / chunk.a, mean_direction(chunk_tangent));
            }
            serial++;
        }
        z_after = z_entry;
        source_after = entry;
        march.z = max(march.z, consumed);
    }
    if march.lost > 0u {
        atomicAdd(&march_counters[RAYS_LOST], 1u);
    }
    if rounds_ran_out() {
        atomicAdd(&march_counters[MARCHES_CUT], 1u);
    }
}
