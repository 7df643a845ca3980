// Step 7: fragments to film samples. `exact` reads the fragments of a sample in order and marches
// the undercoat between them, so that both media attenuate each other at their true depths without
// virtual fragments; `blend_fragments` sorts and blends the fragments that undercoat_march stored:
// shell fragments with [Andersen2016] eq. 4, virtual fragments as they are.
// In: `fragment_lists`, `media_or_uv` (the volume), `node_light` (light at the lattice's nodes),
// `base_records`. Out: `samples` (shared/film_sample), premultiplied linear RGB; `march_counters`.

@group(0) @binding(1) var<uniform> fur: FurParameters;
@group(0) @binding(2) var<uniform> noise: Noise;
@group(0) @binding(3) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(4) var<storage, read> prisms: array<Prism>;
@group(0) @binding(5) var<storage, read> media_or_uv: array<u32>;
@group(0) @binding(6) var<storage, read> node_light: array<vec4u>;
@group(0) @binding(7) var<storage, read> base_records: array<vec4u>;
@group(0) @binding(8) var<storage, read> fragment_lists: array<u32>;
@group(0) @binding(9) var<storage, read_write> samples: array<vec4u>; // two per sample
// Number of lost rays; length of the longest list.
@group(0) @binding(10) var<storage, read_write> march_counters: array<atomic<u32>>;
@group(0) @binding(11) var<uniform> undercoat_fibre: Fibre;

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
#import shared/march
#import shared/phase
#import shared/oit
#import shared/oit_read
#import shared/base
#import shared/film_sample

// Sums of a sample, composited from front to back. Contributions are premultiplied.
struct Gathered {
    through: f32,       // transmittance so far
    guard: vec3f,
    undercoat: vec3f,
    base: vec3f,
    z_sum: f32,         // depth weighted by opacity
    fragments: u32,
}

// Composites the skin behind everything and writes the film sample.
fn finish(i: u32, xy: vec2u, g: ptr<function, Gathered>) {
    let base = base_records[i];
    let z_base = base_depth(base);
    var normal = 0u;
    if z_base < NO_BASE {
        (*g).base = (*g).through * base_radiance(base);
        let transparency = base_transparency(base);
        (*g).z_sum += (*g).through * (1.0 - transparency) * z_base;
        (*g).through *= transparency;
        normal = base.w;
    }
    let opacity = 1.0 - (*g).through;
    let z = select(NO_BASE, (*g).z_sum / max(opacity, 1e-6), opacity > 1e-4);
    let packed = pack_film_sample(
        FilmSample((*g).guard, (*g).undercoat, (*g).base, (*g).through, z, normal, (*g).fragments));
    samples[2u * i] = packed[0];
    samples[2u * i + 1u] = packed[1];
    if (*g).fragments > 0u {
        atomicMax(&march_counters[1], (*g).fragments);
    }
}

// Composites a fragment behind what has been gathered; returns the radiance that it adds.
// [PorterDuff1984]
fn put_behind(g: ptr<function, Gathered>, color: vec4f, z: f32) -> vec3f {
    let added = (*g).through * color.rgb;
    (*g).z_sum += (*g).through * color.a * z;
    (*g).through *= 1.0 - color.a;
    return added;
}

fn put_strand(g: ptr<function, Gathered>, color: vec4f, z: f32) {
    let added = put_behind(g, color, z);
    (*g).guard += added;
}

fn put_volume(g: ptr<function, Gathered>, color: vec4f, z: f32) {
    let added = put_behind(g, color, z);
    (*g).undercoat += added;
}

@compute @workgroup_size(64)
fn exact(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= tile_samples() {
        return;
    }
    let xy = tile_xy(i);
    var g: Gathered;
    g.through = 1.0;
    let z_base = base_depth(base_records[i]);
    var march: March;
    var place: Place;
    begin_ray(&march, sample_ray(xy));
    let phase = first_phase(xy);
    // An entry met during the march of another interval waits until that ends, so that overlapping
    // media are not counted twice.
    var waiting = NONE;
    var waiting_z = 0.0;
    var skip_to = 0.0;
    var z_after = -1.0;
    var source_after = 0u;
    var batch: Batch;
    var more = true;
    while more {
        read_batch(&batch, i, z_after, source_after);
        g.fragments = batch.length;
        more = batch.more;
        var next = 0u;
        // Each round takes at most one step of the march and all fragments up to its end.
        while g.through > fur.undercoat.opacity_cut && (next < batch.count || (march.marching && !more)) {
            // Fragments outside the undercoat.
            while !march.marching && next < batch.count {
                let key = batch.source[next];
                if fragment_kind(key) == KIND_ENTRY {
                    skip_to = 0.0;
                    enter_shell(&march, &place, fragment_id(key), batch.z[next], phase);
                } else {
                    put_strand(&g, node_color(batch.node[next]), batch.z[next]);
                }
                next++;
            }
            if !march.marching {
                break;
            }
            if march.z >= march.z_end {
                next_step(&march, &place);
                if !march.marching {
                    if waiting != NONE {
                        skip_to = max(skip_to, march.z);
                        enter_shell(&march, &place, waiting, waiting_z, phase);
                        waiting = NONE;
                    }
                    continue;
                }
            }
            // The step, split at the fragments within it. Fragments behind the batch are not known
            // yet, so the step is not marched beyond it.
            var inside = true;
            while inside {
                let has_node = next < batch.count;
                let z_node = select(select(z_base, march.z, more), batch.z[min(next, BATCH - 1u)], has_node);
                let z_to = clamp(z_node, march.z, march.z_end);
                let length = z_to - max(march.z, skip_to);
                if length > 0.0 {
                    let rest = exp(-march.sigma * length); // [Max1995]
                    put_volume(&g, vec4f(march.radiance * (1.0 - rest), 1.0 - rest), z_to - 0.5 * length);
                }
                march.z = z_to;
                inside = has_node && z_node <= march.z_end;
                if inside {
                    let key = batch.source[next];
                    if fragment_kind(key) == KIND_ENTRY {
                        waiting = fragment_id(key);
                        waiting_z = z_node;
                    } else {
                        put_strand(&g, node_color(batch.node[next]), z_node);
                    }
                    next++;
                }
            }
            if march.z >= z_base {
                march.marching = false;
            }
        }
        more = more && g.through > fur.undercoat.opacity_cut;
        if more {
            z_after = batch.z[BATCH - 1u];
            source_after = batch.source[BATCH - 1u];
        }
    }
    if march.lost > 0u {
        atomicAdd(&march_counters[0], 1u);
    }
    finish(i, xy, &g);
}

// Alpha of a shell fragment, reduced by the strands between it and the next shell fragment.
// [Andersen2016] eq. 4
// DEVIATION: each strand counts with its own alpha, and the result is clamped to be non-negative.
fn simplified_alpha(batch: ptr<function, Batch>, at: u32) -> f32 {
    let color = node_color((*batch).node[at]);
    let z_shell = (*batch).z[at];
    var alpha = color.a;
    for (var k = at + 1u; k < (*batch).count; k++) {
        let kind = fragment_kind((*batch).source[k]);
        if kind == KIND_VOLUME {
            return max(0.0, alpha);
        }
        if kind == KIND_STRAND {
            alpha -= node_color((*batch).node[k]).a * exp(-fur.undercoat.attenuation * ((*batch).z[k] - z_shell));
        }
    }
    return max(0.0, alpha);
}

@compute @workgroup_size(64)
fn blend_fragments(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= tile_samples() {
        return;
    }
    let xy = tile_xy(i);
    var g: Gathered;
    g.through = 1.0;
    var batch: Batch;
    var z_after = -1.0;
    var source_after = 0u;
    var more = true;
    while more && g.through > fur.undercoat.opacity_cut {
        read_batch(&batch, i, z_after, source_after);
        g.fragments = batch.length;
        more = batch.more;
        for (var k = 0u; k < batch.count; k++) {
            z_after = batch.z[k];
            source_after = batch.source[k];
            let kind = fragment_kind(source_after);
            if kind == KIND_STRAND {
                put_strand(&g, node_color(batch.node[k]), z_after);
            } else if kind == KIND_VOLUME {
                var color = node_color(batch.node[k]);
                if fur.undercoat.virtual_fragments == 0u {
                    // A shell fragment needs the strands behind it: unless it is the first of the
                    // batch or the list ends here, the list is read again from this fragment.
                    if k > 0u && batch.more {
                        read_batch(&batch, i, z_after, source_after - 1u);
                        more = batch.more;
                        k = 0u;
                    }
                    color *= simplified_alpha(&batch, k) / max(color.a, 1e-6);
                }
                put_volume(&g, color, z_after);
            }
        }
    }
    finish(i, xy, &g);
}
