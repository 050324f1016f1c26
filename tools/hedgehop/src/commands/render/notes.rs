//! Notes of a render besides its frames.

use std::collections::BTreeMap;
use std::path::Path;

use crate::memory::Late;
use crate::progress::Reporter;
use crate::sequence::Fineness;
use hedgehop::Result;
use hedgehop::encode::Target;
use hedgehop::progress::Observer;
use hedgehop::render::{Engine, NumberedCamera, RenderOptions, Renderer, Unserved};
use hedgehop::sunlight::Sun;
use hedgehop::voxel::Header;

/// Degrees between two suns whose shadows nobody can tell apart.
const ONE_SUN: f32 = 0.5;

/// Says where pages of a level are not to be had at all, if there are such.
pub fn elsewhere(is_whole: bool, is_damaged: bool) -> &'static str {
    match (is_whole, is_damaged) {
        (true, false) => "",
        (true, true) => ", where pages are damaged",
        (false, false) => ", outside of corridors",
        (false, true) => ", outside of corridors or where pages are damaged",
    }
}

/// Says that files of light, depth or labels hold no finished pictures.
pub fn left_out(target: Option<Target>) -> &'static str {
    match target {
        Some(Target::Npy) => "NPY holds depth: exposure, curves, vignette and text and figures are left out",
        Some(Target::Png) => {
            "labels are no light: exposure, curves, vignette and text and figures are left out"
        }
        _ => "EXR holds linear light: exposure, curves, vignette and text and figures are left out",
    }
}

/// Says how much was seen more coarsely than it should be, if anything was; `elsewhere`, where it can be no better.
pub fn coarser(Fineness { rays, coarsest }: &Fineness, late: Late, elsewhere: &str) -> Option<String> {
    let (number, most) = coarsest.filter(|(_, most)| *most > 0.0)?;
    let percent = 100.0 * rays.coarser_share();
    Some(match late {
        Late::Wait => {
            format!(
                "{percent:.3} % of the rays met ground that is stored more coarsely than they ask for{elsewhere}"
            )
        }
        Late::Coarser => format!(
            "{percent:.3} % of the rays met ground that is coarser than they ask for, since its pages came late{}{elsewhere}; most in frame {number}: {:.3} %",
            if elsewhere.is_empty() { "" } else { ", or are not there" },
            100.0 * most
        ),
    })
}

/// Says that shadows in the colours are those of another sun than the one that lights the pictures; `None`: one that runs.
pub fn other_sun(area: &Path, header: &Header, sun: Option<Sun>) -> Option<String> {
    let [azimuth, elevation] = header.metadata.baked_sun?;
    let baked = Sun { azimuth, elevation };
    let is_other = |sun: Sun| baked.direction().angle_between(sun.direction()).to_degrees() > ONE_SUN;
    sun.is_none_or(is_other).then(|| {
        let place = |sun: Sun| format!("{:.1}° from grid north and {:.1}° high", sun.azimuth, sun.elevation);
        let lit = sun.map_or_else(|| "that runs with the flight".to_owned(), place);
        format!(
            "{} holds the shadows of a sun {} in its colours, and is lit by one {lit}; leave --sun out, or take the database that it was baked from: \
             render that with --shadows on, or `hedgehop bake` it for this sun",
            area.display(),
            place(baked)
        )
    })
}

/// Says how many frames the engine that was asked for leaves to the reference marcher, and why.
pub fn left_to_reference(
    renderer: &Renderer<'_>,
    options: &RenderOptions,
    cameras: &[NumberedCamera],
    antialias: u32,
    reporter: &Reporter,
) -> Result<()> {
    if options.engine == Engine::Reference {
        return Ok(());
    }
    let mut counts: BTreeMap<Unserved, usize> = BTreeMap::new();
    for NumberedCamera { camera, .. } in cameras {
        if let Some(why) = renderer.unserved(&camera.enlarged(antialias))? {
            *counts.entry(why).or_default() += 1;
        }
    }
    for (why, count) in counts {
        reporter.note(&format!(
            "scan planes do not serve {count} of {} frames, since {why}; the reference, which is slower, renders these",
            cameras.len()
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use hedgehop::voxel::{Grid, Metadata, PageSource, build_in_memory};

    use super::*;

    #[test]
    fn shadows_of_another_sun_are_told() {
        let grid = Grid { nx: 2, ny: 2, spacing: 1.0, origin: glam::DVec2::ZERO };
        let metadata = Metadata { baked_sun: Some([120.0, 30.0]), ..Metadata::default() };
        let of =
            |metadata: &Metadata| build_in_memory(grid, &[0.0; 4], &[[0; 3]; 4], None, metadata).unwrap();
        let (baked, plain) = (of(&metadata), of(&Metadata::default()));
        let note = |pages: &hedgehop::voxel::MemPages, azimuth: f64| {
            other_sun(Path::new("a.hop"), pages.header(), Some(Sun { azimuth, elevation: 30.0 }))
        };
        assert_eq!(note(&baked, 120.1), None);
        assert_eq!(note(&baked, 480.0), None);
        assert_eq!(note(&plain, 200.0), None);
        let said = note(&baked, 200.0).unwrap();
        for part in ["a.hop", "120.0°", "200.0°", "30.0°", "--shadows on", "hedgehop bake"] {
            assert!(said.contains(part), "{said}");
        }
        assert_eq!(other_sun(Path::new("a.hop"), plain.header(), None), None);
        let said = other_sun(Path::new("a.hop"), baked.header(), None).unwrap();
        assert!(said.contains("120.0°") && said.contains("runs with the flight"), "{said}");
    }
}
