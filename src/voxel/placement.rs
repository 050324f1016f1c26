//! Objects that are stored once and stand in many places.
//!
//! ```text
//! object     columns of spans over a rectangle of voxels; codes count from its foot
//! placement  which object, turned by quarters and mirrored or not, its south-west voxel, and the code of its foot
//! ```
//!
//! So a wood costs 8 bytes a tree and block of the page that the tree reaches, and what tells one kind of tree from another is in memory once
//! (instancing; Evans & Sutherland placed a desert's bushes and trees so, Continuous Tone 5A, 1981). A turned object lies on the voxels as
//! the others do, and its spans are spans like any.

use std::ops::Neg;

use super::format::{PLANE_ALIGNMENT, objects as at};
use super::stored_spans::StoredSpan;
use super::{Cut, Facade, Span};

/// Columns of spans over a rectangle of voxels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SharedObject {
    /// Voxels eastward and northward.
    size: [u16; 2],
    /// Codes above the foot that its spans do not leave, slopes and all; 0 if one of them stands on the ground.
    low: u16,
    high: u16,
    /// First span of each voxel, and the last one's end.
    starts: Vec<u32>,
    spans: Vec<Span>,
}

/// The objects of a database, by number.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SharedObjects(Vec<SharedObject>);

/// Place of an object on a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Placement {
    /// Height code of its foot.
    pub foot: u16,
    /// Number of the object times 8, and its [symmetry](Symmetry).
    pub object: u16,
    /// South-west voxel, eastward and northward from the page's: less than 0 where it begins on another page.
    pub first: [i16; 2],
}

/// One of the eight ways to lay a lattice of voxels onto itself: bits 0 and 1 are quarter turns counter-clockwise, after bit 2 mirrored it from
/// east to west.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Symmetry(u8);

impl Symmetry {
    /// All of them.
    pub const COUNT: u16 = 8;

    /// Makes a symmetry from the lower three bits.
    pub fn new(bits: u64) -> Self {
        Self((bits & 7) as u8)
    }

    /// Quarter turns counter-clockwise, 0…3.
    #[inline]
    pub fn turns(self) -> u8 {
        self.0 & 3
    }

    /// Whether east and west change places before that.
    #[inline]
    pub fn is_mirrored(self) -> bool {
        self.0 & 4 != 0
    }

    /// Turns a direction, or a voxel counted from the one in the middle: (east, north).
    #[inline]
    pub fn turn<T: Copy + Neg<Output = T>>(self, [x, y]: [T; 2]) -> [T; 2] {
        let x = if self.is_mirrored() { -x } else { x };
        match self.turns() {
            0 => [x, y],
            1 => [-y, x],
            2 => [-x, -y],
            _ => [y, -x],
        }
    }

    /// Turns it back to where it came from.
    #[inline]
    pub fn turn_back<T: Copy + Neg<Output = T>>(self, [x, y]: [T; 2]) -> [T; 2] {
        let [x, y] = match self.turns() {
            0 => [x, y],
            1 => [y, -x],
            2 => [-x, -y],
            _ => [-y, x],
        };
        [if self.is_mirrored() { -x } else { x }, y]
    }

    /// Voxels eastward and northward of an object of `size` when it is turned.
    #[inline]
    fn size(self, [width, depth]: [u16; 2]) -> [u16; 2] {
        if self.turns().is_multiple_of(2) { [width, depth] } else { [depth, width] }
    }

    /// Finds the voxel of an object of `size` that lies at a voxel of the turned one.
    #[inline]
    fn source(self, voxel: [u16; 2], size: [u16; 2]) -> [u16; 2] {
        let (turned, [width, depth]) = (self.size(size), size.map(i32::from));
        // Twice the way from the middle: whole numbers.
        let from_middle = [0, 1].map(|axis| 2 * i32::from(voxel[axis]) + 1 - i32::from(turned[axis]));
        let [x, y] = self.turn_back(from_middle);
        [(x + width - 1) / 2, (y + depth - 1) / 2].map(|at| at as u16)
    }

    /// A span of an object when it is turned.
    #[inline]
    fn turned(self, span: Span) -> Span {
        let slope = self.turn(span.slope.map(i16::from));
        Span {
            slope: slope.map(|slope| slope.min(i8::MAX.into()) as i8),
            cuts: span.cuts.map(|cut| {
                let facing = if self.is_mirrored() { 128_u8.wrapping_sub(cut.facing) } else { cut.facing };
                Cut { facing: facing.wrapping_add(64 * self.turns()), ..cut }
            }),
            ..span
        }
    }
}

impl Placement {
    /// An object by number, less than [`SharedObjects::MOST`].
    pub fn new(object: u16, symmetry: Symmetry, first: [i16; 2], foot: u16) -> Self {
        Self { foot, object: object * Symmetry::COUNT + u16::from(symmetry.0), first }
    }

    /// Number of the object.
    pub fn number(self) -> usize {
        usize::from(self.object / Symmetry::COUNT)
    }

    fn symmetry(self) -> Symmetry {
        Symmetry::new(self.object.into())
    }
}

impl SharedObject {
    /// Voxels along a side at most: it reaches no further than the pages beside its own.
    pub const MOST_VOXELS: u16 = super::PAGE_SIDE as u16;

    /// Makes an object of `width` × `depth` voxels, 1 to [`Self::MOST_VOXELS`] each: `spans_of` tells those of a voxel (x, y), codes from the foot, whose
    /// façades are left out: an object may be turned. `rise` as for
    /// [`super::SpanTable::new`].
    pub fn new(size: [u16; 2], rise: f64, mut spans_of: impl FnMut(u16, u16, &mut Vec<Span>)) -> Self {
        let (mut starts, mut spans) = (vec![0], Vec::new());
        for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
            let before = spans.len();
            spans_of(x, y, &mut spans);
            spans[before..].iter_mut().for_each(|span: &mut Span| span.facade = Facade::NONE);
            starts.push(spans.len() as u32);
        }
        let mut object = Self { size, low: 0, high: 0, starts, spans };
        (object.low, object.high) = object.reach(rise);
        object
    }

    fn reach(&self, rise: f64) -> (u16, u16) {
        let reach = |(low, high): (u16, u16), span: &Span| {
            let [lower, upper] = span.reach(rise);
            (low.min(lower), high.max(upper))
        };
        let (low, high) = self.spans.iter().fold((u16::MAX, 0), reach);
        if self.spans.is_empty() { (0, 0) } else { (low, high) }
    }

    /// Spans of a voxel, lowest first.
    #[inline]
    fn of(&self, [x, y]: [u16; 2]) -> &[Span] {
        let index = usize::from(y) * usize::from(self.size[0]) + usize::from(x);
        match self.starts.get(index..index + 2) {
            Some(&[start, end]) => self.spans.get(start as usize..end as usize).unwrap_or_default(),
            _ => &[],
        }
    }

    /// Materials of its spans, again and again.
    pub fn materials(&self) -> impl Iterator<Item = u8> + '_ {
        self.spans.iter().map(|span| span.material)
    }

    /// Voxels eastward and northward as `placement` has it.
    pub fn size(&self, placement: Placement) -> [u16; 2] {
        placement.symmetry().size(self.size)
    }

    /// Voxels eastward and northward before it is turned.
    pub fn voxels(&self) -> [u16; 2] {
        self.size
    }

    /// Bytes that it takes in a file, whatever the number of its placements.
    pub fn bytes(&self) -> u64 {
        (at::SIZE + size_of_val(&self.starts[..]) + self.spans.len() * size_of::<StoredSpan>()) as u64
    }

    /// Codes that it does not leave where its foot is at `foot`; the first is 0 if it stands on the ground.
    pub fn codes(&self, foot: u16) -> [u16; 2] {
        let low = if self.low == Span::GROUND { Span::GROUND } else { foot.saturating_add(self.low) };
        [low, foot.saturating_add(self.high)]
    }

    /// Counts the spans that a placed object has over a voxel, (x, y) from the placement's south-west one.
    #[inline]
    pub(super) fn count_at(&self, placement: Placement, voxel: [u16; 2]) -> u32 {
        self.of(placement.symmetry().source(voxel, self.size)).len() as u32
    }

    /// Spans that a placed object has over a voxel, (x, y) from the placement's south-west one, lowest first.
    #[inline]
    pub fn spans_at(&self, placement: Placement, voxel: [u16; 2]) -> impl Iterator<Item = Span> + '_ {
        let (symmetry, foot) = (placement.symmetry(), placement.foot);
        self.of(symmetry.source(voxel, self.size)).iter().map(move |span| {
            let low = if span.low == Span::GROUND { Span::GROUND } else { foot.saturating_add(span.low) };
            Span { low, high: foot.saturating_add(span.high), ..symmetry.turned(*span) }
        })
    }

    /// Says what is wrong with it, if something is.
    fn check(&self, rise: f64) -> Option<String> {
        let (low, high) = self.reach(rise);
        if low < self.low || high > self.high {
            let (low_said, high_said) = (self.low, self.high);
            return Some(format!("spans from code {low} to {high} leave {low_said} to {high_said}"));
        }
        self.spans.iter().find_map(Span::check)
    }
}

impl SharedObjects {
    /// Most objects of one database: placements number them with 13 bits.
    pub const MOST: usize = 1 << 13;

    /// Objects in the order of their numbers, no more than [`Self::MOST`].
    pub fn new(objects: Vec<SharedObject>) -> Self {
        Self(objects)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Counts the objects.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// All of them, by number.
    pub fn all(&self) -> &[SharedObject] {
        &self.0
    }

    /// The object that is placed.
    #[inline]
    pub fn get(&self, placement: Placement) -> Option<&SharedObject> {
        self.0.get(placement.number())
    }

    /// Encodes the objects as they are stored: nothing if there are none.
    pub fn to_bytes(&self) -> Vec<u8> {
        if self.is_empty() {
            return Vec::new();
        }

        let mut bytes = vec![0; at::HEAD];
        at::COUNT.put(&mut bytes, &(self.0.len() as u32).to_le_bytes());
        for SharedObject { size: [width, depth], low, high, spans, .. } in &self.0 {
            let mut record = [0; at::SIZE];
            for (field, value) in [(at::WIDTH, width), (at::DEPTH, depth), (at::LOW, low), (at::HIGH, high)] {
                field.put(&mut record, &value.to_le_bytes());
            }
            at::SPANS.put(&mut record, &(spans.len() as u32).to_le_bytes());
            bytes.extend(record);
        }

        for SharedObject { starts, spans, .. } in &self.0 {
            bytes.extend_from_slice(bytemuck::cast_slice(starts));
            let stored: Vec<_> = spans.iter().map(StoredSpan::of).collect();
            bytes.extend_from_slice(bytemuck::cast_slice(&stored));
        }

        bytes.resize(bytes.len().next_multiple_of(PLANE_ALIGNMENT), 0);
        bytes
    }

    /// Decodes what is stored, or says what is wrong with it; `rise` as for [`super::SpanTable::new`].
    pub(super) fn decode(bytes: &[u8], rise: f64) -> Result<Self, String> {
        if bytes.is_empty() {
            return Ok(Self::default());
        }

        let short = || format!("{} bytes do not hold all objects", bytes.len());
        let (head, mut rest) = bytes.split_at_checked(at::HEAD).ok_or_else(short)?;
        let count = at::COUNT.u32(head) as usize;
        if count == 0 || count > Self::MOST || head[at::COUNT.end()..].iter().any(|&byte| byte != 0) {
            return Err(format!("{count} objects, but there may be 1 to {}", Self::MOST));
        }

        let records;
        (records, rest) = rest.split_at_checked(count * at::SIZE).ok_or_else(short)?;
        let mut take = |length: usize| {
            let taken;
            (taken, rest) = rest.split_at_checked(length).ok_or_else(short)?;
            Ok::<_, String>(taken)
        };
        let mut objects = Vec::with_capacity(count);

        for record in records.chunks_exact(at::SIZE) {
            let number = |field: super::format::Field| u16::from_le_bytes(field.array(record));
            let size = [number(at::WIDTH), number(at::DEPTH)];
            if size.iter().any(|side| !(1..=SharedObject::MOST_VOXELS).contains(side)) {
                return Err(format!("an object of {} x {} voxels", size[0], size[1]));
            }

            let voxels = usize::from(size[0]) * usize::from(size[1]);
            let starts: Vec<u32> = bytemuck::pod_collect_to_vec(take((voxels + 1) * size_of::<u32>())?);
            let count = at::SPANS.u32(record) as usize;
            let stored: Vec<StoredSpan> =
                bytemuck::pod_collect_to_vec(take(count.saturating_mul(size_of::<StoredSpan>()))?);
            let spans = stored.into_iter().map(|span| span.with(Facade::NONE)).collect::<Vec<_>>();
            let is_whole = starts.is_sorted() && starts[0] == 0 && starts[voxels] as usize == count;
            if !is_whole || at::RESERVED.bytes(record).iter().any(|&byte| byte != 0) {
                return Err("some spans of an object belong to no voxel".into());
            }

            let object = SharedObject { size, low: number(at::LOW), high: number(at::HIGH), starts, spans };
            match object.check(rise) {
                Some(what) => return Err(format!("object {}: {what}", objects.len())),
                None => objects.push(object),
            }
        }

        let is_over = rest.len() < PLANE_ALIGNMENT && rest.iter().all(|&byte| byte == 0);
        if is_over { Ok(Self(objects)) } else { Err("more bytes follow its objects".into()) }
    }
}
