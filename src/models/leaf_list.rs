//! A list of visible leaf records, drawn as one.

use super::format::LeafBytes;
use super::surface::Surface;
use super::{Crown, Records};
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Device, GpuError, IndirectRecord, Queue, Residency, Step,
    Usage,
};
use crate::math::index_u32;

/// The records that an instance shows, and how many they are.
///
/// In host memory writing it costs no bus, and every draw pulls it; on the device a change sends the
/// whole list and its length, 4 bytes. Compact records are drawn cluster by cluster: then a change
/// sends the arguments of all these draws, 20 bytes each.
#[derive(Debug)]
pub(super) struct LeafList {
    records: BufferId,
    arguments: BufferId,
    number: u32,
    causes: [Cause; 2],
    pub(super) steps: Vec<Step>,
    /// What lies in host memory.
    pub(super) host_bytes: u64,
}

impl LeafList {
    /// Makes the list of an instance with its first leaves.
    pub(super) fn create(
        device: &mut Device,
        (crown, bytes): (&Crown, &LeafBytes),
        surface: &Surface,
        residency: Residency,
        number: u32,
        leaves: &[u32],
    ) -> Result<Self, GpuError> {
        let mut buffer = |label, size, usage| {
            device.create_buffer(&BufferDescriptor {
                label,
                size,
                usage,
                residency,
            })
        };
        let (label, first, causes) = match residency {
            Residency::Host => {
                let host = Cause::of("host");
                ("leaf list arguments", host, [host; 2])
            }
            Residency::Device => {
                let causes = [Cause::of("index-list"), Cause::of("draw-count")];
                ("draw arguments", Cause::of("records"), causes)
            }
        };
        let (room, draws) = (Self::room(crown, bytes), Self::draws(crown, bytes));
        let records = buffer("leaf list", room, Usage::INDEX)?;
        let size = bytes.argument_stride() * u64::from(draws);
        let arguments = buffer(label, size, Usage::INDIRECT)?;
        let list = Self {
            records,
            arguments,
            number,
            causes,
            host_bytes: match residency {
                Residency::Host => room + size,
                Residency::Device => 0,
            },
            steps: surface.draw_records(records, arguments, draws),
        };
        let mut queue = device.queue();
        queue.write(records, 0, &bytes.records(leaves.iter().copied()), first)?;
        queue.write(
            arguments,
            0,
            &list.argument_bytes(crown, bytes, leaves),
            first,
        )?;
        Ok(list)
    }

    /// Bytes of an instance, on the device or on the host.
    pub(super) fn size(crown: &Crown, bytes: &LeafBytes) -> u64 {
        let draws = u64::from(Self::draws(crown, bytes));
        Self::room(crown, bytes) + bytes.argument_stride() * draws
    }

    /// Bytes of all the records that there may be.
    fn room(crown: &Crown, bytes: &LeafBytes) -> u64 {
        bytes.stride() * u64::from(crown.sequence().original_count())
    }

    /// How many draws show the list.
    fn draws(crown: &Crown, bytes: &LeafBytes) -> u32 {
        match bytes.format.records {
            Records::Wide => 1,
            Records::Compact => crown.sequence().root_count(),
        }
    }

    /// The arguments of all draws for these leaves, which come cluster by cluster.
    fn argument_bytes(&self, crown: &Crown, bytes: &LeafBytes, leaves: &[u32]) -> Vec<u8> {
        let draws = Self::draws(crown, bytes);
        let cluster_of_leaf = &crown.clusters().cluster_of_leaf;
        let mut first = 0;
        let mut arguments = Vec::new();
        for cluster in 0..draws {
            let rest = leaves[first..].iter();
            let count = rest
                .take_while(|&&leaf| draws == 1 || cluster_of_leaf[leaf as usize] == cluster)
                .count();
            let record = IndirectRecord {
                corner_count: 4 * index_u32(count),
                instances: 1,
                first_corner: 4 * index_u32(first),
                instance: self.number,
            };
            arguments.extend(bytes.argument_bytes(record, cluster));
            first += count;
        }
        arguments
    }

    /// What replacing the leaves uploads of a list on the device.
    pub(super) fn price(crown: &Crown, bytes: &LeafBytes, leaves: u32) -> u64 {
        let arguments = match bytes.format.records {
            Records::Wide => 4,
            Records::Compact => bytes.argument_stride() * u64::from(Self::draws(crown, bytes)),
        };
        bytes.stride() * u64::from(leaves) + arguments
    }

    /// Replaces the leaves.
    pub(super) fn write(
        &self,
        queue: &mut Queue<'_>,
        (crown, bytes): (&Crown, &LeafBytes),
        leaves: &[u32],
    ) -> Result<(), GpuError> {
        let records = bytes.records(leaves.iter().copied());
        queue.write(self.records, 0, &records, self.causes[0])?;
        let mut arguments = self.argument_bytes(crown, bytes, leaves);
        if bytes.format.records == Records::Wide {
            // The list always begins at its buffer's start.
            arguments.truncate(4);
        }
        queue.write(self.arguments, 0, &arguments, self.causes[1])
    }
}
