//! Recorded traces.

use spinney::testkit::trace::check_trace;

/// Recorded traces: what is checked is told, and the same when it is checked again.
pub fn trace(bytes: &[u8]) {
    match check_trace("fuzz.jsonl", bytes) {
        Ok(report) => {
            for law in &report.laws {
                assert!(law.broken <= law.checked, "{law:?}");
                assert_eq!(law.broken > 0, law.first.is_some(), "{law:?}");
                if let Some((line, violation)) = &law.first {
                    assert!(*line > 1, "{violation}");
                }
            }
            let again = check_trace("fuzz.jsonl", bytes);
            assert_eq!(again.as_ref(), Ok(&report));
        }
        Err(error) => _ = error.to_string(),
    }
}
