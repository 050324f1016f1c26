//! MagicaVoxel: the faces of voxels that are next to nothing, each by itself: of faces joined to larger ones the edges would not be those of their
//! neighbours, and rays could pass between them.

use std::collections::BTreeMap;

use dot_vox::{DotVoxData, Model, SceneNode};
use glam::{DMat3, DVec3, IVec3, Vec3};

use crate::model::contents::{MOST_CORNERS, within};
use crate::model::{Clause, MOST_TRIANGLES, Material, ModelPart};
use hedgehop_base::colour::linear_from_srgb8;

/// Bytes of a chunk's header: name, bytes of its own, bytes of its children.
const CHUNK: usize = 12;
/// Bytes before the first chunk.
const START: usize = 8;

/// Cells along the longest side of a model.
const MOST_SIDE: u32 = 256;

/// Instances that a scene graph may have.
const MOST_INSTANCES: usize = 65_536;

pub(super) fn read(bytes: &[u8]) -> Clause<crate::model::contents::Model> {
    check(bytes)?;
    let data = dot_vox::load_bytes(bytes).map_err(|error| format!("it is no MagicaVoxel file: {error}"))?;
    let mut raw = crate::model::contents::Model::new(DMat3::IDENTITY);

    let mut part = ModelPart {
        positions: Vec::new(),
        normals: Vec::new(),
        places: Vec::new(),
        colours: Vec::new(),
        triangles: Vec::new(),
        material: Material { both_sides: false, ..Material::of(Some(Vec3::ONE)) },
        node: None,
    };

    for (model, turn, shift) in instances(&data)? {
        add(&data, model, turn, shift, &mut part)?;
    }
    if part.triangles.is_empty() {
        return Err("it shows no voxels".to_owned());
    }

    raw.push(part);
    Ok(raw)
}

/// Refuses what is cut short, and chunks within chunks, which the format does not have: readers may take them one inside the other without end.
fn check(bytes: &[u8]) -> Clause<()> {
    let cut = || "it is cut short".to_owned();
    if !bytes.starts_with(b"VOX ") {
        return Err("it is no MagicaVoxel file".to_owned());
    }

    let sizes = |at: usize| -> Option<[usize; 2]> {
        let word = |at: usize| bytes.get(at..)?.first_chunk().map(|word| u32::from_le_bytes(*word) as usize);
        Some([word(at + 4)?, word(at + 8)?])
    };
    let [own, children] = sizes(START).ok_or_else(cut)?;
    let mut at = (START + CHUNK).checked_add(own).ok_or_else(cut)?;
    let end = at.checked_add(children).filter(|end| *end <= bytes.len()).ok_or_else(cut)?;

    while at < end {
        let [own, children] = sizes(at).ok_or_else(cut)?;
        if children != 0 {
            return Err("it has a chunk within a chunk, which MagicaVoxel does not write".to_owned());
        }
        at = (at + CHUNK).checked_add(own).filter(|at| *at <= end).ok_or_else(cut)?;
    }

    Ok(())
}

/// Models of the scene graph with their turns and the places of their middles; without a graph, each as it is.
fn instances(data: &DotVoxData) -> Clause<Vec<(&Model, DMat3, IVec3)>> {
    let known = |index: u32| {
        data.models
            .get(index as usize)
            .ok_or_else(|| format!("its scene names model {index}, which it has not"))
    };
    if data.scenes.is_empty() {
        return Ok(data.models.iter().map(|model| (model, DMat3::IDENTITY, IVec3::ZERO)).collect());
    }

    // Walks down the graph, turning and shifting what lies below each node.
    let mut found = Vec::new();
    let mut met = vec![false; data.scenes.len()];
    let mut waiting = vec![(0_u32, DMat3::IDENTITY, IVec3::ZERO)];

    while let Some((index, turn, shift)) = waiting.pop() {
        let node = data.scenes.get(index as usize).ok_or_else(|| format!("its scene has no node {index}"))?;
        if std::mem::replace(&mut met[index as usize], true) {
            return Err(format!("its node {index} is met twice; nodes must be a tree"));
        }

        // Hidden nodes and layers end the walk; shapes are its leaves.
        match node {
            SceneNode::Transform { attributes, frames, child, layer_id } => {
                let layer = data.layers.get(*layer_id as usize);
                if attributes.get("_hidden").is_some_and(|value| value == "1")
                    || layer.is_some_and(dot_vox::Layer::hidden)
                {
                    continue;
                }

                let frame = frames.first();
                let own = match frame.and_then(|frame| frame.attributes.get("_r")) {
                    Some(text) => rotation(text)
                        .ok_or_else(|| format!("its node {index} is turned by {text:?}, which is no turn"))?,
                    None => DMat3::IDENTITY,
                };
                let place = match frame.and_then(|frame| frame.attributes.get("_t")) {
                    Some(text) => place(text)
                        .ok_or_else(|| format!("its node {index} is moved by {text:?}, which is no place"))?,
                    None => IVec3::ZERO,
                };
                let moved = (turn * place.as_dvec3()).as_ivec3();
                waiting.push((*child, turn * own, shift.saturating_add(moved)));
            }
            SceneNode::Group { children, .. } => {
                waiting.extend(children.iter().rev().map(|child| (*child, turn, shift)));
            }
            SceneNode::Shape { models, .. } => {
                // Further ones are frames of an animation.
                if let Some(first) = models.first() {
                    found.push((known(first.model_id)?, turn, shift));
                }
            }
        }

        within("instances", found.len().max(waiting.len()), MOST_INSTANCES)?;
    }

    Ok(found)
}

/// A place of the format: three whole numbers.
fn place(text: &str) -> Option<IVec3> {
    let mut parts = text.split_ascii_whitespace().map(|part| part.parse().ok());
    let place = IVec3::new(parts.next()??, parts.next()??, parts.next()??);
    parts.next().is_none().then_some(place)
}

/// A turn of the format: where the entries of the first two rows are, and the signs of all three.
fn rotation(text: &str) -> Option<DMat3> {
    let byte: u8 = text.parse().ok()?;
    let (first, second) = (usize::from(byte & 3), usize::from(byte >> 2 & 3));
    if first == second || first == 3 || second == 3 {
        return None;
    }
    let mut rows = [DVec3::ZERO; 3];
    for (row, column) in [first, second, 3 - first - second].into_iter().enumerate() {
        rows[row][column] = if byte >> (4 + row) & 1 == 1 { -1.0 } else { 1.0 };
    }
    Some(DMat3::from_cols(rows[0], rows[1], rows[2]).transpose())
}

/// Puts a model's faces into a part.
fn add(data: &DotVoxData, model: &Model, turn: DMat3, shift: IVec3, part: &mut ModelPart) -> Clause<()> {
    let size = [model.size.x, model.size.y, model.size.z];
    if size.iter().any(|side| *side == 0 || *side > MOST_SIDE) {
        return Err(format!("it has a model of {size:?} voxels; each side may have {MOST_SIDE}"));
    }

    // Cells that are filled, by number.
    let [nx, ny, nz] = size.map(|side| side as i32);
    let index = |cell: IVec3| {
        let inside = cell.cmpge(IVec3::ZERO).all() && cell.cmplt(IVec3::new(nx, ny, nz)).all();
        inside.then(|| ((cell.z * ny + cell.y) * nx + cell.x) as usize)
    };

    // 0 is nothing, as in the format; voxels tell their colour less 1.
    let mut cells = BTreeMap::new();
    for voxel in &model.voxels {
        let cell = IVec3::new(i32::from(voxel.x), i32::from(voxel.y), i32::from(voxel.z));
        let at = index(cell).ok_or_else(|| format!("it has a voxel at {cell}, outside of its {size:?}"))?;
        cells.insert(at, u16::from(voxel.i) + 1);
    }

    let is_filled = |cell: IVec3| index(cell).is_some_and(|index| cells.contains_key(&index));
    // The middle of a model is where its node is; whole cells, as MagicaVoxel rounds it.
    let middle = IVec3::new(nx, ny, nz) / 2;
    let placed = |corner: IVec3| turn * (corner - middle).as_dvec3() + shift.as_dvec3();

    // A face for each side of a filled cell behind which there is none.
    let is_mirrored = turn.determinant() < 0.0;
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1), (axis, -1)]) {
        let [out, along, across] = [0, 1, 2].map(|step| IVec3::AXES[(axis + step) % 3]);
        let out = out * sign;
        for (number, colour) in &cells {
            let number = *number as i32;
            let cell = IVec3::new(number % nx, number / nx % ny, number / nx / ny);
            if is_filled(cell + out) {
                continue;
            }
            let base = cell + out.max(IVec3::ZERO);
            let corners = [base, base + along, base + along + across, base + across].map(placed);
            face(data, colour - 1, corners, (sign < 0) != is_mirrored, part)?;
        }
    }

    Ok(())
}

fn face(
    data: &DotVoxData,
    colour: u16,
    corners: [DVec3; 4],
    is_swapped: bool,
    part: &mut ModelPart,
) -> Clause<()> {
    let colour = data.palette.get(usize::from(colour));
    let colour = colour.ok_or_else(|| "its palette is cut short".to_owned())?;
    let first = part.positions.len() as u32;
    part.positions.extend(corners);
    part.colours.extend([Vec3::from_array(linear_from_srgb8([colour.r, colour.g, colour.b])); 4]);
    let triangles = if is_swapped { [[0, 2, 1], [0, 3, 2]] } else { [[0, 1, 2], [0, 2, 3]] };
    part.triangles.extend(triangles.map(|triangle| triangle.map(|corner| first + corner)));
    within("triangles", part.triangles.len(), MOST_TRIANGLES)?;
    within("corners", part.positions.len(), MOST_CORNERS)
}
