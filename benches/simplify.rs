//! Collapsing leaves and trunks.

use criterion::Criterion;
use spinney::simplify::{
    Clusters, LeafCollapseOptions, VertexCollapseOptions, collapse_leaves, collapse_vertices,
    strips_of,
};

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
    let mesh = plant.trunk().expect("the yew has one");
    let options = VertexCollapseOptions::usual(mesh);
    group.bench_function("trunk/34205", |bencher| {
        bencher.iter(|| {
            let collapses = collapse_vertices(mesh, options);
            strips_of(collapses.triangles(), |triangle| {
                collapses.shows(triangle, 0)
            })
        });
    });
    group.finish();
}
