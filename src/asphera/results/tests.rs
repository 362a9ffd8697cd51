//! The HTML page and the QIF document of small measurements.

use std::collections::BTreeSet;

use asphera_report::{Label, SessionFigures, Status};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use asphera_paper::{Provenance, QIF_NAMESPACE, SourceFile, html, qif};

use asphera_measure::{Along, Measurement, Pipeline};

const FLAT: &str = "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 3.0\n\
     [fit]\nfree = [\"tz\", \"rx\", \"ry\"]\n[tolerance]\npv_nm = 100\nrms_nm = 3\n";

/// A disc with 20 nm of astigmatism and a hole of 0.5 mm in it.
fn measured(nominal: &str, along: Along) -> Measurement {
    let mut pipeline =
        Pipeline::along(asphera_nominal::parse("flat.toml", nominal).unwrap(), along);
    for i in -30..=30 {
        for j in -30..=30 {
            let (x, y) = (f64::from(i) * 0.1, f64::from(j) * 0.1);
            if x.hypot(y) <= 3.0 && (x - 1.0).hypot(y) > 0.5 {
                pipeline.take_position([x, y, 20e-6 / 9.0 * (x * x - y * y)]);
            }
        }
    }
    pipeline.finish()
}

fn provenance() -> Provenance {
    Provenance {
        label: Label {
            part: Some("Lens </title><script>alert(1)</script> \"7\" & \u{1b}".to_owned()),
            ..Label::default()
        },
        date: Some("2026-05-04T03:02:01Z".to_owned()),
        instrument: Some("Maker <A> & B".to_owned()),
        files: vec![SourceFile {
            name: "a<b>.xyz".to_owned(),
            bytes: 12_345,
            sha256: "0f".repeat(32),
        }],
        command: "asphera report 'a<b>.xyz'".to_owned(),
    }
}

/// One element with what is in it.
#[derive(Debug, Default)]
struct Element {
    name: String,
    attributes: Vec<(String, String)>,
    children: Vec<Element>,
    text: String,
}

impl Element {
    fn of(start: &BytesStart<'_>) -> Element {
        let attributes = start.attributes().map(|attribute| {
            let attribute = attribute.unwrap();
            let name = attribute.key.into_inner().to_owned();
            (name, attribute.value.as_ref().to_owned())
        });
        Element {
            name: start.name().into_inner().to_owned(),
            attributes: attributes.collect(),
            ..Element::default()
        }
    }

    fn attribute(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(attribute, _)| attribute == name);
        found.map(|(_, value)| value.as_str())
    }

    fn names(&self) -> Vec<&str> {
        self.children.iter().map(|child| child.name.as_str()).collect()
    }

    fn all(&self) -> Vec<&Element> {
        let mut all = vec![self];
        self.children.iter().for_each(|child| all.extend(child.all()));
        all
    }

    fn called(&self, name: &str) -> Vec<&Element> {
        self.all().into_iter().filter(|element| element.name == name).collect()
    }
}

/// Reads XML and fails where it is not well-formed.
fn parsed(xml: &str) -> Element {
    let mut reader = Reader::from_str(xml);
    let mut open = vec![Element::default()];
    loop {
        match reader.read_event().unwrap() {
            Event::Start(start) => open.push(Element::of(&start)),
            Event::Empty(start) => open.last_mut().unwrap().children.push(Element::of(&start)),
            Event::End(_) => {
                let closed = open.pop().unwrap();
                open.last_mut().unwrap().children.push(closed);
            }
            Event::Text(text) => open.last_mut().unwrap().text.push_str(&text.xml10_content()),
            Event::Eof => break,
            _ => {}
        }
    }
    let mut root = open.pop().unwrap();
    assert!(open.is_empty(), "an element is not closed");
    root.children.pop().unwrap()
}

#[test]
fn the_page_is_well_formed_and_needs_nothing_from_elsewhere() {
    let measurement = measured(FLAT, Along::Z);
    let page = html(&measurement, &provenance());
    let root = parsed(&page);
    assert_eq!(root.name, "html");
    for element in root.all() {
        assert!(!["script", "link", "iframe", "object"].contains(&element.name.as_str()));
        for (name, value) in &element.attributes {
            let leads_out = ["href", "src", "srcset", "data", "action"].contains(&name.as_str());
            assert!(!leads_out || value.starts_with("data:image/png;base64,"), "{name}={value}");
            assert!(!name.starts_with("on"), "{name}");
        }
    }
    assert!(!page.contains("<script") && !page.contains("url(") && !page.contains("@import"));
    for heading in [
        "Deviation",
        "Histogram",
        "Sections",
        "Figures",
        "Zernike terms",
        "Fit",
        "Sampling",
        "Defects",
    ] {
        assert!(page.contains(&format!("<h2>{heading}</h2>")), "{heading}");
    }
    assert!(page.contains("Measured 2026-05-04 03:02:01 UTC"));
    assert!(page.contains(&"0f".repeat(32)) && page.contains("a&lt;b&gt;.xyz"));
    assert_eq!(page, html(&measured(FLAT, Along::Z), &provenance()));
}

#[test]
fn figures_of_standards_are_drawn_and_exchanged() {
    let nominal = format!(
        "{FLAT}minimum_zone_nm = 30\n[figures]\nminimum_zone = true\n[figures.texture]\nl_mm = 1.0\n"
    );
    let measurement = measured(&nominal, Along::Z);
    let page = html(&measurement, &provenance());
    let root = parsed(&page);
    for heading in ["Minimum zone", "Surface texture", "Power spectral density", "Slope spectrum"] {
        assert!(page.contains(&format!("<h2>{heading}</h2>")), "{heading}");
    }
    assert!(page.contains("By ISO 10110-5 found 3/") && page.contains("<li>minimum zone "));
    let labels: Vec<&str> =
        root.all().iter().filter_map(|one| one.attribute("aria-label")).collect();
    for label in ["power spectral density", "slope spectrum"] {
        assert!(labels.iter().any(|found| found.contains(label)), "{labels:?}");
    }
    assert!(!page.contains("NaN"));
    let document = parsed(&qif(&measurement.report, &provenance()));
    let all = document.all();
    let names: Vec<&str> = all.iter().filter_map(|one| one.attribute("name")).collect();
    for name in [
        "Sq, S-L / nm",
        "Sku, S-L / 1",
        "PV, minimum zone, of all points used / nm",
        "ISO 10110-5, found",
    ] {
        assert!(names.contains(&name), "{names:?}");
    }
    assert!(all.iter().any(|one| one.name == "Name" && one.text == "minimum zone"));
}

#[test]
fn what_fails_says_by_how_much_and_what_is_missing_why() {
    let page = html(&measured(FLAT, Along::Z), &provenance());
    // RMS of 20·ρ²·cos 2φ is 20/√6 = 8.2 nm: above 3 nm.
    assert!(page.contains("FAIL") && page.contains("nm &gt; 3.000 nm</li>"), "{page}");
    assert!(
        page.contains("Uncertainty (k = 1) by noise only.")
            && page.contains("It does not include errors")
    );
    assert!(
        page.contains(
            "u (k = 1) by residuals, taken as independent. It says how far the best fit "
        )
    );
    let counted = format!("{FLAT}[uncertainty]\ncorrelation = \"deviations\"\n");
    let counted = html(&measured(&counted, Along::Z), &provenance());
    assert!(
        counted
            .contains("u (k = 1) by deviations, correlated as they are. Correlation over about ")
    );
    assert!(counted.contains("Uncertainty (k = 1) by noise only, what is correlated being form."));
    assert!(
        !counted.contains("It says how far") && !counted.contains("It does not include errors")
    );
    assert!(page.contains("Correlation of the parameters") && page.contains("Degrees of freedom"));
    let mut few = Pipeline::new(asphera_nominal::parse("flat.toml", FLAT).unwrap());
    few.take_position([0.0, 0.0, 0.0]);
    let page = html(&few.finish(), &Provenance::default());
    parsed(&page);
    assert!(page.contains("UNDECIDED") && page.contains("no fit:"));
    assert!(page.contains("at a date not stated"));
    assert!(!page.contains("<h2>Figures</h2>") && !page.contains("<svg"));
}

#[test]
fn other_apertures_and_planes_are_drawn_too() {
    let square = FLAT.replace(
        "shape = \"circle\"\nradius_mm = 3.0",
        "shape = \"rectangle\"\nwidth_mm = 9\nheight_mm = 4",
    );
    let everywhere = FLAT.replace("[aperture]\nshape = \"circle\"\nradius_mm = 3.0\n", "");
    for (nominal, along) in
        [(square.as_str(), Along::Z), (&everywhere, Along::Z), (FLAT, "0,0.1,1".parse().unwrap())]
    {
        let page = html(&measured(nominal, along), &Provenance::default());
        parsed(&page);
        assert!(page.contains("data:image/png;base64,"), "{nominal}");
    }
    let tilted = html(&measured(FLAT, "0,0.1,1".parse().unwrap()), &Provenance::default());
    assert!(tilted.contains("u of the plane of projection"));
}

/// The rules of the schemas of QIF 3.0 that concern the elements used here: QIFDocument.xsd (order, unique
/// ids, references), QIFResults.xsd and Characteristics.xsd (order within each, counts).
#[test]
fn the_qif_document_keeps_the_rules_of_its_schemas() {
    let mut measurement = measured(FLAT, Along::Z);
    measurement.report.session = Some(SessionFigures {
        id: "session-1".to_owned(),
        started: "2026-05-04T03:02:01Z".to_owned(),
        ..SessionFigures::default()
    });
    let document = qif(&measurement.report, &provenance());
    assert_eq!(document, qif(&measurement.report, &provenance()));
    let root = parsed(&document);
    assert_eq!((root.name.as_str(), root.attribute("xmlns")), ("QIFDocument", Some(QIF_NAMESPACE)));
    assert_eq!(root.attribute("versionQIF"), Some("3.0.0"));
    let order =
        ["QPId", "Header", "StandardsDefinitions", "FileUnits", "Characteristics", "Results"];
    assert_eq!(root.names(), order);

    let ids: Vec<u64> =
        root.all().iter().filter_map(|e| e.attribute("id")).map(|id| id.parse().unwrap()).collect();
    assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len(), "an id is not unique");
    let largest = ids.iter().max().unwrap().to_string();
    assert_eq!(root.attribute("idMax"), Some(largest.as_str()));
    for element in root.all() {
        if let Some(count) = element.attribute("n") {
            assert_eq!(count, element.children.len().to_string(), "{}", element.name);
        }
    }
    let ids_of = |name: &str| -> BTreeSet<String> {
        root.called(name).iter().map(|e| e.attribute("id").unwrap().to_owned()).collect()
    };
    for (reference, target) in [
        ("FormalStandardId", "Standard"),
        ("CharacteristicDefinitionId", "OtherFormCharacteristicDefinition"),
        ("CharacteristicNominalId", "OtherFormCharacteristicNominal"),
        ("CharacteristicItemId", "OtherFormCharacteristicItem"),
    ] {
        let found: BTreeSet<String> =
            root.called(reference).iter().map(|e| e.text.clone()).collect();
        assert_eq!(found, ids_of(target), "{reference}");
    }
    for (name, order) in [
        ("OtherFormCharacteristicDefinition", &["Description", "Name", "ToleranceValue"][..]),
        ("OtherFormCharacteristicNominal", &["CharacteristicDefinitionId", "Name"]),
        ("OtherFormCharacteristicItem", &["Name", "CharacteristicNominalId"]),
        (
            "OtherFormCharacteristicMeasurement",
            &["Status", "CharacteristicItemId", "TimeStamp", "Value"],
        ),
        ("Standard", &["Organization", "Designator", "Year"]),
        ("MeasurementResults", &["Attributes", "MeasuredCharacteristics", "InspectionStatus"]),
    ] {
        let found = root.called(name);
        assert!(!found.is_empty(), "{name}");
        found.iter().for_each(|element| assert_eq!(element.names(), order, "{name}"));
    }
    let attributes = root.called("AttributeStr");
    let names: BTreeSet<_> = attributes.iter().map(|one| one.attribute("name")).collect();
    assert_eq!(names.len(), attributes.len(), "an attribute is not unique");
    let value = |index: usize| -> f64 { root.called("Value")[index].text.parse().unwrap() };
    let deviation = &measurement.report.form.as_ref().unwrap().deviation;
    assert!((value(0) - deviation.pv_nm * 1e-6).abs() < 1e-12);
    assert!((value(1) - deviation.rms_nm * 1e-6).abs() < 1e-12);
    let statuses: Vec<&str> =
        root.called("CharacteristicStatusEnum").iter().map(|e| e.text.as_str()).collect();
    assert_eq!(statuses, ["PASS", "FAIL"]);
    assert_eq!(root.called("InspectionStatusEnum")[0].text, "FAIL");
    let factor = &root.called("Factor")[0].text;
    assert_eq!(factor, "0.001", "values are in mm");
}

#[test]
fn an_undecided_part_is_no_pass_in_qif() {
    let mut measurement = measured(FLAT, Along::Z);
    measurement.report.verdict.status = Status::Undecided;
    let root = parsed(&qif(&measurement.report, &Provenance::default()));
    let statuses = root.called("CharacteristicStatusEnum");
    assert!(statuses.iter().all(|status| status.text == "INDETERMINATE"));
    assert_eq!(root.called("InspectionStatusEnum")[0].text, "UNKNOWN");
    // Without a tolerance there is no characteristic, and the figures are there all the same.
    measurement.report.verdict.checks.clear();
    let root = parsed(&qif(&measurement.report, &Provenance::default()));
    assert!(root.called("Characteristics").is_empty());
    let figures = root.called("AttributeStr");
    assert!(figures.iter().any(|figure| figure.attribute("name") == Some("B, as fitted / nm")));
}

/// A folder that stands where `mesh.ply` should go keeps it from its place, as a full disk does.
#[test]
fn a_file_that_cannot_be_written_leaves_nothing_behind_and_keeps_no_other() {
    use asphera_report::ResultFile;
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(folder.path().join("mesh.ply/x")).unwrap();
    let files = [ResultFile::Mesh, ResultFile::Report, ResultFile::Html];
    let measurement = measured(FLAT, Along::Z);
    let error = super::write_files(folder.path(), &files, &measurement, &provenance()).unwrap_err();
    assert!(error.to_string().ends_with("mesh.ply"), "{error}");
    let entries = std::fs::read_dir(folder.path()).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["mesh.ply", "report.html", "report.json"]);
}

/// What the command line says of the part goes before what the session says.
#[test]
fn a_report_names_part_serial_number_and_operator() {
    let mut measurement = measured(FLAT, Along::Z);
    let given = Label {
        serial: Some("17".to_owned()),
        operator: Some("Ada".to_owned()),
        ..Label::default()
    };
    let provenance = Provenance { label: given, ..Provenance::default() };
    for part in [None, Some("Lens 7".to_owned())] {
        if part.is_some() {
            let label = Label { part, serial: Some("3".to_owned()), operator: None };
            measurement.report.session =
                Some(SessionFigures { label, ..SessionFigures::default() });
        }
        let page = html(&measurement, &provenance);
        let title = match measurement.report.session {
            None => "Form deviation: no. 17",
            Some(_) => "Form deviation: Lens 7, no. 17",
        };
        assert!(page.contains(title) && page.contains("Ada"), "{title}");
        let document = qif(&measurement.report, &provenance);
        assert!(document.contains("Ada") && document.contains("17"));
    }
}
