//! Values of glTF's accessors. Every offset comes from the file and is checked.

use ::gltf::accessor::sparse::IndexType;
use ::gltf::accessor::{Accessor, DataType, Dimensions};
use ::gltf::buffer::View;

/// Reads accessors from the document's buffers.
pub(super) struct Accessors<'a> {
    pub buffers: &'a [Vec<u8>],
}

impl Accessors<'_> {
    /// Vectors of N numbers; normalised integers become fractions.
    pub fn vectors<const N: usize>(&self, accessor: &Accessor<'_>) -> Result<Vec<[f32; N]>, String> {
        let found = accessor.dimensions().multiplicity();
        if found != N || matches!(accessor.dimensions(), Dimensions::Mat2) {
            return Err(format!("found {:?}, expected vectors of {N}", accessor.dimensions()));
        }
        let values = self.numbers(accessor)?;
        Ok(values.as_chunks::<N>().0.iter().map(|v| v.map(|x| x as f32)).collect())
    }

    /// Colours with alpha, from vectors of three or four numbers.
    pub fn colors(&self, accessor: &Accessor<'_>) -> Result<Vec<[f32; 4]>, String> {
        match accessor.dimensions() {
            Dimensions::Vec3 => {
                let rgb = self.vectors::<3>(accessor)?;
                Ok(rgb.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
            }
            _ => self.vectors::<4>(accessor),
        }
    }

    /// Unsigned integers.
    pub fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u32>, String> {
        let integer = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if !integer || accessor.dimensions() != Dimensions::Scalar {
            let (kind, dimensions) = (accessor.data_type(), accessor.dimensions());
            return Err(format!("found {dimensions:?} of {kind:?}, expected unsigned integers"));
        }
        Ok(self.numbers(accessor)?.into_iter().map(|v| v as u32).collect())
    }

    /// All numbers of an accessor, one after the other. f64 holds every type exactly.
    fn numbers(&self, accessor: &Accessor<'_>) -> Result<Vec<f64>, String> {
        let (kind, per_item) = (accessor.data_type(), accessor.dimensions().multiplicity());
        let item = kind.size() * per_item;
        let count = accessor.count();
        let scale = if accessor.normalized() { 1.0 / largest(kind) } else { 1.0 };
        let number =
            |bytes: &[u8]| (value(kind, bytes) * scale).max(if scale == 1.0 { f64::MIN } else { -1.0 });
        let mut values = match accessor.view() {
            Some(view) => {
                let bytes = self.items(view, accessor.offset(), count, item)?;
                bytes.flat_map(|b| b.chunks_exact(kind.size())).map(number).collect()
            }
            // Zeros that a sparse accessor replaces; a count alone may claim anything.
            None if count > MAX_ZEROS => return Err(format!("found {count} items without a buffer view")),
            None => vec![0.0; count * per_item],
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, replaced) = (sparse.indices(), sparse.count());
            let size = indices.index_type().size();
            let at = self.items(indices.view(), indices.offset(), replaced, size)?;
            let new = self.items(sparse.values().view(), sparse.values().offset(), replaced, item)?;
            for (at, new) in at.zip(new) {
                let kind_of_index = match indices.index_type() {
                    IndexType::U8 => DataType::U8,
                    IndexType::U16 => DataType::U16,
                    IndexType::U32 => DataType::U32,
                };
                let start = value(kind_of_index, at) as usize * per_item;
                let Some(old) = values.get_mut(start..start + per_item) else {
                    return Err(format!(
                        "found the sparse index {}, expected less than {count}",
                        start / per_item
                    ));
                };
                old.iter_mut().zip(new.chunks_exact(kind.size())).for_each(|(old, new)| *old = number(new));
            }
        }
        Ok(values)
    }

    /// `count` items of `size` bytes in a view.
    fn items(
        &self,
        view: View<'_>,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<impl Iterator<Item = &[u8]>, String> {
        let stride = view.stride().unwrap_or(size);
        let bytes = (|| {
            let buffer = self.buffers.get(view.buffer().index())?;
            let within = buffer.get(view.offset()..view.offset().checked_add(view.length())?)?;
            let last = stride.checked_mul(count.checked_sub(1)?)?.checked_add(size)?;
            within.get(offset..offset.checked_add(last)?)
        })();
        match bytes {
            _ if count == 0 => Ok((&[] as &[u8]).chunks(1)),
            Some(bytes) if stride >= size => Ok(bytes.chunks(stride)),
            _ => Err(format!("found {count} items of {size} bytes, which do not fit into their buffer view")),
        }
        .map(move |items| items.map(move |item| &item[..size]))
    }
}

/// Largest number of items that an accessor without data may have.
const MAX_ZEROS: usize = 1 << 20;

fn largest(kind: DataType) -> f64 {
    match kind {
        DataType::I8 => f64::from(i8::MAX),
        DataType::U8 => f64::from(u8::MAX),
        DataType::I16 => f64::from(i16::MAX),
        DataType::U16 => f64::from(u16::MAX),
        DataType::U32 => f64::from(u32::MAX),
        DataType::F32 => 1.0,
    }
}

/// The number in the first bytes, little-endian.
fn value(kind: DataType, b: &[u8]) -> f64 {
    match kind {
        DataType::I8 => f64::from(b[0] as i8),
        DataType::U8 => f64::from(b[0]),
        DataType::I16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
        DataType::U16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
        DataType::U32 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        DataType::F32 => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
    }
}
