//! A model of voxels, and its file: MagicaVoxel's `.vox` of version 150.
//!
//! ```text
//! "VOX ", version; chunks: name, bytes of its own, bytes of its children, content
//! MAIN  nothing of its own; children: SIZE  x y z u32 | XYZI  count, count × (x y z colour) u8 | RGBA  256 × (r g b a) u8
//! ```
//! Colours count from 1; the first of `RGBA` is number 1.

use std::error::Error;

/// Voxels that are filled; x to the right, y to the front, z up.
pub struct Voxels {
    size: [usize; 3],
    /// Colour's number, 0 where nothing is; z above y above x.
    cells: Vec<u8>,
}

impl Voxels {
    pub fn new(size: [usize; 3]) -> Self {
        Self { size, cells: vec![0; size.iter().product()] }
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.size[1] + y) * self.size[0] + x
    }

    /// Fills a box from its first voxel to before its last.
    pub fn fill(&mut self, low: [usize; 3], high: [usize; 3], colour: u8) {
        for z in low[2]..high[2] {
            for y in low[1]..high[1] {
                for x in low[0]..high[0] {
                    let index = self.index([x, y, z]);
                    self.cells[index] = colour;
                }
            }
        }
    }

    /// Colour's number of a voxel, 0 where nothing is and outside.
    fn colour(&self, at: [Option<usize>; 3]) -> u8 {
        let [Some(x), Some(y), Some(z)] = at else { return 0 };
        let inside = x < self.size[0] && y < self.size[1] && z < self.size[2];
        if inside { self.cells[self.index([x, y, z])] } else { 0 }
    }

    /// Place and colour of the voxels that are seen: those with a free side.
    pub fn shell(&self) -> impl Iterator<Item = ([usize; 3], u8)> {
        let places = (0..self.cells.len()).map(|k| {
            let [nx, ny, _] = self.size;
            [k % nx, k / nx % ny, k / nx / ny]
        });
        places.filter_map(|at| {
            let is_free = |axis: usize, ahead: bool| {
                let mut beside = at.map(Some);
                beside[axis] = if ahead { Some(at[axis] + 1) } else { at[axis].checked_sub(1) };
                self.colour(beside) == 0
            };
            let colour = self.colour(at.map(Some));
            let is_seen = colour > 0 && (0..3).any(|axis| is_free(axis, false) || is_free(axis, true));
            is_seen.then_some((at, colour))
        })
    }
}

/// The file's bytes; an error if a side is longer than the format's 256 voxels.
pub fn encode(voxels: &Voxels, colours: &[[u8; 3]]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut size = Vec::new();
    for side in voxels.size {
        u8::try_from(side - 1)?;
        size.extend(u32::try_from(side)?.to_le_bytes());
    }

    let mut cells = Vec::new();
    for (at, colour) in voxels.shell() {
        cells.extend(at.map(|place| place as u8));
        cells.push(colour);
    }

    let mut places = u32::try_from(cells.len() / 4)?.to_le_bytes().to_vec();
    places.extend(cells);
    let mut palette: Vec<u8> =
        colours.iter().flat_map(|&[red, green, blue]| [red, green, blue, 255]).collect();
    palette.resize(4 * 256, 0);
    let mut children = Vec::new();
    for (name, content) in [(b"SIZE", size), (b"XYZI", places), (b"RGBA", palette)] {
        children.extend(chunk(name, &content, 0)?);
    }

    let mut bytes = b"VOX ".to_vec();
    bytes.extend(150u32.to_le_bytes());
    bytes.extend(chunk(b"MAIN", &[], children.len())?);
    bytes.extend(children);

    Ok(bytes)
}

fn chunk(name: &[u8; 4], content: &[u8], children: usize) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut bytes = name.to_vec();
    bytes.extend(u32::try_from(content.len())?.to_le_bytes());
    bytes.extend(u32::try_from(children)?.to_le_bytes());
    bytes.extend(content);
    Ok(bytes)
}
