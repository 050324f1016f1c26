//! A frame through scan planes: march, then the image stage.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::above_ground::height_above_ground;
use super::account::{Account, Rays, Rendered, StageTimes};
use super::limits::level_bands;
use super::plane_image::{DepthsMut, PlaneImage, first_part};
use super::plane_view::PlaneView;
use super::renderer::Renderer;
use super::spans::{self, SpanRenderer};
use super::surface;
use crate::cache::Lent;
use crate::detail::Displacement;
use crate::frame::stage::{
    Band, Cell, Depths, DetailView, EdgeSums, Painter, Painting, PlaneAir, PlaneSource, RowDetail, RowFill,
    Scale,
};
use crate::frame::{Frame, Picture};
use crate::pixels::Pixels;
use crate::raymarch::scan::{
    BoundPyramid, DisplacedField, DisplacedPages, FootprintGroup, KeptPlanes, MarchField, Outlook,
    PageFootprint, PlaneGroup, PlaneMarch, Profile, RowTable, Strides,
};
use crate::sensor::radiance::{LineSampler, RadiancePages};
use crate::simd::{LANES, Sixteen};
use crate::subimage::{Farm, Stage, TaskSize};
use crate::voxel::{BARE, PageId, PageNeeds};
use crate::weather::{AtmosphereLanes, SteepHeights};
use hedgehop_base::error::Result;

/// Planes of a march task, and rows of an image task, unless told otherwise: small ones cost nothing, and many workers find
/// one each.
const SUITABLE: TaskSize = TaskSize { lines: 32, rows: 18 };

/// Time that tasks took, added up by all workers.
#[derive(Default)]
struct StageClock(Mutex<Duration>);

impl StageClock {
    fn time<T>(&self, work: impl FnOnce() -> T) -> T {
        let begun = Instant::now();
        let result = work();
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) += begun.elapsed();
        result
    }

    fn total(self) -> Duration {
        self.0.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Renders an 8-bit picture, and the range of its pixels into `range`, which is as long as it or empty: of those in `parts` of rows (see [`Band::parts`]), or of all
/// if these are empty.
pub fn picture(
    renderer: &Renderer<'_>,
    view: &PlaneView<'_>,
    farm: &Farm,
    range: &mut [f32],
    parts: &[bool],
) -> Result<(Picture, Account)> {
    let (width, height) = (view.camera.width, view.camera.height);
    // All of it is overwritten.
    let mut rgb = renderer.shared.pictures.take();
    rgb.resize(width as usize * height as usize * 3, 0);
    let band = band_rows(farm) * width as usize;
    let ranges = range.chunks_mut(band).chain(std::iter::repeat_with(Default::default));
    let per_band = band_rows(farm) * (width as usize).div_ceil(LANES);
    let parts = parts.chunks(per_band).chain(std::iter::repeat(Default::default()));
    let bands = rgb
        .chunks_mut(band * 3)
        .zip(ranges.zip(parts))
        .map(|(rgb, (range, parts))| Band { light: Pixels::Srgb8(rgb), range, parts, outlines: &mut [] })
        .collect();
    let scale = Scale::under(renderer.options.brightness().tint());
    let account = render(renderer, view, farm, bands, scale)?;
    Ok((Picture { width, height, rgb }, account))
}

/// Renders a frame with all its planes; unless it `describes` surfaces, normals, levels and ids are those of the sky. Ranges at outlines are those of the nearest
/// plane and row; if it does, those along the pixels' own rays come beside.
pub fn frame(
    renderer: &Renderer<'_>,
    view: &PlaneView<'_>,
    describes: bool,
    farm: &Farm,
) -> Result<(Rendered, Option<Vec<f32>>)> {
    let mut frame = Frame::sky(view.camera.clone());
    let width = view.camera.width as usize;
    let band = band_rows(farm) * width;
    let mut outlines = vec![false; if describes { frame.range.len() } else { 0 }];

    let bands = frame
        .colour
        .chunks_mut(band)
        .zip(frame.range.chunks_mut(band))
        .zip(outlines.chunks_mut(band).chain(std::iter::repeat_with(Default::default)))
        .map(|((colour, range), outlines)| Band {
            light: Pixels::Linear(colour),
            range,
            parts: &[],
            outlines,
        })
        .collect();

    let account = render(renderer, view, farm, bands, Scale::ALL)?;
    let own = describes.then(|| surface::describe(renderer, &mut frame, &outlines, farm)).transpose()?;

    Ok((Rendered { frame, account }, own))
}

/// Rows of an image task.
fn band_rows(farm: &Farm) -> usize {
    farm.task_size_or(SUITABLE).rows.max(1) as usize
}

/// Has planes look, then fills `bands` of [`band_rows`] rows; light is kept to `scale` meanwhile.
fn render(
    renderer: &Renderer<'_>,
    view: &PlaneView<'_>,
    farm: &Farm,
    bands: Vec<Band<'_>>,
    scale: Scale,
) -> Result<Account> {
    let (marching, shading, imaging) = (StageClock::default(), StageClock::default(), StageClock::default());
    renderer.lit.radiance.begin_frame();
    renderer.shared.turned.begin_frame();
    let groups: Vec<_> = (0..view.shape.groups()).map(|index| view.shape.kept(index)).collect();
    let size = groups.iter().map(|kept| kept.rows).sum();
    let with_range = bands.first().is_some_and(Band::has_range);

    // What a frame before left in it is overwritten, or not looked at.
    let mut plane_image = renderer.shared.plane_images.take();
    plane_image.cells.resize(size, Cell::default());
    plane_image.inverse.resize(if with_range { size } else { 0 }, Sixteen::default());
    let stands = with_range && renderer.source.header().has_spans;
    for tilts in &mut plane_image.tilts {
        tilts.resize(if stands { size } else { 0 }, Sixteen::default());
    }

    let rays = see(
        renderer,
        view,
        farm,
        [&marching, &shading],
        SeenGroups { groups: &groups, scale, plane_image: &mut plane_image },
    )?;
    let tint = renderer.options.brightness().tint().to_array();
    let depths =
        Depths { inverse: &plane_image.inverse, tilts: plane_image.tilts.each_ref().map(Vec::as_slice) };
    let planes = PlaneSource { shape: &view.shape, cells: &plane_image.cells, scale, tint, depths };
    let (rows, width) = (band_rows(farm), view.camera.width as usize);

    farm.each(Stage::Image, bands, |index, band| {
        imaging.time(|| {
            band.fill(renderer.isa, planes, width, index * rows);
            Ok(())
        })
    })?;
    renderer.shared.plane_images.give_back(plane_image);
    let times = StageTimes { march: marching.total(), shade: shading.total(), image: imaging.total() };

    Ok(Account { times, rays })
}

/// Groups of planes with the cells that they see.
struct SeenGroups<'f> {
    /// Segments kept of each group.
    groups: &'f [KeptPlanes],
    /// Scale of the cells' codes.
    scale: Scale,
    /// Memory for it.
    plane_image: &'f mut PlaneImage,
}

/// A few groups of planes, and the plane image's memory of them.
struct Task<'f> {
    /// Index of the first one.
    first: usize,
    groups: &'f [KeptPlanes],
    cells: &'f mut [Cell],
    depths: DepthsMut<'f>,
}

impl<'f> Task<'f> {
    /// Iterates over the task's groups that see something.
    fn looks(self) -> impl Iterator<Item = GroupLook<'f>> {
        let Self { first, groups, mut cells, mut depths } = self;
        let looks = (first..).zip(groups).map(move |(index, kept)| {
            let (cells, depths) = (first_part(&mut cells, kept.rows), depths.first_part(kept.rows));
            GroupLook { index, kept, cells, depths, bare_until: 0.0 }
        });
        looks.filter(|look| !look.kept.filled.is_empty())
    }
}

impl<'f> SeenGroups<'f> {
    /// Tasks of so many groups.
    fn tasks(self, per_task: usize) -> Vec<Task<'f>> {
        let PlaneImage { cells, inverse, tilts } = self.plane_image;
        let mut cells = cells.as_mut_slice();
        let mut depths = DepthsMut { inverse, tilts: tilts.each_mut().map(Vec::as_mut_slice) };
        let chunks = self.groups.chunks(per_task).enumerate();
        let task = |(index, groups): (usize, &'f [KeptPlanes])| {
            let rows = groups.iter().map(|kept| kept.rows).sum();
            Task {
                first: index * per_task,
                groups,
                cells: first_part(&mut cells, rows),
                depths: depths.first_part(rows),
            }
        };
        chunks.map(task).collect()
    }
}

/// Returns the distance between rows, and the height of the eye above the ground, metres.
fn strides(renderer: &Renderer<'_>, view: &PlaneView<'_>) -> Result<(Strides, f64)> {
    let header = renderer.source.header();
    let height = height_above_ground(renderer.source, view.eye)?;
    let (pixel_angle, clearance) = (view.camera.pixel_angle(), view.eye.z - header.height_range.high);
    let outlook = Outlook { pixel_angle, clearance, height };
    let strides = Strides::new(&header.grid, header.level_count, outlook, renderer.options.detail);
    Ok((strides, height))
}

/// Parts of pages that planes may touch, in the order of need.
pub fn footprint(renderer: &Renderer<'_>, view: &PlaneView<'_>) -> Result<PageNeeds> {
    let header = renderer.source.header();
    let (strides, _) = strides(renderer, view)?;
    let row_table = view.shape.row_table();
    let bend = renderer.options.curvature.inverse_diameter;
    let groups: Vec<_> = (0..view.shape.groups())
        .map(|index| (index, view.shape.kept(index)))
        .filter(|(_, kept)| !kept.filled.is_empty())
        .map(|(index, kept)| FootprintGroup {
            group: view.shape.group(index, &header.grid, view.eye, bend),
            field: field(renderer, &row_table, &kept),
        })
        .collect();
    let bare_until = level_bands(header, view.camera, &renderer.options).bare_until();
    let displacement = renderer.displacement(view.camera)?;
    let mut footprint =
        PageFootprint::new(renderer.source, strides, bare_until).displaced(displacement.as_ref());
    footprint.add(view.eye, &groups)?;
    if let Some(displacement) = &displacement {
        footprint.add_materials(displaced_pages(renderer, view, displacement).ids());
    }
    Ok(footprint.into_needs())
}

/// Finds the pages whose materials tell how far ground is displaced.
fn displaced_pages(
    renderer: &Renderer<'_>,
    view: &PlaneView<'_>,
    displacement: &Displacement,
) -> DisplacedPages {
    let header = renderer.source.header();
    let bare_until = level_bands(header, view.camera, &renderer.options).bare_until();
    let level = if bare_until > 0.0 { BARE } else { 0 };
    let bend = renderer.options.curvature.inverse_diameter;
    let seen = (0..view.shape.groups()).filter(|index| !view.shape.kept(*index).filled.is_empty());
    let groups = seen.map(|index| view.shape.group(index, &header.grid, view.eye, bend));
    DisplacedPages::of(renderer.source, displacement, level, groups)
}

/// Returns the field that a group of planes is to see.
pub(crate) fn field(renderer: &Renderer<'_>, row_table: &RowTable, kept: &KeptPlanes) -> MarchField {
    let rows = kept.first..kept.first + kept.filled.len();
    let tangents = [row_table.edges[rows.start], row_table.edges[rows.end]];
    MarchField { tangents, row: row_table.least_row, detail: renderer.options.detail as f32 }
}

/// Scratch that a worker uses for one group after the other.
struct Worker<'a> {
    march: PlaneMarch<'a>,
    paint: Paint<'a>,
    profile: Lent<'a, Profile>,
}

/// Scratch of painting.
struct Paint<'a> {
    painter: Painter<'a>,
    air: AtmosphereLanes,
    sums: Lent<'a, EdgeSums>,
    span_renderer: Option<SpanRenderer<'a>>,
}

/// A group of planes, and the plane image's memory of it.
struct GroupLook<'f> {
    index: usize,
    kept: &'f KeptPlanes,
    cells: &'f mut [Cell],
    depths: DepthsMut<'f>,
    /// Major distance up to which bare ground was seen, units.
    bare_until: f64,
}

/// Groups that have marched and cannot be painted yet.
#[derive(Default)]
struct Unpainted<'f> {
    looks: Vec<(GroupLook<'f>, Profile)>,
    /// Pages that must be brought to paint them.
    pages: BTreeSet<PageId>,
}

/// Has groups of planes look.
///
/// Where a surface is in sight tells what paint it takes: groups for which it is not at hand stand back until it has been brought for all of them.
fn see(
    renderer: &Renderer<'_>,
    view: &PlaneView<'_>,
    farm: &Farm,
    [marching, shading]: [&StageClock; 2],
    seen: SeenGroups<'_>,
) -> Result<Rays> {
    let header = renderer.source.header();
    let (strides, above_ground) = strides(renderer, view)?;
    let bands = level_bands(header, view.camera, &renderer.options);
    let strides = strides.with_bare_ground(bands.bare_until());
    let pixel_angle = view.camera.pixel_angle();
    let row_table = view.shape.row_table();
    let per_task = (farm.task_size_or(SUITABLE).lines as usize / LANES).max(1);
    let bend = renderer.options.curvature.inverse_diameter;
    let atmosphere = renderer.options.atmosphere(header);
    let scale = seen.scale;
    let rays = Mutex::new(Rays::default());
    let unpainted = Mutex::new(Unpainted::default());

    let group = |index| view.shape.group(index, &header.grid, view.eye, bend);
    let displacement = renderer.displacement(view.camera)?;
    let displaced = match &displacement {
        Some(displacement) => {
            let pages = displaced_pages(renderer, view, displacement);
            DisplacedField::new(renderer.source, displacement, &pages)?
        }
        None => None,
    };

    let bounds = renderer.shared.bounds.get_or_init(|| BoundPyramid::new(renderer.source));
    let synthesis = renderer.synthesis()?;
    // What a worker looked up serves all of its tasks.
    let worker = |waits: bool| {
        let light = RadiancePages::new(renderer.source, &renderer.lit.radiance);
        Worker {
            march: PlaneMarch::new(renderer.source, &renderer.shared.turned, strides.clone(), bounds)
                .displaced(displaced.as_ref()),
            paint: Paint {
                painter: Painter {
                    sampler: LineSampler::new(if waits { light } else { light.without_waiting() }),
                    eye: view.eye,
                    spacing: header.grid.spacing,
                    height: above_ground,
                },
                air: AtmosphereLanes::new(&atmosphere, view.eye.z, header.height_range.high),
                sums: renderer.shared.edge_sums.lend(),
                span_renderer: SpanRenderer::new(renderer, view.eye),
            },
            profile: renderer.shared.profiles.lend(),
        }
    };

    // Returns pages that are missing: what is painted then is to be painted again.
    let paint = |Paint { painter, air, sums, span_renderer }: &mut Paint<'_>,
                 group: &PlaneGroup,
                 look: &mut GroupLook<'_>,
                 profile: &Profile| {
        let GroupLook { index, kept, cells, depths, bare_until } = look;
        let squares = view.shape.squares(*index);
        let angle = view.shape.plane_angle(*index, pixel_angle);
        air.face(group);
        let detail = synthesis.map(|synthesis| {
            let (eye, row, spacing) = (view.eye, row_table.least_row[0], header.grid.spacing);
            RowDetail::new(group, &DetailView { synthesis, eye, angle: pixel_angle, row, spacing })
        });
        let mut depths = depths.of(kept.filled.clone());
        let rows = RowFill {
            row_table: &row_table,
            first: kept.first,
            cells: &mut cells[kept.filled.clone()],
            scale,
            inverse: &mut *depths.inverse,
            detail,
        };

        let lights = Painting { painter, group, angle, detail: detail.as_ref() };
        rows.fill(renderer.isa, profile, lights, PlaneAir { air, squares: &squares }, sums)?;
        let missing = painter.sampler.take_missing();
        if missing.is_empty() {
            if let Some(span_renderer) = span_renderer {
                let (air, field) = (&*air, field(renderer, &row_table, kept));
                let (bare_until, row_table, squares) = (*bare_until, &row_table, &squares);
                let seen = spans::SeenGroup {
                    group,
                    profile,
                    bare_until,
                    span_bands: bands.span_bands(),
                    field,
                    row_table,
                    kept,
                    scale,
                    air,
                    squares,
                };
                span_renderer.put(&seen, &mut cells[kept.filled.clone()], depths.of(0..kept.filled.len()))?;
            }

            view.shape.finish(*index, depths.inverse, depths.tilts);
        }
        Result::Ok(missing)
    };

    farm.each_with(
        Stage::March,
        seen.tasks(per_task),
        || worker(false),
        |worker, _, task| {
            for mut look in task.looks() {
                let kept = look.kept;
                let (group, field) = (group(look.index), field(renderer, &row_table, kept));
                let Worker { march, paint: brush, profile } = worker;
                look.bare_until =
                    marching.time(|| march.see(renderer.isa, view.eye, &group, field, profile))?;
                let rows = kept.first..kept.first + kept.filled.len();
                let seen = Rays {
                    all: (rows.len() * LANES) as u64,
                    coarser: profile.rows_stood_in(&row_table.centres[rows]),
                };
                *rays.lock().unwrap_or_else(PoisonError::into_inner) += seen;
                if let Some(SteepHeights { bounds, step }) = brush.air.steep_heights() {
                    profile.refine(renderer.isa, bounds, step);
                }

                let missing = shading.time(|| paint(brush, &group, &mut look, profile))?;
                if !missing.is_empty() {
                    let mut unpainted = unpainted.lock().unwrap_or_else(PoisonError::into_inner);
                    unpainted.looks.push((look, profile.compact()));
                    for page in missing {
                        if unpainted.pages.insert(page) {
                            renderer.source.announce(page);
                        }
                    }
                }
            }

            Ok(())
        },
    )?;

    let Unpainted { looks, pages } = unpainted.into_inner().unwrap_or_else(PoisonError::into_inner);
    if !looks.is_empty() {
        renderer.source.bring(&Vec::from_iter(pages));
        farm.each_with(
            Stage::March,
            looks,
            || worker(true),
            |worker, _, (mut look, profile)| {
                let group = group(look.index);
                shading.time(|| paint(&mut worker.paint, &group, &mut look, &profile)).map(drop)
            },
        )?;
    }

    Ok(rays.into_inner().unwrap_or_else(PoisonError::into_inner))
}
