//! Bits of coded data, and Huffman codes (T.81, annexes C and F.2.2.3).

/// Bits that a code's first look takes.
const QUICK: u32 = 9;
/// Bits of the longest code.
const LONGEST: usize = 16;

/// Why coded data cannot be followed further.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// Bits end.
    Ended,
    /// Bits hold something that no encoder writes.
    Wrong(&'static str),
}

/// Coded data between two markers, bit by bit.
pub struct Bits<'b> {
    bytes: &'b [u8],
    at: usize,
    /// The next bits, from the highest one down.
    held: u64,
    count: u32,
}

impl<'b> Bits<'b> {
    /// Begins at the first of `bytes`, in which 0xff is followed by a zero.
    pub fn new(bytes: &'b [u8]) -> Self {
        Self { bytes, at: 0, held: 0, count: 0 }
    }

    fn fill(&mut self) {
        while self.count <= 56
            && let Some(byte) = self.bytes.get(self.at)
        {
            self.at += if *byte == 0xff { 2 } else { 1 };
            self.held |= u64::from(*byte) << (56 - self.count);
            self.count += 8;
        }
    }

    /// The next `count` bits, at most 16.
    pub fn take(&mut self, count: u32) -> Result<u32, Stop> {
        if count == 0 {
            return Ok(0);
        }
        self.fill();
        if self.count < count {
            return Err(Stop::Ended);
        }
        let taken = (self.held >> (64 - count)) as u32;
        self.held <<= count;
        self.count -= count;
        Ok(taken)
    }

    /// The next number of `size` bits, at most 15, as T.81 writes it (F.2.2.1).
    pub fn number(&mut self, size: u32) -> Result<i32, Stop> {
        let bits = self.take(size)? as i32;
        let is_negative = size > 0 && bits < 1 << (size - 1);
        Ok(if is_negative { bits - (1 << size) + 1 } else { bits })
    }

    /// Whether nothing is left but the rest of a byte, and at most `filling` bytes of zeros, which some encoders add.
    pub fn is_used_up(&self, filling: usize) -> bool {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let held = (0..self.count / 8).map(|byte| (self.held << (self.count % 8) >> (56 - 8 * byte)) as u8);
        let left = held.len() + rest.len();
        left <= filling && held.chain(rest.iter().copied()).all(|byte| byte == 0)
    }
}

/// A table of Huffman codes.
#[derive(Debug, Clone)]
pub struct Codes {
    /// Symbol and length by the next [`QUICK`] bits; length 0 if the code is longer.
    quick: Vec<(u8, u8)>,
    /// The largest code of each length; −1 if there is none.
    largest: [i32; LONGEST + 1],
    /// Sum with which a code of each length gives its symbol's place.
    place: [i32; LONGEST + 1],
    symbols: Vec<u8>,
}

impl Codes {
    /// Codes as a DHT segment lists them: how many of each length, and their symbols. `None`: there are more than bits allow.
    pub fn new(counts: &[u8; LONGEST], symbols: &[u8]) -> Option<Self> {
        let mut codes = Self {
            quick: vec![(0, 0); 1 << QUICK],
            largest: [-1; LONGEST + 1],
            place: [0; LONGEST + 1],
            symbols: symbols.to_vec(),
        };
        let (mut code, mut first) = (0_u32, 0_usize);

        for length in 1..=LONGEST {
            let count = usize::from(counts[length - 1]);
            code <<= 1;
            if code as usize + count > 1 << length {
                return None;
            }
            codes.place[length] = first as i32 - code as i32;
            for symbol in symbols.get(first..first + count)? {
                if let Some(spare) = QUICK.checked_sub(length as u32) {
                    let from = (code << spare) as usize;
                    codes.quick[from..from + (1 << spare)].fill((*symbol, length as u8));
                }
                codes.largest[length] = code as i32;
                code += 1;
            }
            first += count;
        }

        Some(codes)
    }

    /// The next symbol.
    pub fn next(&self, bits: &mut Bits<'_>) -> Result<u8, Stop> {
        bits.fill();
        let (symbol, length) = self.quick[(bits.held >> (64 - QUICK)) as usize];
        let found = if length > 0 { Some((symbol, u32::from(length))) } else { self.long(bits.held) };
        match found {
            Some((symbol, length)) if length <= bits.count => {
                bits.held <<= length;
                bits.count -= length;
                Ok(symbol)
            }
            None if bits.count >= LONGEST as u32 => Err(Stop::Wrong("a code that does not exist")),
            _ => Err(Stop::Ended),
        }
    }

    fn long(&self, held: u64) -> Option<(u8, u32)> {
        let length = (QUICK as usize + 1..=LONGEST).find(|length| {
            let code = (held >> (64 - length)) as i32;
            code <= self.largest[*length]
        })?;
        let code = (held >> (64 - length)) as i32;
        let symbol = self.symbols.get((code + self.place[length]) as usize)?;
        Some((*symbol, length as u32))
    }
}
