// The undercoat at a place of the shell.
// Needs: cells (array<u32>), fur, uv_of_corner; shared/shell, shared/undercoat.

// Medium of the subelement at `layer` and cell `id` of the place's prism.
fn subelement_medium(place: ptr<function, Place>, layer: u32, id: u32) -> Medium {
    let l = subelement_centroid(id, (*place).subdivision);
    let t = (f32(layer) + 0.5) / f32(fur.layers);
    var p = (*place).p0 + l.y * (*place).e1 + l.z * (*place).e2;
    let normal = normalize((*place).v0 + l.y * (*place).w1 + l.z * (*place).w2);
    if fur.noise_domain == 1u {
        let corner = 3u * (*place).prism;
        p = vec3f(l.x * uv_of_corner(corner) + l.y * uv_of_corner(corner + 1u) + l.z * uv_of_corner(corner + 2u), 0.0);
    }
    var medium = evaluate_medium(p, normal, t, hash2((*place).prism, (layer << 16u) | id));
    medium.density *= crowding(place, t, medium.tangent);
    return medium;
}

// Whether the volume is stored or evaluated: fixed when the kernel is compiled, for an untaken branch is not free everywhere.
override STORED: bool = true;

fn medium_at(place: ptr<function, Place>) -> Medium {
    let layer = min(u32(clamp((*place).t, 0.0, 1.0) * f32(fur.layers)), fur.layers - 1u);
    let id = subelement((*place).lambda, (*place).subdivision);
    if STORED {
        return unpack_medium(cells[volume_index(place, layer, id)]);
    }
    // As it would be stored, so that the image does not depend on it.
    return unpack_medium(pack_medium(subelement_medium(place, layer, id)));
}
