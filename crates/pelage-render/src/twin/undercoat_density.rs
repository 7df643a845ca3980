//! Twin of `shaders/undercoat_density.wgsl`: the media of all subelements.
// [Andersen2016] sec. 3.2

use pelage_fur::undercoat::{Medium, Undercoat};

/// Media of all subelements in the order of the buffer: prism by prism, layer by layer.
pub fn media(undercoat: &Undercoat<'_>) -> Vec<Medium> {
    let mut media = Vec::new();
    for prism in 0..undercoat.shell.prisms.len() as u32 {
        let place = undercoat.shell.enter(prism);
        for layer in 0..undercoat.parameters.layers {
            media.extend(
                (0..1u32 << (2 * place.subdivision)).map(|id| undercoat.subelement(&place, layer, id)),
            );
        }
    }
    media
}
