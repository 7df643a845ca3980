//! Twin of `shaders/undercoat_density.wgsl`: the stored volume.

use pelage_fur::undercoat::{Medium, Undercoat};

/// Media of all subelements, in the order of the volume data: prism by prism, layer by layer.
pub fn media(coat: &Undercoat<'_>) -> Vec<Medium> {
    let mut media = Vec::new();
    for prism in 0..coat.shell.prisms.len() as u32 {
        let place = coat.shell.enter(prism);
        for layer in 0..coat.parameters.layers {
            media.extend((0..1u32 << (2 * place.subdivision)).map(|id| coat.subelement(&place, layer, id)));
        }
    }
    media
}
