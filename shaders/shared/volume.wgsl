// The undercoat's medium at a place of the prism shell.
// Needs: media_or_uv (array<u32>), fur, uv_of_corner; shared/shell, shared/undercoat,
// shared/clumps.

#import shared/noise_domain

// Medium of subelement `id` in `layer` of the place's prism.
fn subelement_medium(place: ptr<function, Place>, layer: u32, id: u32) -> Medium {
    let l = subelement_centroid(id, (*place).subdivision);
    let t = (f32(layer) + 0.5) / f32(fur.undercoat.layers);
    let normal = extrusion_direction(place, l);
    var medium = evaluate_medium(noise_point(place, l), normal, t, hash2((*place).prism, (layer << 16u) | id));
    medium.density *= crowding(place, t, medium.tangent);
    return medium;
}

// Whether the volume is stored or evaluated; fixed when the kernel is compiled, because a branch
// that is not taken is not free on all adapters.
override STORED: bool = true;

// Medium of the subelement that contains a place.
fn medium_at(place: ptr<function, Place>) -> Medium {
    let layer = min(u32(clamp((*place).t, 0.0, 1.0) * f32(fur.undercoat.layers)), fur.undercoat.layers - 1u);
    let id = subelement((*place).lambda, (*place).subdivision);
    if STORED {
        return unpack_medium(media_or_uv[volume_index(place, layer, id)]);
    }
    // Rounded as when stored, so that the image does not depend on the choice.
    return unpack_medium(pack_medium(subelement_medium(place, layer, id)));
}
