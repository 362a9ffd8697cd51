//! The table of the contour: what the reference shows of it, and mistakes in it.

use asphera_measure::Guard;

use super::*;

/// The reference with its table of the contour, its lines changed by `change`, in a folder with an outline.
fn with_contour(outline: &str, change: impl Fn(&str) -> String) -> (Result<Config, String>, usize) {
    let text = read(&project("asphera.toml")).unwrap();
    let from = text.find("# [contour]").unwrap();
    let to = text.find("# [parts]").unwrap();
    let shown: String = text[from..to]
        .lines()
        .map(|line| match line.strip_prefix("# ") {
            Some("guard_factor = 2") => String::new(),
            Some(setting) if setting.starts_with('[') || ALTERNATIVES.contains(&setting) => {
                format!("{}\n", change(setting))
            }
            _ => format!("{line}\n"),
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("blade.svg"), outline).unwrap();
    let path = folder.path().join("station.toml");
    fs::write(&path, format!("{}{shown}{}", &text[..from], &text[to..])).unwrap();
    let lines = text[..from].lines().count();
    let name = format!("{}/", folder.path().display());
    (Config::load(&path).map_err(|error| error.to_string().replace(&name, "")), lines)
}

const OUTLINE: &str = "<svg><circle r='4'/></svg>";

const HINTS: &str = "hints = \"1.5,2=hole;8,2=plate\"";

#[test]
fn the_contour_of_the_reference_is_known_and_its_outline_stays_in_the_text() {
    let text = read(&project("asphera.toml")).unwrap();
    assert!(Config::parse("asphera.toml", &text).unwrap().contour.is_none());
    let alpha = |setting: &str| match setting {
        HINTS => String::new(),
        other => other.replace("\"auto\"", "\"alpha\""),
    };
    let config = with_contour(OUTLINE, alpha).0.unwrap();
    let plan = config.contour.as_ref().unwrap();
    assert_eq!(plan.settings.method.name(), "alpha");
    assert_eq!(plan.settings.parameters.value(&plan.settings.method, "alpha_mm"), 0.8);
    assert_eq!(plan.slab.unwrap().within_mm, 0.05);
    assert_eq!((plan.limits.deviation_mm, plan.limits.roundness_mm), (Some(0.02), Some(0.01)));
    assert_eq!(plan.limits.guard, Some(Guard::Probability(0.95)));
    // The folder is gone: a recording of the text is read without the file.
    let again = Config::parse("recorded", &config.text).unwrap();
    assert_eq!(again.contour, config.contour);
}

#[test]
fn mistakes_in_the_contour_are_named_with_their_lines() {
    let wrong = |setting: &str| match setting {
        "method = \"auto\"" => "method = \"alhpa\"".to_owned(),
        "plane = [0, 0, 1, 5]" => "plane = [0, 0, 0, 5]".to_owned(),
        "within_mm = 0.05" => "within_mm = 0".to_owned(),
        "airfoil = false" => "airfiol = true".to_owned(),
        "roundness_mm = 0.01" => "roundness_mm = -1".to_owned(),
        HINTS | "alpha_mm = 0.8" | "[contour.parameters]" => String::new(),
        other => other.to_owned(),
    };
    let (found, lines) = with_contour("<svg/>", wrong);
    let said = found.unwrap_err();
    let expected = [
        ("method", "did you mean \"alpha\"?"),
        ("plane", "[a, b, c, d] of the plane"),
        ("within_mm", "a distance above 0 mm beside plane"),
        ("airfiol", "did you mean `airfoil`?"),
        ("outline", "blade.svg: expected an outline, found no line"),
        ("limits.roundness_mm", "0.000000001 to 1000000"),
    ];
    for (key, words) in expected {
        let line = said.lines().find(|line| line.contains(&format!("contour.{key}")));
        assert!(line.is_some_and(|line| line.contains(words)), "{key}: {words}\n{said}");
    }
    let method = format!("station.toml:{}: contour.method", lines + 3);
    assert!(said.contains(&method), "{method}\n{said}");
    // Parameters of the method only, within their range; limits of the deviation need an outline.
    let parameters = |setting: &str| match setting {
        "method = \"auto\"" => "method = \"alpha\"".to_owned(),
        "alpha_mm = 0.8" => "alpha_mm = -1\nalfa = true".to_owned(),
        HINTS | "outline = \"blade.svg\"" | "plane = [0, 0, 1, 5]" => String::new(),
        other => other.to_owned(),
    };
    let said = with_contour(OUTLINE, parameters).0.unwrap_err();
    for (key, words) in [
        ("parameters.alpha_mm", "0 to "),
        ("parameters.alfa", "alpha_mm"),
        ("limits.deviation_mm", "contour.outline beside it"),
        ("within_mm", "or plane = [a, b, c, d]"),
    ] {
        let line = said.lines().find(|line| line.contains(&format!("contour.{key}")));
        assert!(line.is_some_and(|line| line.contains(words)), "{key}: {words}\n{said}");
    }
}

#[test]
fn a_guard_band_of_the_contour_is_one_and_guards_a_limit() {
    let guard = |lines: &'static str, limits: &'static str| {
        let change = move |setting: &str| match setting {
            "guard_probability = 0.95" => lines.to_owned(),
            "deviation_mm = 0.02" => limits.to_owned(),
            HINTS | "roundness_mm = 0.01" => String::new(),
            "alpha_mm = 0.8" | "[contour.parameters]" => String::new(),
            other => other.to_owned(),
        };
        with_contour(OUTLINE, change).0.map(|config| config.contour.unwrap().limits.guard)
    };
    let limit = "deviation_mm = 0.02";
    assert_eq!(guard("guard_factor = 2.5", limit).unwrap(), Some(Guard::Factor(2.5)));
    assert_eq!(guard("", limit).unwrap(), None);
    for (lines, limits, words) in [
        ("guard_factor = 2\nguard_probability = 0.9", limit, "either guard_factor or"),
        ("guard_probability = 0.5", limit, "0.501 to 0.9999"),
        ("guard_probability = 0.95", "", "a limit beside it"),
    ] {
        let said = guard(lines, limits).unwrap_err();
        let line = said.lines().find(|line| line.contains("contour.limits.guard"));
        assert!(line.is_some_and(|line| line.contains(words)), "{words}\n{said}");
    }
}

#[test]
fn hints_of_the_contour_belong_to_the_methods_that_need_them() {
    let with = |method: &'static str, hints: &'static str| {
        let change = move |setting: &str| match setting {
            "method = \"auto\"" => format!("method = {method:?}"),
            HINTS => hints.to_owned(),
            "alpha_mm = 0.8" | "[contour.parameters]" => String::new(),
            other => other.to_owned(),
        };
        with_contour(OUTLINE, change).0.map(|config| config.contour.unwrap().settings.hints)
    };
    let hints = with("delaunay-painting", HINTS).unwrap();
    let found: Vec<_> = hints.iter().map(|hint| (hint.at_mm, hint.label.as_str())).collect();
    assert_eq!(found, [([1.5, 2.0], "hole"), ([8.0, 2.0], "plate")]);
    for (method, hints, words) in [
        ("colour-by-numbers", "", "a place within each region with its label"),
        ("colour-by-numbers", "hints = \"\"", "a place within each region with its label"),
        ("delaunay-painting", "hints = \"1.5=hole\"", "hint 1: expected x,y=label"),
        ("delaunay-painting", "hints = 7", "contour.hints"),
        ("alpha", HINTS, "method delaunay-painting or colour-by-numbers beside it, found alpha"),
    ] {
        let said = with(method, hints).unwrap_err();
        let line = said.lines().filter(|line| line.contains("contour.hints")).collect::<Vec<_>>();
        assert!(line.len() == 1 && line[0].contains(words), "{method}: {words}\n{said}");
    }
}
