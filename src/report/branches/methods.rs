//! Every model beside the others, as Table 1 of [ZBMJLDC17](crate::references) has other people's.

use crate::report::{Cell, Column, Table};
use crate::run::MethodFound;

/// A row a method.
#[must_use]
pub fn method_table(found: &[MethodFound]) -> Table {
    let columns = [
        "off near, of 255",
        "off far, of 255",
        "worst step beyond, of 255",
        "host, B",
        "once a species, B",
        "once a tree, B",
        "frame near, ns",
        "frame far, ns",
        "trees far, 30 a second",
        "pixels in shadow near",
        "pixels in shadow far",
    ];
    let number = |value: f64| Cell::Number { value, digits: 3 };
    let count = |value: Option<u64>| value.map_or(Cell::Missing, Cell::Count);
    let row = |one: &MethodFound| {
        let storage = &one.storage;
        vec![
            Cell::Text(one.method.label()),
            number(one.detail[0]),
            number(one.detail[1]),
            one.worst_step
                .map_or(Cell::Missing, |(_, beyond)| number(beyond)),
            Cell::Count(storage.host_bytes),
            Cell::Count(storage.shared_bytes),
            Cell::Count(storage.instance_bytes + storage.instance_host_bytes),
            count(one.frame_ns[0]),
            count(one.frame_ns[1]),
            count(one.trees),
            count(one.shadow_pixels.map(|[near, _]| near)),
            count(one.shadow_pixels.map(|[_, far]| far)),
        ]
    };
    Table {
        columns: [Column::words("method")]
            .into_iter()
            .chain(columns.into_iter().map(Column::numbers))
            .collect(),
        rows: found.iter().map(row).collect(),
    }
}
