//! EXR files.

use std::path::Path;

use spinney::report::{Channel, ImageFile, Layer, encode_exr};

/// EXR files: what is read and can be written comes back the same.
pub fn exr(bytes: &[u8]) {
    match ImageFile::from_bytes(Path::new("fuzz.exr"), bytes) {
        Ok(ImageFile::Exr(channels)) => returns(&channels),
        Ok(_) => {}
        Err(error) => _ = error.to_string(),
    }
}

fn returns(channels: &[Channel]) {
    let Some(first) = channels.first() else {
        return;
    };
    let layer = |channel: &Channel| Layer {
        name: channel.name.clone(),
        samples: channel.samples.clone(),
    };
    let [width, height] = first.size;
    // Parts of different sizes, and names that are not plain, are for others to write.
    let Ok(file) = encode_exr(width, height, channels.iter().map(layer).collect()) else {
        return;
    };
    let again = ImageFile::from_bytes(Path::new("again.exr"), &file);
    let Ok(ImageFile::Exr(again)) = again else {
        panic!("written, and refused: {again:?}");
    };
    assert_eq!(again.len(), channels.len());
    for (one, other) in again.iter().zip(channels) {
        assert_eq!((&one.name, one.size), (&other.name, other.size));
    }
}
