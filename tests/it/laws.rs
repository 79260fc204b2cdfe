//! Laws of a bare device, beside those of [`spinney::testkit::laws`] that every model keeps.

use spinney::gpu::Device;
use spinney::testkit::laws::conservation_of;
use spinney::testkit::{Change, Contents, Counted, Violation};

/// Conservation for a device that has no model: the recorded changes, replayed into zeros, give what
/// it holds, textures too, and the lengths of the writes add up to `payload`.
pub(crate) fn check_conservation(device: &Device, payload: u64) -> Result<(), Violation> {
    let contents = Contents::of(device);
    let log = contents.log(device, 0..).expect("recorded from the start");
    let writes = log
        .iter()
        .filter(|change| matches!(change, Change::Write { .. }));
    let counted = Counted {
        // Which writes went together is not known here.
        transfers: writes.count() as u64,
        payload_bytes: payload,
        itemised: Vec::new(),
    };
    conservation_of(&contents.resources(device), &log, Some(&counted))
}
