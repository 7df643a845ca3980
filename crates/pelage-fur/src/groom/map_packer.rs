//! Parameters of the groom, and the texels of the maps that they refer to.

use crate::layout::Parameter;
use crate::parameters::SOURCE_BELOW;
use half::f16;
use pelage_core::maps::{MapSet, VERTEX_COLOR};
use pelage_core::scene::{Color, Scalar};

/// Bytes of a texel of the map buffer: four halves.
const TEXEL: u64 = 8;

/// Collects the texels of the maps that parameters refer to, each map once.
pub(super) struct MapPacker<'a> {
    maps: &'a MapSet,
    texels: Vec<[u32; 2]>,
    /// Packed images and their first texels.
    bases: Vec<(usize, u32)>,
    /// Whether the skin has uv.
    uv: bool,
}

impl<'a> MapPacker<'a> {
    /// A packer for the maps of a world; `uv` tells whether its skin has uv.
    pub fn new(maps: &'a MapSet, uv: bool) -> Self {
        Self { maps, texels: Vec::new(), bases: Vec::new(), uv }
    }

    /// Source, first texel and size of `layer` of the map called `name`, read as a colour or as a
    /// scalar.
    fn source(&mut self, name: &str, layer: &str, color: bool) -> (u32, u32, [u32; 2]) {
        if name == VERTEX_COLOR {
            return (1, 0, [1, 1]);
        }
        let Some(index) = self.maps.index_of(name, layer, color) else {
            return (0, 0, [1, 1]);
        };
        let image = &self.maps.images[index];
        let known = self.bases.iter().find(|(i, _)| *i == index).map(|(_, base)| *base);
        let base = known.unwrap_or_else(|| {
            let base = self.texels.len() as u32;
            // Texels beyond the range of half stay finite.
            let limit = f16::MAX.to_f32();
            let bits = |v: f32| u32::from(f16::from_f32(v.clamp(-limit, limit)).to_bits());
            let half = |a: f32, b: f32| bits(a) | (bits(b) << 16);
            self.texels.extend(image.texels.iter().map(|t| [half(t[0], t[1]), half(t[2], t[3])]));
            self.bases.push((index, base));
            base
        });
        (if self.uv { 2 } else { 3 }, base, [image.width, image.height])
    }

    /// Packs a scalar.
    pub fn scalar(&mut self, scalar: &Scalar) -> Parameter {
        match scalar {
            Scalar::Constant(v) => constant(*v),
            Scalar::Mapped(m) => parameter(
                [m.value; 4],
                self.source(&m.map, &m.layer, false),
                m.offset,
                m.channel.index() as u32,
            ),
        }
    }

    /// Packs a colour.
    pub fn color(&mut self, color: &Color) -> Parameter {
        match color {
            Color::Constant([r, g, b]) => parameter([*r, *g, *b, 1.0], (0, 0, [1, 1]), 0.0, 0),
            Color::Mapped(m) => {
                let [r, g, b] = m.value;
                parameter([r, g, b, 1.0], self.source(&m.map, &m.layer, true), 0.0, 0)
            }
        }
    }

    /// Packs a colour that is looked up on a surface other than the skin, with or without uv.
    pub fn color_on(&mut self, color: &Color, uv: bool) -> Parameter {
        let of_skin = std::mem::replace(&mut self.uv, uv);
        let packed = self.color(color);
        self.uv = of_skin;
        packed
    }

    /// The texels of all maps, at least one.
    pub fn finish(mut self) -> Vec<[u32; 2]> {
        if self.texels.is_empty() {
            self.texels.push([0; 2]);
        }
        debug_assert!((self.texels.len() as u64 * TEXEL) < u64::from(u32::MAX));
        self.texels
    }
}

/// A scalar that is the same everywhere.
pub(super) fn constant(value: f32) -> Parameter {
    parameter([value; 4], (0, 0, [1, 1]), 0.0, 0)
}

/// A parameter that a coat leaves as it is below.
pub(super) fn below() -> Parameter {
    parameter([0.0; 4], (SOURCE_BELOW, 0, [1, 1]), 0.0, 0)
}

fn parameter(
    value: [f32; 4],
    (source, texel_base, size): (u32, u32, [u32; 2]),
    offset: f32,
    channel: u32,
) -> Parameter {
    Parameter { value, source, texel_base, size, offset, channel, padding: [0; 2] }
}
