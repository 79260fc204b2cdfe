//! The target `wood`: fuzzed by `cargo fuzz run wood`; built without a fuzzer it replays the files that
//! are named.
#![cfg_attr(fuzzing, no_main)]

#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| spinney_fuzz::wood(bytes));

#[cfg(not(fuzzing))]
fn main() {
    spinney_fuzz::replay(spinney_fuzz::wood);
}
