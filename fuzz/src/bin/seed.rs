//! Writes the seed corpus and the words of each language: `TARGET/…` and `TARGET.dict` in the folder
//! that is named, or in `corpus/`.

use std::path::{Path, PathBuf};

fn main() -> std::io::Result<()> {
    let root = std::env::args_os().nth(1).map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus"),
        PathBuf::from,
    );
    for (target, _) in spinney_fuzz::TARGETS {
        let folder = root.join(target);
        std::fs::create_dir_all(&folder)?;
        let seeds = spinney_fuzz::seeds(target);
        println!("{target}: {} seeds", seeds.len());
        for (name, bytes) in seeds {
            std::fs::write(folder.join(name), bytes)?;
        }
        let words = spinney_fuzz::words(target);
        let quoted = |word: &String| {
            let bytes = word.bytes().map(|byte| match byte {
                b'"' | b'\\' => format!("\\x{byte:02x}"),
                _ => char::from(byte).to_string(),
            });
            format!("\"{}\"\n", bytes.collect::<String>())
        };
        let dictionary: String = words.iter().map(quoted).collect();
        std::fs::write(root.join(format!("{target}.dict")), dictionary)?;
    }
    Ok(())
}
