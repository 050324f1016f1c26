//! Writing the pages of all levels: made, or taken over where a build before made them of the same.

use super::census::Census;
use super::corridor::Tasks;
use super::page::{FromSources, MadePage, PageMaker, Project};
use super::steps::{Key, Made, PageKeys, Reused, Steps};
use super::workers::in_order;
use crate::error::Result;
use crate::progress::Observer;
use crate::voxel::{
    EarlierPage, EncodedPage, PageEntry, PageId, PageReadback, PageWriter, Shelf, sparse_page,
};

/// What is known of the steps of builds before, and the keys of this one's pages.
pub(super) type Trace<'a> = (&'a Steps, &'a PageKeys<'a>);

/// What was written so far.
#[derive(Debug, Default)]
pub(super) struct Written {
    /// Counts over its voxels.
    pub census: Census,
    /// Pages.
    pub pages: u64,
    /// Those of them that a build before made.
    pub reused: u64,
    /// Those of them that are not noted as steps: they may be set aside still.
    pending: Vec<Made>,
}

/// A page that is ready.
pub(super) enum Page {
    Made(EncodedPage),
    Reused(EarlierPage),
}

/// A page with all that goes with it.
struct Ready {
    page: Page,
    /// That of bare ground.
    bare: Option<Page>,
    census: Census,
    key: Option<Key>,
}

impl Page {
    pub fn id(&self) -> PageId {
        match self {
            Self::Made(page) => page.id,
            Self::Reused(page) => page.id,
        }
    }

    /// Appends it to what was written.
    pub fn append_to(self, writer: &mut PageWriter) -> Result<()> {
        match self {
            Self::Made(page) => writer.append(&page),
            Self::Reused(page) => writer.append_earlier(&page),
        }
    }

    fn put_on(self, shelf: &mut Shelf<'_>) -> Result<()> {
        match self {
            Self::Made(page) => shelf.take(&page),
            Self::Reused(page) => shelf.take_earlier(page),
        }
    }
}

/// Writes the pages of all levels; each coarser one is made of the finer ones below it, as far as these are stored.
pub(super) fn write_pages(
    project: &Project<'_>,
    threads: usize,
    trace: Option<Trace<'_>>,
    writer: &mut PageWriter,
    written: &mut Written,
    observer: &dyn Observer,
) -> Result<()> {
    let stages = [("voxels", 0..1), ("levels", 1..project.grid.level_count())];
    for (stage, levels) in stages {
        observer.begin(stage, levels.clone().map(|level| project.stored.count(level)).sum(), "pages");
        for level in levels {
            let finer = writer.readback();
            let mut shelf = Shelf::new(writer)?;
            let tasks = project.stored.tasks(level);
            write_level(project, (tasks, threads), (trace, &finer), &mut shelf, written, observer)?;
            shelf.empty()?;
            written.note(trace, &finer)?;
        }
        observer.end();
    }
    Ok(())
}

/// Writes the pages of one level, page by page.
fn write_level(
    project: &Project<'_>,
    (tasks, threads): (Tasks, usize),
    (trace, finer): (Option<Trace<'_>>, &PageReadback),
    shelf: &mut Shelf<'_>,
    written: &mut Written,
    observer: &dyn Observer,
) -> Result<()> {
    in_order(
        tasks.count(),
        threads,
        observer,
        || (PageMaker::new(project), Vec::new()),
        |(maker, scratch), task| {
            let id = tasks.id(task);
            let key = trace.map(|(_, keys)| keys.of(id, finer));
            let known =
                trace.zip(key).and_then(|((steps, _), key)| steps.page(&project.grid, id, key, scratch));
            if let Some(Reused { page, bare, census }) = known {
                let (page, bare) = (Page::Reused(page), bare.map(Page::Reused));
                return Ok(Ready { page, bare, census, key });
            }
            let MadePage { page, bare, census } = match id.level {
                0 => maker.make(id)?,
                _ => {
                    let mut sources = FromSources { maker };
                    let page = sparse_page(finer, &mut sources, &project.grid, project.code, id)?;
                    let census = Census::of_finest(&page, id, project.stored);
                    MadePage { page, bare: None, census }
                }
            };
            let census = census.with_codes_of(&page).with_codes_of_bare(bare.as_ref(), project.shared);
            let (page, bare) =
                (Page::Made(page.encode(id)), bare.map(|bare| Page::Made(bare.encode(id.bare()))));
            Ok(Ready { page, bare, census, key })
        },
        |_, ready: Ready| {
            written.take(&ready);
            ready.page.put_on(shelf)?;
            ready.bare.map_or(Ok(()), |bare| bare.put_on(shelf))?;
            observer.advance(1);
            // The shelf passes pages on band by band.
            match written.pending.first() {
                Some(first) if finer.entry(first.id).is_some() => written.note(trace, finer),
                _ => Ok(()),
            }
        },
    )
}

impl Written {
    fn take(&mut self, ready: &Ready) {
        self.census.add(&ready.census);
        self.pages += 1;
        self.reused += u64::from(matches!(ready.page, Page::Reused(_)));
        let Some(key) = ready.key else { return };
        let made = |page: &Page, census, has_bare| Made {
            id: page.id(),
            entry: PageEntry::default(),
            key,
            census,
            has_bare,
        };
        self.pending.push(made(&ready.page, ready.census, ready.bare.is_some()));
        self.pending.extend(ready.bare.iter().map(|bare| made(bare, Census::default(), false)));
    }

    /// Notes the steps of pages that have their place in the file by now.
    fn note(&mut self, trace: Option<Trace<'_>>, written: &PageReadback) -> Result<()> {
        let Some((steps, _)) = trace else { return Ok(()) };
        let mut noted = Vec::new();
        self.pending.retain(|made| {
            let entry = written.entry(made.id);
            noted.extend(entry.map(|entry| Made { entry, ..*made }));
            entry.is_none()
        });
        steps.made(&noted)
    }
}
