//! Bytes of a file, taken one after another; past the end there is nothing.

/// Byte order of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// The least significant.
    Little,
    /// The most significant.
    Big,
}

/// A part of a file while it is read.
#[derive(Debug, Clone)]
pub(super) struct Bytes<'b> {
    rest: &'b [u8],
}

impl<'b> Bytes<'b> {
    /// All of `bytes`.
    pub fn of(bytes: &'b [u8]) -> Self {
        Self { rest: bytes }
    }

    /// Returns the number of bytes left.
    pub fn len(&self) -> usize {
        self.rest.len()
    }

    /// The next `count`.
    pub fn take(&mut self, count: usize) -> Option<&'b [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    pub fn u8(&mut self) -> Option<u8> {
        self.array().map(|[byte]| byte)
    }

    pub fn u16(&mut self, order: Order) -> Option<u16> {
        let bytes = self.array()?;
        Some(if order == Order::Big { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) })
    }

    pub fn u32(&mut self, order: Order) -> Option<u32> {
        let bytes = self.array()?;
        Some(if order == Order::Big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    pub fn f64(&mut self, order: Order) -> Option<f64> {
        let bytes = self.array()?;
        Some(if order == Order::Big { f64::from_be_bytes(bytes) } else { f64::from_le_bytes(bytes) })
    }

    /// A count of things of at least `size` bytes each, which must all still follow.
    pub fn count(&mut self, order: Order, size: usize) -> Option<usize> {
        let count = self.u32(order)? as usize;
        (count.checked_mul(size)? <= self.len()).then_some(count)
    }
}
