//! The rules for documents that a machine can check: size, length of sentences, links, and what a command prints.
//!
//! Code blocks and headings are no sentences. A cell of a table and an item of a list begin and end one, so that no
//! sentence runs on from one to the next.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

use std::path::{Path, PathBuf};
use std::process::Command;

use asphera_tests::{asphera, root};

/// Largest size in bytes of what people open first, and of a page of docs/.
const README_BYTES: usize = 6_000;
const ARCHITECTURE_BYTES: usize = 10_000;
const PAGE_BYTES: usize = 8_000;
/// Most words of a sentence.
const MOST_WORDS: usize = 30;
/// Most words of a sentence on average. Cells of tables are no sentences to average over.
const MEAN_WORDS: f64 = 15.0;

#[test]
fn documents_are_short() {
    let mut wrong = Vec::new();
    for (name, text) in read(&for_users()) {
        let most = match &name[..] {
            "README.md" => README_BYTES,
            "ARCHITECTURE.md" => ARCHITECTURE_BYTES,
            _ => PAGE_BYTES,
        };
        if text.len() > most {
            wrong.push(format!("{name}: {} bytes, at most {most}", text.len()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn sentences_are_short() {
    let mut wrong = Vec::new();
    let (users, mut all) = (for_users(), Vec::new());
    collect(&root(), &mut all);
    assert!(users.iter().all(|path| all.contains(path)));
    for (name, text) in read(&all) {
        let sentences = sentences(&text);
        for sentence in sentences.iter().filter(|sentence| sentence.words > MOST_WORDS) {
            let Sentence { line, words, start, .. } = sentence;
            wrong.push(format!("{name}:{line}: {words} words, at most {MOST_WORDS}: {start} …"));
        }
        let mean = mean_words(&sentences);
        if mean > MEAN_WORDS && users.contains(&root().join(&name)) {
            wrong.push(format!("{name}: {mean:.1} words a sentence, at most {MEAN_WORDS}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn links_lead_to_files_and_headings_that_exist() {
    let mut wrong = Vec::new();
    let (mut all, mut links) = (Vec::new(), 0);
    collect(&root(), &mut all);
    for path in &all {
        let text = std::fs::read_to_string(path).unwrap();
        for (line, target) in targets(&text) {
            links += 1;
            let (file, heading) = target.split_once('#').unwrap_or((target, ""));
            let to = if file.is_empty() { path.clone() } else { path.with_file_name(file) };
            let found = to.exists() && (heading.is_empty() || has_heading(&to, heading));
            if !found {
                wrong.push(format!("{}:{line}: no {target}", path.display()));
            }
        }
    }
    assert!(links > 50, "only {links} links in {} documents", all.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The README quotes lines of the output of a command. They are there, in this order.
#[test]
fn the_command_of_the_readme_prints_what_the_readme_says() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let mut quoted = readme.lines().skip_while(|line| !line.starts_with("    $ asphera "));
    let command = quoted.next().unwrap().trim_start_matches("    $ asphera ");
    let lines: Vec<&str> = quoted.map_while(|line| line.strip_prefix("    ")).collect();
    assert!(lines.len() > 5, "{lines:?}");
    let folder = tempfile::tempdir().unwrap();
    let output =
        Command::new(asphera()).args(command.split(' ')).current_dir(&folder).output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    let mut rest = printed.lines();
    for line in lines {
        assert!(rest.any(|found| found == line), "not there, or not here: {line}\n{printed}");
    }
    assert!(output.status.success(), "{printed}");
}

#[test]
fn long_sentences_and_dead_links_are_found() {
    let long = "word ".repeat(31);
    let text = format!(
        "# A heading {long}\n\nOne two `three {long}`. Four\nfive [six]({long}) seven.\n\n    code {long}\n\n```\n{long}\n```\n\n\
         - {long}\n- an item\n  of five words.\n\n| a cell | {long} |\n|---|---|\n\n1. {long}\n"
    );
    let found = sentences(&text);
    let places: Vec<(usize, usize)> = found.iter().map(|found| (found.line, found.words)).collect();
    assert_eq!(
        places,
        [(3, 3), (3, 4), (12, 31), (13, 5), (16, 2), (16, 31), (19, 31)],
        "{found:?}"
    );
    assert!((mean_words(&found) - (3 + 4 + 31 + 5 + 31) as f64 / 5.0).abs() < 1e-9);
    let text = "[a](b.md#c) ![d](e.png)\n`[f](g)` <https://h.i> [j](https://k.l)\n";
    assert_eq!(targets(text), [(1, "b.md#c"), (1, "e.png")]);
    assert_eq!(slug("What limits it: A/B, `c`"), "what-limits-it-ab-c");
}

/// What users and newcomers read: README, ARCHITECTURE and the pages of docs/.
fn for_users() -> Vec<PathBuf> {
    let mut found = vec![root().join("README.md"), root().join("ARCHITECTURE.md")];
    collect(&root().join("docs"), &mut found);
    found
}

/// Names, as from the root, and texts of documents.
fn read(paths: &[PathBuf]) -> Vec<(String, String)> {
    let name = |path: &PathBuf| path.strip_prefix(root()).unwrap().display().to_string();
    paths.iter().map(|path| (name(path), std::fs::read_to_string(path).unwrap())).collect()
}

/// All documents below a folder, in order of their paths; none of what was built or installed.
fn collect(folder: &Path, into: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut entries: Vec<PathBuf> = entries.collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            if !["target", "node_modules"].contains(&&name[..]) && !name.starts_with('.') {
                collect(&path, into);
            }
        } else if name.ends_with(".md") {
            into.push(path);
        }
    }
}

/// A sentence of a document.
#[derive(Debug)]
struct Sentence {
    /// The line, counted from 1, at which its paragraph, item or cell begins.
    line: usize,
    words: usize,
    is_cell: bool,
    /// Its first words.
    start: String,
}

/// Words of a sentence on average, cells left out; 0 without sentences.
fn mean_words(sentences: &[Sentence]) -> f64 {
    let counted = sentences.iter().filter(|sentence| !sentence.is_cell).map(|one| one.words);
    let (count, words) = counted.fold((0, 0), |(count, sum), words| (count + 1, sum + words));
    f64::from(u32::try_from(words).unwrap()) / f64::from(count.max(1))
}

/// The sentences of a document, in order.
fn sentences(text: &str) -> Vec<Sentence> {
    let mut found = Vec::new();
    for Piece { line, text, is_cell } in pieces(text) {
        let plain = plain(&text);
        let mut sentence: Vec<&str> = Vec::new();
        let mut end = |sentence: &mut Vec<&str>| {
            let words = sentence.iter().filter(|word| word.contains(char::is_alphanumeric)).count();
            if words > 0 {
                let start = sentence[..sentence.len().min(8)].join(" ");
                found.push(Sentence { line, words, is_cell, start });
            }
            sentence.clear();
        };
        for word in plain.split_whitespace() {
            sentence.push(word);
            if word.trim_end_matches([')', '"']).ends_with(['.', '!', '?']) {
                end(&mut sentence);
            }
        }
        end(&mut sentence);
    }
    found
}

/// A paragraph, an item of a list or a cell of a table.
struct Piece {
    line: usize,
    text: String,
    is_cell: bool,
}

fn pieces(text: &str) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::new();
    // Whether the next line goes on with the last piece, and whether that is in a list.
    let (mut goes_on, mut in_list, mut fenced) = (false, false, false);
    for (index, whole) in text.lines().enumerate() {
        let (line, text) = (index + 1, whole.trim());
        let (item, is_item) = match item(text) {
            Some(item) => (item, true),
            None => (text, false),
        };
        if text.starts_with("```") {
            (goes_on, fenced) = (false, !fenced);
        } else if fenced || text.is_empty() {
            goes_on = false;
        } else if text.starts_with('#') {
            (goes_on, in_list) = (false, false);
        } else if text.starts_with('|') {
            goes_on = false;
            let cells = text.trim_matches('|').split('|');
            pieces.extend(cells.map(|cell| Piece { line, text: cell.to_owned(), is_cell: true }));
        } else if is_item {
            (goes_on, in_list) = (true, true);
            pieces.push(Piece { line, text: item.to_owned(), is_cell: false });
        } else if goes_on {
            let last = pieces.last_mut().unwrap();
            last.text.push(' ');
            last.text.push_str(text);
        } else if in_list || !whole.starts_with("    ") {
            (goes_on, in_list) = (true, in_list && whole.starts_with(' '));
            pieces.push(Piece { line, text: text.to_owned(), is_cell: false });
        }
    }
    pieces
}

/// The text of an item of a list.
fn item(text: &str) -> Option<&str> {
    let dashed = text.strip_prefix("- ").or_else(|| text.strip_prefix("* "));
    dashed.or_else(|| {
        let (number, rest) = text.split_once(". ")?;
        (!number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())).then_some(rest)
    })
}

/// A text as it is read: of links their words, and one word for each piece of code.
fn plain(text: &str) -> String {
    let code = text.split('`').enumerate();
    let text: String =
        code.map(|(index, piece)| if index % 2 == 1 { "code" } else { piece }).collect();
    let mut plain = String::new();
    let mut rest = &text[..];
    while let Some((before, link)) = rest.split_once("](") {
        plain.push_str(before);
        rest = link.split_once(')').map_or("", |(_, after)| after);
    }
    plain.push_str(rest);
    plain
}

/// Where relative links of a document lead, each with its line. Code has none.
fn targets(text: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    for (index, line) in text.lines().enumerate() {
        for prose in line.split('`').step_by(2) {
            let links = prose.split("](").skip(1).filter_map(|link| link.split_once(')'));
            let relative = links.map(|(target, _)| target).filter(|target| !target.contains("://"));
            found.extend(relative.map(|target| (index + 1, target)));
        }
    }
    found
}

/// Whether a document has a heading that a link may name.
fn has_heading(document: &Path, wanted: &str) -> bool {
    let text = std::fs::read_to_string(document).unwrap();
    let headings = text.lines().filter_map(|line| line.strip_prefix('#'));
    headings.map(|heading| slug(heading.trim_start_matches('#'))).any(|slug| slug == wanted)
}

/// The name by which a link calls a heading: lower case, hyphens for blanks, other signs left out.
fn slug(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter(|sign| sign.is_alphanumeric() || [' ', '-', '_'].contains(sign));
    kept.map(|sign| if sign == ' ' { '-' } else { sign }).collect()
}
