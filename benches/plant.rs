//! Growing.

use criterion::Criterion;

use crate::yew;

/// A yew from its species.
pub(crate) fn bench(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("plant");
    let species = yew::species();
    group.bench_function("grow/48160", |bencher| {
        bencher.iter(|| spinney::plant::grow(&species, 1));
    });
    let plant = yew::plant();
    group.bench_function("digest/48160", |bencher| bencher.iter(|| plant.digest()));
    group.finish();
}
