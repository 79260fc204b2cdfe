//! What the laws ask of one of our own devices.

use super::contents::Contents;
use super::device::{Change, Counted, Itemised, Reads, Resource};
use crate::gpu::{Device, Ledger, ResourceId, Share, Stream};
use crate::math::index_usize;

/// The contents of a device by their numbers, and all that was counted since it began to record.
#[derive(Debug, Clone)]
pub(super) struct Watch {
    contents: Contents,
    counted: Ledger,
}

impl Watch {
    /// Watches a device on which everything is created.
    pub(super) fn of(device: &Device) -> Self {
        Self {
            contents: Contents::of(device),
            counted: Ledger::default(),
        }
    }

    /// Adds what was taken from the device's ledger.
    pub(super) fn add(&mut self, taken: Ledger) {
        self.counted.add(&taken);
        self.counted.transfers.extend(taken.transfers);
    }

    pub(super) fn resources<'a>(&'a self, device: &'a Device) -> Vec<Resource<'a>> {
        self.contents.resources(device)
    }

    /// What was read since the device began to track that.
    pub(super) fn reads(&self, device: &Device) -> Reads {
        let reads = device.reads().expect("tracked just before");
        let mut ranges = Vec::new();
        for buffer in reads.buffers() {
            let number = self.contents.number(ResourceId::Buffer(buffer));
            // Also what is bound and not read at all counts as known.
            ranges.push((number, 0..0));
            let read = reads.ranges(buffer).into_iter();
            ranges.extend(read.map(|r| (number, index_usize(r.start)..index_usize(r.end))));
        }
        let mut primitives: Vec<_> = reads.fetched.iter().collect();
        primitives.sort();
        let fetched = primitives.into_iter().map(|primitive| {
            let key = [primitive.group, primitive.instance, primitive.vertex];
            let key = key.into_iter().flat_map(u32::to_le_bytes);
            key.chain(primitive.bytes.iter().copied()).collect()
        });
        Reads {
            ranges,
            fetched: fetched.collect(),
        }
    }

    /// Overwrites bytes of a buffer behind the back of all counters.
    pub(super) fn overwrite(&self, device: &mut Device, resource: usize, at: usize, bytes: &[u8]) {
        let Some(ResourceId::Buffer(buffer)) = self.contents.id(resource) else {
            return;
        };
        // The device knows fillers only: runs of one byte.
        let mut start = 0;
        for run in bytes.chunk_by(|a, b| a == b) {
            let from = (at + start) as u64;
            let range = from..from + run.len() as u64;
            device
                .poison(buffer, range, run[0])
                .expect("within the buffer");
            start += run.len();
        }
    }

    pub(super) fn log<'a>(&'a self, device: &'a Device) -> Option<Vec<Change<'a>>> {
        self.contents.log(device, self.transfers_of_writes())
    }

    /// The number of the transfer that brought each recorded write: of those that were counted, as
    /// many as the ledger says that the transfer had ranges; of others, one each.
    fn transfers_of_writes(&self) -> impl Iterator<Item = u64> + '_ {
        let transfers = self.counted.transfers.iter();
        let uploads = transfers.filter(|transfer| transfer.stream == Stream::Upload);
        let ranges = uploads.map(|transfer| index_usize(transfer.ranges));
        let ranges = ranges.chain(std::iter::repeat(1));
        (0..)
            .zip(ranges)
            .flat_map(|(number, ranges)| std::iter::repeat_n(number, ranges))
    }

    /// The uploads that were counted, as totals and itemised. Shares are of all streams; those that
    /// are no uploads are taken off.
    pub(super) fn counted(&self) -> Counted {
        let ledger = &self.counted;
        let (upload, fetch, readback) = (&ledger.upload, &ledger.fetch, &ledger.readback);
        let others = [
            fetch.transfers + readback.transfers,
            fetch.payload_bytes + readback.payload_bytes,
        ];
        let shares = |by, shares: &mut dyn Iterator<Item = &Share>| {
            let sums = shares.fold([0, 0], |[transfers, bytes], share| {
                [transfers + share.transfers, bytes + share.payload_bytes]
            });
            Itemised {
                by,
                transfers: sums[0].saturating_sub(others[0]),
                payload_bytes: sums[1].saturating_sub(others[1]),
            }
        };
        let transfers = ledger.transfers.iter();
        let uploads = transfers.filter(|transfer| transfer.stream == Stream::Upload);
        let list = uploads.fold([0, 0], |[count, bytes], transfer| {
            [count + 1, bytes + transfer.payload_bytes]
        });
        Counted {
            transfers: upload.transfers,
            payload_bytes: upload.payload_bytes,
            itemised: vec![
                Itemised {
                    by: "by transfer",
                    transfers: list[0],
                    payload_bytes: list[1],
                },
                shares("by cause", &mut ledger.by_cause.values()),
                shares("by buffer", &mut ledger.by_buffer.values()),
            ],
        }
    }
}
