//! Pages: lookup, first touch, copying, encoding, and the step to the next coarser level.

mod terrain;

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};

use hedgehop::voxel::{MemPages, PageBuffer, PageId, PageSource, coarse_page};

const FINEST: PageId = PageId { level: 0, px: 1, py: 1 };
const COARSE: PageId = PageId { level: 1, px: 0, py: 0 };

fn pages(criterion: &mut Criterion) {
    let area = terrain::area(terrain::ROUGHNESS[1].1);
    let grid = area.header().grid;
    let buffer: PageBuffer = area.whole_page(FINEST).unwrap().expect("a whole grid").to_buffer();
    let bytes = buffer.encode(FINEST).bytes.len() as u64;

    let mut group = criterion.benchmark_group("page");
    group.bench_function("look up", |bencher| {
        bencher.iter(|| area.page(black_box(FINEST)).unwrap().map(|view| view.width));
    });
    group.throughput(Throughput::Bytes(bytes));

    group.bench_function("first touch", |bencher| {
        let fresh = || MemPages::from_bytes("terrain.hop", area.bytes()).unwrap();
        bencher.iter_batched_ref(
            fresh,
            |area| area.page(FINEST).unwrap().map(|view| view.width),
            BatchSize::PerIteration,
        );
    });

    group.bench_function("decode to a buffer", |bencher| {
        bencher.iter(|| area.whole_page(FINEST).unwrap().map(|view| view.to_buffer()));
    });
    group.bench_function("encode", |bencher| bencher.iter(|| black_box(&buffer).encode(FINEST)));
    group.throughput(Throughput::Elements(u64::from(terrain::SIDE).pow(2)));
    group.bench_function("coarsen", |bencher| {
        bencher.iter(|| coarse_page(&area, &grid, area.header().heights, black_box(COARSE)).unwrap());
    });
}

criterion_group! {
    name = all;
    config = Criterion::default().sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(1));
    targets = pages
}
criterion_main!(all);
