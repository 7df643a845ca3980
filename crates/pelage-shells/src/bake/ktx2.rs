//! Writes and reads the few kinds of KTX 2.0 files that baked textures need: all mip levels of one
//! plain image or of an array of layers; 8-bit RGBA, BC3 or BC7; colour premultiplied in linear
//! light and then encoded as sRGB, coverage linear. There is no supercompression, so that a client
//! uploads the bytes as they are.
// [KTX2] sec. 3 (file structure), 3.10 (data format descriptor), 5 (keys)

use super::mips;

const IDENTIFIER: [u8; 12] = [0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, b'\r', b'\n', 0x1a, b'\n'];

/// Bytes of identifier, header and index, which precede the level index.
const HEADER: usize = 80;

/// Bytes of an entry of the level index.
const ENTRY: usize = 24;

/// How texels are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// VK_FORMAT_R8G8B8A8_SRGB.
    Rgba8,
    /// VK_FORMAT_BC3_SRGB_BLOCK, formerly DXT5.
    Bc3,
    /// VK_FORMAT_BC7_SRGB_BLOCK.
    Bc7,
}

impl Encoding {
    const ALL: [Self; 3] = [Self::Rgba8, Self::Bc3, Self::Bc7];

    /// The value of the format in Vulkan.
    pub fn vk_format(self) -> u32 {
        match self {
            Self::Rgba8 => 43,
            Self::Bc3 => 138,
            Self::Bc7 => 146,
        }
    }

    /// Texels along the edge of a block.
    pub fn block(self) -> u32 {
        if self == Self::Rgba8 { 1 } else { 4 }
    }

    /// Bytes of a block.
    pub fn block_bytes(self) -> u32 {
        if self == Self::Rgba8 { 4 } else { 16 }
    }

    /// Bytes of one layer of `size` texels.
    pub fn layer_bytes(self, size: [u32; 2]) -> u64 {
        let [w, h] = size.map(|n| u64::from(n.div_ceil(self.block())));
        w * h * u64::from(self.block_bytes())
    }

    /// Colour model, and for each sample
    /// `[bit offset, bits, channel with qualifiers, largest value]`.
    fn samples(self) -> (u8, Vec<[u32; 4]>) {
        // Coverage is linear although colours are not.
        const ALPHA_LINEAR: u32 = 15 | 0x10;
        match self {
            Self::Rgba8 => {
                let channels = [0, 1, 2, ALPHA_LINEAR].into_iter().zip(0..);
                (1, channels.map(|(channel, i)| [8 * i, 8, channel, 255]).collect())
            }
            Self::Bc3 => (130, vec![[0, 64, ALPHA_LINEAR, u32::MAX], [64, 64, 0, u32::MAX]]),
            Self::Bc7 => (134, vec![[0, 128, 0, u32::MAX]]),
        }
    }
}

/// The contents of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ktx2 {
    /// How texels are stored.
    pub encoding: Encoding,
    /// Texels of the finest level.
    pub size: [u32; 2],
    /// Layers of an array; `None` for a plain two-dimensional image.
    pub layers: Option<u32>,
    /// The bytes of each mip level, finest first: layer by layer, row of blocks by row of blocks, v
    /// = 0 first.
    pub levels: Vec<Vec<u8>>,
}

impl Ktx2 {
    /// Size of mip level `level` in bytes.
    pub fn level_bytes(&self, level: u32) -> u64 {
        self.encoding.layer_bytes(mips::size(self.size, level)) * u64::from(self.layers.unwrap_or(1))
    }

    /// Encodes the file.
    ///
    /// # Errors
    /// A description of the inconsistency: an empty image, more levels than the size allows, or a
    /// level whose length is not [`Ktx2::level_bytes`].
    pub fn encode(&self) -> Result<Vec<u8>, String> {
        self.check()?;
        let levels = self.levels.len();
        let descriptor = self.descriptor();
        let keys = keys();
        let descriptor_at = HEADER + ENTRY * levels;
        let keys_at = descriptor_at + descriptor.len();
        let mut file = IDENTIFIER.to_vec();
        let header = [
            self.encoding.vk_format(),
            1, // typeSize: bytes need no swapping.
            self.size[0],
            self.size[1],
            0, // No depth.
            self.layers.unwrap_or(0),
            1, // Faces.
            levels as u32,
            0, // No supercompression.
            descriptor_at as u32,
            descriptor.len() as u32,
            keys_at as u32,
            keys.len() as u32,
        ];
        file.extend(header.iter().flat_map(|word| word.to_le_bytes()));
        file.extend([0; 16]); // No supercompression global data.
        // Levels are stored coarsest first, each aligned to the size of a block.
        let align = self.encoding.block_bytes() as usize;
        let mut at = keys_at + keys.len();
        let mut places = Vec::with_capacity(levels);
        for level in self.levels.iter().rev() {
            at = at.next_multiple_of(align);
            places.push(at);
            at += level.len();
        }
        for (place, level) in places.iter().rev().zip(&self.levels) {
            let entry = [*place as u64, level.len() as u64, level.len() as u64];
            file.extend(entry.iter().flat_map(|word| word.to_le_bytes()));
        }
        file.extend(descriptor);
        file.extend(keys);
        for level in self.levels.iter().rev() {
            file.resize(file.len().next_multiple_of(align), 0);
            file.extend(level);
        }
        Ok(file)
    }

    /// Decodes a file that [`Ktx2::encode`] wrote, or another writer's file of the same kind.
    ///
    /// # Errors
    /// A message with what was found and what was expected.
    pub fn decode(file: &[u8]) -> Result<Self, String> {
        if file.get(..12) != Some(&IDENTIFIER) {
            return Err("found no KTX 2.0 identifier at the start".into());
        }
        let word = |at: usize| -> Result<u32, String> {
            let bytes = file.get(at..at + 4).and_then(|b| b.try_into().ok());
            bytes
                .map(u32::from_le_bytes)
                .ok_or_else(|| format!("truncated: it ends at byte {}, within its header", file.len()))
        };
        let format = word(12)?;
        let encoding = Encoding::ALL.into_iter().find(|e| e.vk_format() == format).ok_or_else(|| {
            format!("vkFormat is {format}, expected 43 (RGBA8 sRGB), 138 (BC3 sRGB) or 146 (BC7 sRGB)")
        })?;
        for (name, at, expected) in
            [("pixelDepth", 28, 0), ("faceCount", 36, 1), ("supercompressionScheme", 44, 0)]
        {
            let found = word(at)?;
            if found != expected {
                return Err(format!("{name} is {found}, expected {expected}"));
            }
        }
        let (size, layers, count) = ([word(20)?, word(24)?], word(32)?, word(40)?);
        let mut ktx = Self { encoding, size, layers: (layers > 0).then_some(layers), levels: Vec::new() };
        if count == 0 || count > mips::levels(size) {
            return Err(format!("levelCount is {count}, expected 1 to {}", mips::levels(size)));
        }
        let long = |at: usize| Ok::<u64, String>(u64::from(word(at)?) | u64::from(word(at + 4)?) << 32);
        for level in 0..count {
            let entry = HEADER + ENTRY * level as usize;
            let (at, bytes, expected) = (long(entry)?, long(entry + 8)?, ktx.level_bytes(level));
            if bytes != expected {
                return Err(format!("level {level} has {bytes} bytes, expected {expected}"));
            }
            let end = at.checked_add(bytes);
            let range = usize::try_from(at).ok().zip(end.and_then(|end| usize::try_from(end).ok()));
            let data = range.and_then(|(at, end)| file.get(at..end)).ok_or_else(|| {
                format!(
                    "level {level} ends at byte {}, but the file at byte {}",
                    at.saturating_add(bytes),
                    file.len()
                )
            })?;
            ktx.levels.push(data.to_vec());
        }
        ktx.check()?;
        let (at, expected) = (word(48)? as usize, ktx.descriptor());
        if file.get(at..at.saturating_add(expected.len())) != Some(&expected) {
            return Err(
                "the data format descriptor does not describe premultiplied sRGB in this format".into()
            );
        }
        Ok(ktx)
    }

    fn check(&self) -> Result<(), String> {
        let ([w, h], levels) = (self.size, self.levels.len());
        if w == 0 || h == 0 || self.layers == Some(0) {
            return Err(format!(
                "{w} x {h} texels in {:?} layers, expected at least one of each",
                self.layers
            ));
        }
        if levels == 0 || levels > mips::levels(self.size) as usize {
            return Err(format!(
                "{levels} levels of {w} x {h} texels, expected 1 to {}",
                mips::levels(self.size)
            ));
        }
        for (level, data) in (0..).zip(&self.levels) {
            let expected = self.level_bytes(level);
            if data.len() as u64 != expected {
                return Err(format!("level {level} has {} bytes, expected {expected}", data.len()));
            }
        }
        Ok(())
    }

    /// The basic data format descriptor, preceded by its length.
    fn descriptor(&self) -> Vec<u8> {
        let (model, samples) = self.encoding.samples();
        let block = 24 + 16 * samples.len() as u32;
        let edge = (self.encoding.block() - 1) as u8;
        let word = |bytes: [u8; 4]| u32::from_le_bytes(bytes);
        let mut words = vec![
            4 + block,
            0,                      // Khronos, basic.
            2 | block << 16,        // Version 1.3 of the data format.
            word([model, 1, 2, 1]), // BT.709 primaries, sRGB transfer, premultiplied.
            word([edge, edge, 0, 0]),
            self.encoding.block_bytes(),
            0,
        ];
        for [offset, bits, channel, upper] in samples {
            words.extend([offset | (bits - 1) << 16 | channel << 24, 0, 0, upper]);
        }
        words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }
}

/// The key/value data: sorted keys, each entry preceded by its length and padded to 4 bytes.
fn keys() -> Vec<u8> {
    let mut data = Vec::new();
    let writer = concat!("pelage ", env!("CARGO_PKG_VERSION"));
    // "rd": the first row of texels has v = 0, and v grows downwards when the texture is viewed as
    // an image.
    for (key, value) in [("KTXorientation", "rd"), ("KTXwriter", writer)] {
        let entry = format!("{key}\0{value}\0");
        data.extend((entry.len() as u32).to_le_bytes());
        data.extend(entry.as_bytes());
        data.resize(data.len().next_multiple_of(4), 0);
    }
    data
}
