//! Writing the pages of all levels: made, or taken over where a build before made them of the same.

use super::build_cache::{Aside, BuildCache, Key, MadeRecord, Reused};
use super::corridor::Tasks;
use super::counts::PageCounts;
use super::page::{FromSources, MadePage, PageMaker, Project};
use super::workers::in_order;
use crate::page_keys::PageKeys;
use hedgehop::voxel::{
    EarlierPage, EncodedPage, PageEntry, PageId, PageReadback, PageWriter, Shelf, sparse_page,
};
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Steps of builds before, and the keys of this one's pages.
pub(super) type Trace<'a> = (&'a BuildCache, &'a PageKeys<'a>);

/// Pages that were written so far.
#[derive(Debug, Default)]
pub(super) struct Written {
    /// Counts over its voxels.
    pub counts: PageCounts,
    /// Pages.
    pub pages: u64,
    /// Pages of these that a build before made.
    pub reused: u64,
    /// Pages of these that are not noted as steps: they may be set aside still.
    pending: Vec<MadeRecord>,
}

/// A page that is ready.
pub(super) enum Page {
    Made(EncodedPage),
    Reused(EarlierPage),
}

/// A page with all that goes with it.
struct Ready {
    page: Page,
    /// Page of bare ground.
    bare: Option<Page>,
    counts: PageCounts,
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

    /// Puts the page on the shelf; returns its entry if it was set aside.
    fn put_on(self, shelf: &mut Shelf<'_>) -> Result<Option<PageEntry>> {
        match self {
            Self::Made(page) => shelf.take(&page).map(Some),
            Self::Reused(page) => shelf.take_earlier(page).map(|()| None),
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
    let run = LevelRun { project, threads, trace, observer };
    let stages = [("voxels", 0..1), ("levels", 1..project.grid.level_count())];
    for (stage, levels) in stages {
        observer.begin(stage, levels.clone().map(|level| project.stored.count(level)).sum(), "pages");
        for level in levels {
            let finer = writer.readback();
            let mut shelf = if trace.is_some() { Shelf::named(writer) } else { Shelf::new(writer) }?;
            let tasks = project.stored.tasks(level);
            let done = run.write(tasks, &finer, &mut shelf, written);
            // What waits for its place is kept as well, if somebody stops the build.
            if matches!(done, Ok(()) | Err(Error::Interrupted(_))) {
                shelf.empty()?;
                written.note(trace, &finer)?;
            }
            done?;
        }
        observer.end();
    }
    Ok(())
}

/// Run that writes the levels of a build.
struct LevelRun<'a> {
    /// The build.
    project: &'a Project<'a>,
    /// Threads that make pages.
    threads: usize,
    /// Steps of builds before; `None`: none are kept.
    trace: Option<Trace<'a>>,
    /// Observer of the progress.
    observer: &'a dyn Observer,
}

impl LevelRun<'_> {
    /// Writes the pages of one level, page by page.
    fn write(
        &self,
        tasks: Tasks,
        finer: &PageReadback,
        shelf: &mut Shelf<'_>,
        written: &mut Written,
    ) -> Result<()> {
        let Self { project, threads, trace, observer } = *self;
        let mut aside = shelf.aside().map(Aside::of).transpose()?;
        in_order(
            tasks.count(),
            threads,
            observer,
            || (PageMaker::new(project), Vec::new()),
            |(maker, scratch), task| {
                let id = tasks.id(task);
                let key = trace.map(|(_, keys)| keys.of(id, finer));
                let known =
                    trace.zip(key).and_then(|((cache, _), key)| cache.page(&project.grid, id, key, scratch));
                if let Some(Reused { page, bare, counts }) = known {
                    let (page, bare) = (Page::Reused(page), bare.map(Page::Reused));
                    return Ok(Ready { page, bare, counts, key });
                }

                let MadePage { page, bare, counts } = match id.level {
                    0 => maker.make(id)?,
                    _ => {
                        let mut sources = FromSources { maker };
                        let page = sparse_page(finer, &mut sources, &project.grid, project.code, id)?;
                        let counts = PageCounts::of_finest(&page, id, project.stored);
                        MadePage { page, bare: None, counts }
                    }
                };

                let counts = counts.with_codes_of(&page).with_codes_of_bare(bare.as_ref(), project.shared);
                let (page, bare) =
                    (Page::Made(page.encode(id)), bare.map(|bare| Page::Made(bare.encode(id.bare()))));

                Ok(Ready { page, bare, counts, key })
            },
            |_, ready: Ready| {
                let made = written.take(&ready);
                let places = [
                    ready.page.put_on(shelf)?,
                    ready.bare.map(|bare| bare.put_on(shelf)).transpose()?.flatten(),
                ];
                observer.advance(1);

                // The shelf passes pages on band by band.
                if written.pending.first().is_some_and(|first| finer.entry(first.id).is_some()) {
                    written.note(trace, finer)?;
                    aside.as_mut().map_or(Ok(()), Aside::clear)?;
                }

                let set_aside = made
                    .into_iter()
                    .zip(places)
                    .filter_map(|(made, entry)| Some(MadeRecord { entry: entry?, ..made }));
                aside.as_mut().map_or(Ok(()), |aside| aside.note(set_aside))
            },
        )
    }
}

impl Written {
    /// Counts a page, and that of bare ground. What is to be noted of them once they have their place.
    fn take(&mut self, ready: &Ready) -> Vec<MadeRecord> {
        self.counts.add(&ready.counts);
        self.pages += 1;
        self.reused += u64::from(matches!(ready.page, Page::Reused(_)));
        let Some(key) = ready.key else { return Vec::new() };
        let made = |page: &Page, counts, has_bare| MadeRecord {
            id: page.id(),
            entry: PageEntry::default(),
            key,
            counts,
            has_bare,
        };
        let mut all = vec![made(&ready.page, ready.counts, ready.bare.is_some())];
        all.extend(ready.bare.iter().map(|bare| made(bare, PageCounts::default(), false)));
        self.pending.extend(&all);
        all
    }

    /// Notes the steps of pages that have their place in the file by now.
    fn note(&mut self, trace: Option<Trace<'_>>, written: &PageReadback) -> Result<()> {
        let Some((cache, _)) = trace else { return Ok(()) };
        let mut noted = Vec::new();
        self.pending.retain(|made| {
            let entry = written.entry(made.id);
            noted.extend(entry.map(|entry| MadeRecord { entry, ..*made }));
            entry.is_none()
        });
        cache.made(&noted)
    }
}
