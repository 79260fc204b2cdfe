//! Collapsing leaves.

use criterion::Criterion;
use spinney::simplify::{Clusters, LeafCollapseOptions, collapse_leaves};

use crate::yew;

/// All collapses of a yew, and the clusters that they make.
pub(crate) fn bench(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("simplify");
    let plant = yew::plant();
    let stop_leaves = yew::species().stop_leaves.expect("the yew has one");
    let options = LeafCollapseOptions::to(stop_leaves);
    group.bench_function("collapse/48160", |bencher| {
        bencher.iter(|| collapse_leaves(plant.foliage(), &options));
    });
    let world = yew::world();
    let sequence = world.crowns[0].sequence();
    group.bench_function("clusters/48160", |bencher| {
        bencher.iter(|| Clusters::of(sequence));
    });
    group.finish();
}
