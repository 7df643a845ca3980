// Step 7: fragments to film samples. `exact` reads the fragments of a sample in order and marches
// the undercoat between them, so that both media attenuate each other at their true depths without
// virtual fragments; `blend_fragments` sorts and blends the fragments that undercoat_march stored:
// shell fragments with [Andersen2016] eq. 4, virtual fragments as they are.
// In: `fragment_lists`, `media_or_uv` (the volume), `node_light` (light at the lattice's nodes),
// `base_records`; with FEATURES, its albedo and object in `samples`.
// Out: `samples` (shared/film_sample), premultiplied linear RGB; `march_counters`.

@group(0) @binding(1) var<uniform> fur: FurParameters;
@group(0) @binding(2) var<uniform> noise: Noise;
@group(0) @binding(3) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(4) var<storage, read> prisms: array<Prism>;
@group(0) @binding(5) var<storage, read> media_or_uv: array<u32>;
@group(0) @binding(6) var<storage, read> node_light: array<vec4u>;
@group(0) @binding(7) var<storage, read> base_records: array<vec4u>;
@group(0) @binding(8) var<storage, read> fragment_lists: array<u32>;
@group(0) @binding(9) var<storage, read_write> samples: array<vec4u>; // shared/film_sample
@group(0) @binding(10) var<storage, read_write> march_counters: array<atomic<u32>>;
@group(0) @binding(11) var<uniform> undercoat_fibre: Fibre;
@group(0) @binding(12) var<uniform> sort_run: SortRun;
@group(0) @binding(13) var<storage, read_write> lists_to_sort: array<u32>; // the same lists

// Lists are sorted from runs of this length to runs of twice the length.
struct SortRun {
    length: u32,
}

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
#import shared/oit_read
#import shared/base
#import shared/film_sample
#import shared/rounds

// Sums of a sample, composited from front to back. Contributions are premultiplied.
struct Gathered {
    through: f32,       // transmittance so far
    guard: vec3f,
    undercoat: vec3f,
    base: vec3f,
    z_sum: f32,         // depth weighted by opacity
    fragments: u32,     // in the list
    read: u32,          // composited; those behind what is opaque are not
    // With FEATURES, weighted by opacity:
    guard_coverage: f32,
    undercoat_coverage: f32,
    albedo: vec3f,
    normal: vec3f,
    tangent: vec3f,
}

// Composites the skin or an object behind everything and writes the film sample.
fn finish(i: u32, xy: vec2u, g: ptr<function, Gathered>) {
    let base = base_records[i];
    let z_base = base_depth(base);
    var normal = 0u;
    var base_coverage = 0.0;
    var object = 0u;
    if z_base < NO_BASE {
        let transparency = base_transparency(base);
        if FEATURES {
            base_coverage = (*g).through * (1.0 - transparency);
            object = samples[sample_vector(i) + 2u].y;
            (*g).albedo += base_coverage * unpack_albedo(samples[sample_vector(i) + 2u].x);
            (*g).normal += base_coverage * unpack_direction(base.w);
        }
        (*g).base = (*g).through * base_radiance(base);
        (*g).z_sum += (*g).through * (1.0 - transparency) * z_base;
        (*g).through *= transparency;
        normal = base.w;
    }
    let opacity = 1.0 - (*g).through;
    let z = select(NO_BASE, (*g).z_sum / max(opacity, 1e-6), opacity > 1e-4);
    let packed = pack_film_sample(
        FilmSample((*g).guard, (*g).undercoat, (*g).base, (*g).through, z, normal, (*g).fragments));
    let at = sample_vector(i);
    samples[at] = packed[0];
    samples[at + 1u] = packed[1];
    if FEATURES {
        // Coverages add up to alpha as the sample holds it: one minus a half float.
        let stored = 1.0 - unpack2x16float(pack2x16float(vec2f((*g).through, 0.0))).x;
        let coverage = vec3f((*g).guard_coverage, (*g).undercoat_coverage, base_coverage);
        let more = pack_feature_sample(FeatureSample((*g).albedo, (*g).normal, (*g).tangent,
            coverage * (stored / max(coverage.x + coverage.y + coverage.z, 1e-12)), object));
        samples[at + 2u] = more[0];
        samples[at + 3u] = more[1];
    }
    if (*g).fragments > 0u {
        atomicMax(&march_counters[LONGEST_LIST], (*g).fragments);
        atomicAdd(&march_counters[FRAGMENTS_LISTED], (*g).fragments);
    }
}

// Counts what is missing in a sample that was not resolved to its end. `unfinished`: whether
// something visible is left.
fn count_unread(g: ptr<function, Gathered>, unfinished: bool) {
    if unfinished && rounds_ran_out() {
        atomicAdd(&march_counters[RAYS_CUT], 1u);
        atomicAdd(&march_counters[FRAGMENTS_UNREAD], (*g).fragments - min((*g).read, (*g).fragments));
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

// Adds the features of hairs of opacity `alpha` behind what has been gathered; before `put_behind`.
fn put_features(g: ptr<function, Gathered>, alpha: f32, albedo: vec3f, tangent: vec3f, view: vec3f) {
    let weight = (*g).through * alpha;
    (*g).albedo += weight * albedo;
    (*g).normal += weight * hair_normal(tangent, view);
    (*g).tangent += weight * tangent;
}

fn put_strand(g: ptr<function, Gathered>, node: u32, z: f32, view: vec3f) {
    let color = node_color(node);
    if FEATURES {
        (*g).guard_coverage += (*g).through * color.a;
        put_features(g, color.a, node_albedo(node), node_tangent(node), view);
    }
    let added = put_behind(g, color, z);
    (*g).guard += added;
}

fn put_volume(g: ptr<function, Gathered>, color: vec4f, z: f32) {
    if FEATURES {
        (*g).undercoat_coverage += (*g).through * color.a;
    }
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
    var first = 0u;
    var more = true;
    while more {
        read_batch(&batch, i, z_after, source_after, first);
        g.fragments = max(g.fragments, batch.length);
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
                    put_strand(&g, batch.node[next], batch.z[next], march.view);
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
                    if FEATURES {
                        put_features(&g, 1.0 - rest, march.albedo, march.tangent, march.view);
                    }
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
                        put_strand(&g, batch.node[next], z_node, march.view);
                    }
                    next++;
                }
            }
            if march.z >= z_base {
                march.marching = false;
            }
        }
        g.read += next;
        more = more && g.through > fur.undercoat.opacity_cut;
        if more {
            z_after = batch.z[BATCH - 1u];
            source_after = batch.source[BATCH - 1u];
            first = read_from(batch.node[BATCH - 1u]);
        }
    }
    if march.lost > 0u {
        atomicAdd(&march_counters[RAYS_LOST], 1u);
    }
    count_unread(&g, g.through > fur.undercoat.opacity_cut && (g.read < g.fragments || march.marching));
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
    var view = vec3f(0.0);
    if FEATURES {
        view = -normalize(sample_ray(xy));
    }
    var g: Gathered;
    g.through = 1.0;
    var batch: Batch;
    var z_after = -1.0;
    var source_after = 0u;
    var first = 0u;
    var more = true;
    while more && g.through > fur.undercoat.opacity_cut {
        read_batch(&batch, i, z_after, source_after, first);
        g.fragments = max(g.fragments, batch.length);
        more = batch.more;
        for (var k = 0u; k < batch.count; k++) {
            z_after = batch.z[k];
            source_after = batch.source[k];
            first = read_from(batch.node[k]);
            g.read++;
            let kind = fragment_kind(source_after);
            if kind == KIND_STRAND {
                put_strand(&g, batch.node[k], z_after, view);
            } else if kind == KIND_VOLUME {
                var color = node_color(batch.node[k]);
                if fur.undercoat.virtual_fragments == 0u {
                    // A shell fragment needs the strands behind it: unless it is the first of the
                    // batch or the list ends here, the list is read again from this fragment.
                    if k > 0u && batch.more {
                        read_batch(&batch, i, z_after, source_after - 1u, first);
                        more = batch.more;
                        k = 0u;
                    }
                    color *= simplified_alpha(&batch, k) / max(color.a, 1e-6);
                }
                if FEATURES {
                    put_features(&g, color.a, node_albedo(batch.node[k]), node_tangent(batch.node[k]), view);
                }
                put_volume(&g, color, z_after);
            }
        }
    }
    count_unread(&g, g.through > fur.undercoat.opacity_cut && g.read < g.fragments);
    finish(i, xy, &g);
}

// Merges neighbouring runs of each list, which are in order of depth. As many dispatches as the
// longest list has binary digits sort all lists. They are only needed where lists are so long that
// the adapter ends the loops which read them in batches.
@compute @workgroup_size(64)
fn merge_runs(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= tile_samples() {
        return;
    }
    var left = lists_to_sort[head_word(i)];
    var tail = head_word(i); // the word that links to the next node
    while left != 0u {
        var right = left;
        var left_count = 0u;
        while left_count < sort_run.length && right != 0u {
            right = lists_to_sort[node_word(right)];
            left_count++;
        }
        var right_count = sort_run.length;
        while left_count > 0u || (right_count > 0u && right != 0u) {
            var take_right = left_count == 0u;
            if left_count > 0u && right_count > 0u && right != 0u {
                let a = node_word(left);
                let b = node_word(right);
                take_right = lies_before(bitcast<f32>(lists_to_sort[b + NODE_Z]), lists_to_sort[b + NODE_SOURCE],
                    bitcast<f32>(lists_to_sort[a + NODE_Z]), lists_to_sort[a + NODE_SOURCE]);
            }
            let node = select(left, right, take_right);
            let next = lists_to_sort[node_word(node)];
            if take_right {
                right = next;
                right_count--;
            } else {
                left = next;
                left_count--;
            }
            lists_to_sort[tail] = node;
            tail = node_word(node);
        }
        left = right;
    }
    lists_to_sort[tail] = 0u;
}
