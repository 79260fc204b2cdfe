//! Tiny PNG files of every kind of pixel, with deflate streams that store.

/// An image of each colour type and depth, plain and interlaced.
pub(super) fn images() -> Vec<(String, Vec<u8>)> {
    let kinds = [
        ("grey", 0, &[1, 2, 4, 8, 16][..], 1),
        ("rgb", 2, &[8, 16][..], 3),
        ("indexed", 3, &[1, 2, 4, 8][..], 1),
        ("grey_alpha", 4, &[8, 16][..], 2),
        ("rgba", 6, &[8, 16][..], 4),
    ];
    let mut seeds = Vec::new();
    for (name, colour, depths, channels) in kinds {
        for &depth in depths {
            for interlaced in [0, 1] {
                let bits = usize::from(depth) * channels;
                let palette = 3 << depth.min(4);
                let file = png(5, 3, [depth, colour, 0, 0, interlaced], bits, palette);
                seeds.push((format!("{name}_{depth}_{interlaced}.png"), file));
            }
        }
    }
    let last = seeds.last().expect("not empty").1.clone();
    // The decoder expands every entry, and this ends within one.
    let torn = png(5, 3, [4, 3, 0, 0, 0], 4, 46);
    seeds.push(("torn_palette.png".to_owned(), torn));
    seeds.push(("cut.png".to_owned(), last[..last.len() / 2].to_vec()));
    seeds
}

/// A file of the five bytes that end a header, pixels of so many bits, and a palette if its kind has
/// one.
fn png(width: u8, height: u8, kind: [u8; 5], bits: usize, palette_bytes: usize) -> Vec<u8> {
    let mut header = [
        u32::from(width).to_be_bytes(),
        u32::from(height).to_be_bytes(),
    ]
    .concat();
    let (width, height) = (usize::from(width), usize::from(height));
    header.extend(kind);
    let mut rows = Vec::new();
    if kind[4] == 0 {
        (0..height).for_each(|y| row(&mut rows, y, width, bits));
    } else {
        // The seven passes: offset and step of columns, then of rows.
        for [x, across, y, down] in [
            [0, 8, 0, 8],
            [4, 8, 0, 8],
            [0, 4, 4, 8],
            [2, 4, 0, 4],
            [0, 2, 2, 4],
            [1, 2, 0, 2],
            [0, 1, 1, 2],
        ] {
            let columns = (x..width).step_by(across).count();
            if columns > 0 {
                (y..height)
                    .step_by(down)
                    .for_each(|y| row(&mut rows, y, columns, bits));
            }
        }
    }
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    chunk(&mut file, b"IHDR", &header);
    if kind[1] == 3 {
        let palette: Vec<u8> = (0..48).map(|value: u8| value.wrapping_mul(37)).collect();
        chunk(&mut file, b"PLTE", &palette[..palette_bytes]);
        chunk(&mut file, b"tRNS", &[0, 128]);
    }
    chunk(&mut file, b"tEXt", b"a\0b");
    chunk(&mut file, b"IDAT", &stored(&rows));
    chunk(&mut file, b"IEND", &[]);
    file
}

/// A row with its filter: each row has another.
fn row(rows: &mut Vec<u8>, y: usize, columns: usize, bits: usize) {
    rows.push(u8::try_from(y % 5).expect("below 5"));
    let bytes = (columns * bits).div_ceil(8);
    rows.extend((0..bytes).map(|byte| u8::try_from(byte * 11 % 16).expect("below 16")));
}

/// A zlib stream of one stored block.
fn stored(bytes: &[u8]) -> Vec<u8> {
    let length = u16::try_from(bytes.len()).expect("tiny");
    let mut stream = vec![0x78, 1, 1];
    stream.extend(length.to_le_bytes());
    stream.extend((!length).to_le_bytes());
    stream.extend(bytes);
    let (a, b) = bytes.iter().fold((1_u32, 0), |(a, b), byte| {
        let a = (a + u32::from(*byte)) % 65_521;
        (a, (b + a) % 65_521)
    });
    stream.extend((b << 16 | a).to_be_bytes());
    stream
}

fn chunk(file: &mut Vec<u8>, kind: &[u8; 4], bytes: &[u8]) {
    file.extend(u32::try_from(bytes.len()).expect("tiny").to_be_bytes());
    let start = file.len();
    file.extend(kind);
    file.extend(bytes);
    let sum = !file[start..].iter().fold(!0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 * (crc & 1))
        })
    });
    file.extend(sum.to_be_bytes());
}
