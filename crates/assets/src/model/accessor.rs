//! Arrays of a glTF file (glTF 2.0, 3.6.2).

use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, Semantic};

use crate::model::Clause;

/// Elements of an accessor, checked against its buffer.
struct Elements<'b> {
    bytes: &'b [u8],
    count: usize,
    stride: usize,
    kind: DataType,
    normalized: bool,
}

fn elements<'b>(accessor: &Accessor<'_>, buffers: &'b [Vec<u8>], name: &str) -> Clause<Elements<'b>> {
    if accessor.sparse().is_some() {
        return Err(format!(
            "its {name} are stored sparsely, which is not read; export it without sparse accessors"
        ));
    }
    let Some(view) = accessor.view() else { return Err(format!("its {name} have no buffer view")) };
    let (count, size) = (accessor.count(), accessor.size());
    let stride = view.stride().unwrap_or(size);
    let cut_short = || format!("its {name} reach beyond their buffer; the file is damaged or cut short");
    let buffer = buffers.get(view.buffer().index()).ok_or_else(cut_short)?;
    let in_view = view.offset().checked_add(view.length()).and_then(|end| buffer.get(view.offset()..end));
    let bytes = in_view.and_then(|bytes| bytes.get(accessor.offset()..)).ok_or_else(cut_short)?;
    let needed = count.saturating_sub(1).checked_mul(stride).and_then(|bytes| bytes.checked_add(size));
    if count == 0 || stride == 0 || needed.is_none_or(|needed| needed > bytes.len()) {
        return Err(cut_short());
    }
    Ok(Elements { bytes, count, stride, kind: accessor.data_type(), normalized: accessor.normalized() })
}

impl Elements<'_> {
    /// Component of an element.
    fn component(&self, element: usize, component: usize) -> Option<f32> {
        let size = self.kind.size();
        let bytes = self.bytes.get(element * self.stride + component * size..)?;
        let most = |most: f32| if self.normalized { most } else { 1.0 };
        Some(match self.kind {
            DataType::F32 => f32::from_le_bytes(*bytes.first_chunk()?),
            DataType::U8 => f32::from(*bytes.first()?) / most(255.0),
            DataType::U16 => f32::from(u16::from_le_bytes(*bytes.first_chunk()?)) / most(65_535.0),
            DataType::I8 => (f32::from(*bytes.first()? as i8) / most(127.0)).max(if self.normalized {
                -1.0
            } else {
                -128.0
            }),
            DataType::I16 => {
                let value = f32::from(i16::from_le_bytes(*bytes.first_chunk()?));
                if self.normalized { (value / 32_767.0).max(-1.0) } else { value }
            }
            DataType::U32 => u32::from_le_bytes(*bytes.first_chunk()?) as f32,
        })
    }
}

/// Vectors of `N` numbers; of more components the first ones.
pub(super) fn vectors<const N: usize>(
    accessor: &Accessor<'_>,
    semantic: &Semantic,
    buffers: &[Vec<u8>],
    most: usize,
) -> Clause<Vec<[f32; N]>> {
    let name = semantic.to_string();
    if accessor.count() > most {
        return Err(format!(
            "its {name} are {}, more than the {most} that a model may have",
            accessor.count()
        ));
    }

    let fits = match accessor.dimensions() {
        Dimensions::Vec2 => N == 2,
        Dimensions::Vec3 => N == 3,
        Dimensions::Vec4 => N == 3 && matches!(semantic, Semantic::Colors(_)),
        _ => false,
    };
    if !fits {
        return Err(format!("its {name} are no vectors of {N} numbers"));
    }

    let elements = elements(accessor, buffers, &name)?;
    let vector = |element: usize| {
        let mut vector = [0.0; N];
        for (component, value) in vector.iter_mut().enumerate() {
            *value = elements.component(element, component)?;
        }
        Some(vector)
    };

    let all: Option<Vec<_>> = (0..elements.count).map(vector).collect();
    all.ok_or_else(|| format!("its {name} reach beyond their buffer"))
}

/// Whole numbers.
pub(super) fn indices(accessor: &Accessor<'_>, buffers: &[Vec<u8>], most: usize) -> Clause<Vec<u32>> {
    if accessor.count() > most {
        return Err(format!(
            "it has {} indices, more than the {most} that a model may have",
            accessor.count()
        ));
    }
    if accessor.dimensions() != Dimensions::Scalar {
        return Err("its indices are no single numbers".to_owned());
    }

    let elements = elements(accessor, buffers, "indices")?;
    let index = |element: usize| {
        let bytes = elements.bytes.get(element * elements.stride..)?;
        Some(match elements.kind {
            DataType::U8 => u32::from(*bytes.first()?),
            DataType::U16 => u32::from(u16::from_le_bytes(*bytes.first_chunk()?)),
            DataType::U32 => u32::from_le_bytes(*bytes.first_chunk()?),
            _ => return None,
        })
    };

    let all: Option<Vec<_>> = (0..elements.count).map(index).collect();
    all.ok_or_else(|| "its indices are no whole numbers".to_owned())
}
