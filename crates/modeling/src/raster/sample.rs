//! Sample types: sizes, names, widening to `f64`.

use crate::raster::SampleType;

impl SampleType {
    /// Size of one sample, bytes.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Name for people, e.g. `int16`.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8",
            Self::I8 => "int8",
            Self::U16 => "uint16",
            Self::I16 => "int16",
            Self::U32 => "uint32",
            Self::I32 => "int32",
            Self::F32 => "float32",
            Self::F64 => "float64",
        }
    }

    /// The value as a sample of this type holds it; integers leave it alone, since a value that they cannot hold
    /// matches no sample anyway.
    pub fn round(self, value: f64) -> f64 {
        match self {
            Self::F32 => f64::from(value as f32),
            _ => value,
        }
    }
}

/// Every `step`-th sample from `first` on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stride {
    pub first: usize,
    pub step: usize,
}

/// Widens samples in native byte order: `to[to.first + i·to.step] = from[from.first + i·from.step]` for as many
/// `i` below `count` as both sides hold.
fn widen(sample: SampleType, bytes: &[u8], from: Stride, count: usize, to: Stride, out: &mut [f64]) {
    let out = out.get_mut(to.first..).unwrap_or_default();
    macro_rules! widen_as {
        ($type:ty) => {{
            const SIZE: usize = size_of::<$type>();

            let source = bytes.get(from.first * SIZE..).unwrap_or_default();
            if from.step <= 1 && to.step <= 1 {
                // Without strides, many are widened at once.
                for (target, value) in out.iter_mut().take(count).zip(source.as_chunks::<SIZE>().0) {
                    *target = f64::from(<$type>::from_ne_bytes(*value));
                }
                return;
            }

            let targets = out.iter_mut().step_by(to.step.max(1)).take(count);
            for (target, chunk) in targets.zip(source.chunks(SIZE * from.step.max(1))) {
                if let Some((value, _)) = chunk.split_first_chunk::<SIZE>() {
                    *target = f64::from(<$type>::from_ne_bytes(*value));
                }
            }
        }};
    }

    match sample {
        SampleType::U8 => widen_as!(u8),
        SampleType::I8 => widen_as!(i8),
        SampleType::U16 => widen_as!(u16),
        SampleType::I16 => widen_as!(i16),
        SampleType::U32 => widen_as!(u32),
        SampleType::I32 => widen_as!(i32),
        SampleType::F32 => widen_as!(f32),
        SampleType::F64 => widen_as!(f64),
    }
}

/// Pixels whose samples lie side by side, as they are stored.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pixels<'a> {
    pub sample: SampleType,
    /// Samples in native byte order.
    pub bytes: &'a [u8],
    /// The first pixel that is meant, and how many are.
    pub first: usize,
    pub count: usize,
    /// Samples per pixel.
    pub samples: usize,
}

impl Pixels<'_> {
    /// Widens samples `bands` of each pixel to neighbours in `out`, the first pixel's to `to.first`.
    pub fn widen(self, bands: &[u32], to: Stride, out: &mut [f64]) {
        let Self { sample, bytes, first, count, samples } = self;
        let first = first * samples;
        if to.step == samples && bands.iter().copied().eq(0..samples as u32) {
            // All of them, in their order.
            let (from, to) = (Stride { first, step: 1 }, Stride { step: 1, ..to });
            return widen(sample, bytes, from, count * samples, to, out);
        }
        for (position, band) in bands.iter().enumerate() {
            let from = Stride { first: first + *band as usize, step: samples };
            widen(sample, bytes, from, count, Stride { first: to.first + position, ..to }, out);
        }
    }
}

/// Byte order of stored samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

impl ByteOrder {
    /// Brings samples of `size` bytes into native order.
    pub fn make_native(self, bytes: &mut [u8], size: usize) {
        let native = if cfg!(target_endian = "big") { Self::Big } else { Self::Little };
        if self != native && size > 1 {
            bytes.chunks_exact_mut(size).for_each(<[u8]>::reverse);
        }
    }

    /// Reads an unsigned integer of up to 8 bytes.
    pub fn unsigned(self, bytes: &[u8]) -> u64 {
        let fold = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        match self {
            Self::Little => bytes.iter().rev().fold(0, fold),
            Self::Big => bytes.iter().fold(0, fold),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widen_takes_one_band_of_an_interleaved_row() {
        let row: Vec<u8> = [1i16, -2, 3, -4, 5, -6].iter().flat_map(|v| v.to_ne_bytes()).collect();
        let mut out = [0.0; 3];
        let second = Stride { first: 1, step: 2 };
        widen(SampleType::I16, &row, second, 3, Stride { first: 0, step: 1 }, &mut out);
        assert_eq!(out, [-2.0, -4.0, -6.0]);
    }

    #[test]
    fn pixels_widen_any_bands_in_any_order() {
        let values: Vec<u16> = (0..12).map(|value| value * 1000).collect();
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_ne_bytes()).collect();
        let pixels = Pixels { sample: SampleType::U16, bytes: &bytes, first: 1, count: 2, samples: 3 };
        for bands in [&[0, 1, 2][..], &[2, 0, 1], &[0, 1], &[1], &[2, 2, 2, 2]] {
            for (first, step) in [(0, bands.len()), (1, bands.len() + 2)] {
                let mut out = vec![-1.0; first + 2 * step];
                let mut expected = out.clone();
                for (pixel, (position, band)) in [1, 2]
                    .into_iter()
                    .flat_map(|pixel| bands.iter().enumerate().map(move |band| (pixel, band)))
                {
                    expected[first + (pixel - 1) * step + position] =
                        f64::from(values[pixel * 3 + *band as usize]);
                }
                pixels.widen(bands, Stride { first, step }, &mut out);
                assert_eq!(out, expected, "{bands:?} to {first} by {step}");
            }
        }
    }

    #[test]
    fn byte_orders() {
        assert_eq!(ByteOrder::Big.unsigned(&[1, 2]), 0x102);
        assert_eq!(ByteOrder::Little.unsigned(&[1, 2]), 0x201);
        let mut bytes = [0x01, 0x02];
        ByteOrder::Big.make_native(&mut bytes, 2);
        assert_eq!(u16::from_ne_bytes(bytes), 0x102);
    }
}
