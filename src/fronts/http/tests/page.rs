//! The embedded page: complete, and without anything that its content policy would forbid.

use std::fs;
use std::path::{Path, PathBuf};

use super::client::{Running, Station};

#[tokio::test]
async fn every_file_of_the_page_is_served_as_it_is() {
    let server = Running::start(&Station::new()).await;
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("page");
    let mut served = 0;
    for file in files(&page) {
        let name = file.strip_prefix(&page).unwrap().to_str().unwrap().replace('\\', "/");
        let media_type = match file.extension().and_then(|e| e.to_str()) {
            Some("js") => "text/javascript; charset=utf-8",
            Some("css") => "text/css; charset=utf-8",
            Some("svg") => "image/svg+xml",
            Some("html") => "text/html; charset=utf-8",
            // Licence and provenance of third-party files.
            _ => continue,
        };
        let path = if name == "index.html" { "/".to_owned() } else { format!("/assets/{name}") };
        let answer = server.get(&path).await;
        assert_eq!(answer.status, 200, "{path}");
        assert_eq!(answer.header("content-type"), Some(media_type), "{path}");
        assert!(answer.body == fs::read(&file).unwrap(), "{path} differs from its source");
        served += 1;
    }
    assert!(served >= 10, "only {served} files found in {}", page.display());
    server.end().await;
}

#[tokio::test]
async fn the_page_asks_nobody_else_and_has_nothing_inline() {
    let server = Running::start(&Station::new()).await;
    let html = String::from_utf8(server.get("/").await.body).unwrap();
    assert!(!html.contains("://"), "an address of another host");
    assert!(!html.contains("<style") && !html.contains(" style="), "inline style");
    let mut linked = 0;
    for tag in html.split('<') {
        assert!(!tag.contains(" on"), "inline handler: {tag}");
        if tag.starts_with("script") {
            assert!(tag.contains(" src=\"/assets/") && tag.trim_end().ends_with('>'), "{tag}");
        }
        for key in [" src=\"", " href=\"/"] {
            if let Some((_, rest)) = tag.split_once(key) {
                let path = rest.split('"').next().unwrap();
                let path = format!("/{}", path.trim_start_matches('/'));
                assert_eq!(server.get(&path).await.status, 200, "{path}");
                linked += 1;
            }
        }
    }
    assert!(linked >= 5, "only {linked} files linked");
    server.end().await;
}

#[tokio::test]
async fn every_import_of_a_module_exists() {
    let server = Running::start(&Station::new()).await;
    let (mut open, mut seen) = (vec!["main.js".to_owned()], Vec::new());
    while let Some(name) = open.pop() {
        if seen.contains(&name) {
            continue;
        }
        let answer = server.get(&format!("/assets/{name}")).await;
        assert_eq!(answer.status, 200, "{name}");
        let text = String::from_utf8(answer.body).unwrap();
        let imports = text.lines().filter_map(|line| {
            let path = line.starts_with("import ").then_some(line)?.split_once("from \"./")?.1;
            path.strip_suffix("\";").map(str::to_owned)
        });
        open.extend(imports);
        seen.push(name);
    }
    assert!(seen.len() >= 10, "{seen:?}");
    server.end().await;
}

fn files(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] })
        .collect()
}
