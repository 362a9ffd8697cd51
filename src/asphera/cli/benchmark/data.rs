//! Curves and areas of a folder, for the comparison of methods.

use std::path::{Path, PathBuf};

use asphera_contour::benchmark::Drawing;
use asphera_contour::sampler::{BezierLine, borders};
use asphera_formats::drawing::{DrawnLine, read_dxf, read_svg};
use asphera_formats::mask;

use super::super::files::read;
use super::super::output::Failure;

/// The drawings and images of a folder by their names, .svg, .dxf and .png; all else there is passed over.
pub(super) fn drawings(folder: &Path) -> Result<Vec<(String, Drawing)>, Failure> {
    let name = folder.display();
    let cannot =
        |error: std::io::Error| -> Failure { format!("cannot read {name}: {error}").into() };
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .and_then(|entries| entries.map(|entry| entry.map(|entry| entry.path())).collect())
        .map_err(cannot)?;
    files.sort();
    let mut found = Vec::new();
    for file in files {
        if let Some(drawing) = drawing(&file)? {
            let name = file.file_name().map(|name| name.to_string_lossy().into_owned());
            found.push((name.unwrap_or_default(), drawing));
        }
    }
    if found.is_empty() {
        return Err(format!("--data {name}: expected .svg, .dxf or .png files, found none").into());
    }
    Ok(found)
}

fn drawing(file: &Path) -> Result<Option<Drawing>, Failure> {
    let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let name = file.display();
    let drawn = match ending.as_deref() {
        Some("svg") => read_svg(&read(file)?),
        Some("dxf") => read_dxf(&read(file)?),
        Some("png") => {
            let mask =
                mask::read(&read(file)?, false).map_err(|error| format!("{name}: {error}"))?;
            let lines = borders(&mask.set, mask.columns, mask.rows, 1.0);
            if lines.is_empty() {
                return Err(format!("{name}: expected a dark shape, found no dark pixel").into());
            }
            return Ok(Some(Drawing::of_borders(lines)));
        }
        _ => return Ok(None),
    };
    let drawn = drawn.map_err(|error| format!("{name}: {error}"))?;
    if drawn.is_empty() {
        return Err(format!("{name}: expected a path or a shape, found none").into());
    }
    let line = |DrawnLine { pieces, closed }| BezierLine { pieces, closed };
    Ok(Some(Drawing::of_lines(drawn.into_iter().map(line).collect())))
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::super::super::{Cli, Command};
    use super::super::{curves, regions};

    /// A folder with a drawn ring and a leaf of two curves.
    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let ring = r#"<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40">
            <circle cx="20" cy="20" r="15"/><circle cx="20" cy="20" r="7"/></svg>"#;
        let leaf = r#"<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40">
            <path d="M5 20 C 10 2 30 2 35 20 C 30 38 10 38 5 20 Z"/></svg>"#;
        std::fs::write(folder.path().join("ring.svg"), ring).unwrap();
        std::fs::write(folder.path().join("leaf.svg"), leaf).unwrap();
        std::fs::write(folder.path().join("notes.txt"), "not a curve").unwrap();
        folder
    }

    fn json(kind: &str, data: &str, more: &[&str]) -> Result<serde_json::Value, String> {
        let words = [&["asphera", "benchmark", kind, "--data", data], more].concat();
        let Command::Benchmark(args) = Cli::try_parse_from(words).unwrap().command else {
            panic!("another command")
        };
        let value = match kind {
            "curves" => curves::compared(&args).map(serde_json::to_value),
            _ => regions::compared(&args).map(serde_json::to_value),
        };
        value.map(Result::unwrap).map_err(|failure| failure.to_string())
    }

    #[test]
    fn curves_of_a_folder_are_compared() {
        let folder = folder();
        let data = folder.path().to_str().unwrap();
        let found = json("curves", data, &["--methods", "hnn-crust,crust", "--trials", "2"]);
        let found = found.unwrap();
        assert_eq!(found["data"], serde_json::json!(["leaf.svg", "ring.svg"]));
        assert_eq!(found["trials"], 4);
        let categories = found["categories"].as_array().unwrap();
        assert_eq!(categories.len(), 5);
        // Of ε = 0.3 on smooth curves every edge of both methods is right.
        let first = &categories[0];
        assert_eq!(first["category"], "non-uniform");
        for row in first["methods"].as_array().unwrap() {
            assert!(row["f"].as_f64().unwrap() > 0.99, "{row}");
            assert!(row["rms"].as_f64().unwrap() < 0.01, "{row}");
        }
        let refused = json("curves", data, &["--category", "sharp"]).unwrap_err();
        assert!(refused.contains("expected one of non-uniform"), "{refused}");
    }

    #[test]
    fn areas_of_a_folder_are_compared() {
        let folder = folder();
        let data = folder.path().to_str().unwrap();
        let found = json("regions", data, &["--methods", "alpha,auto"]).unwrap();
        let shapes = found["shapes"].as_array().unwrap();
        assert_eq!(
            (&shapes[0]["shape"], &shapes[1]["shape"]),
            (&"leaf.svg".into(), &"ring.svg".into())
        );
        for shape in shapes {
            // The ring keeps its hole, and the area is near the truth.
            assert_eq!(shape["methods"][0]["method"], "auto");
            assert!(shape["methods"][0]["l2"].as_f64().unwrap() < 0.06, "{shape}");
            assert!(shape["methods"][0]["topology"].as_f64().unwrap() > 0.9, "{shape}");
        }
        let empty = tempfile::tempdir().unwrap();
        let refused = json("regions", empty.path().to_str().unwrap(), &[]).unwrap_err();
        assert!(refused.contains("found none"), "{refused}");
        std::fs::write(empty.path().join("line.svg"), r#"<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm" viewBox="0 0 9 9"><path d="M0 0 L5 5"/></svg>"#).unwrap();
        let refused = json("regions", empty.path().to_str().unwrap(), &[]).unwrap_err();
        assert!(refused.contains("line.svg: expected closed lines"), "{refused}");
    }
}
